#include "sinew/io/svo/container.h"

#include <bit>
#include <cstring>
#include <string>

#include "sinew/base/packing.h"

namespace sinew::svo_file {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kMagic[8] = {'s', 'i', 'n', 'e', 'w', 's', 'v', 'o'};
constexpr uint32_t kVersion = 2;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t octrees;
  uint64_t size;
  uint64_t checksum;
};
static_assert(sizeof(Header) == 32);

struct SceneHeader {
  uint64_t unpacked;
  uint64_t checksum;
};
static_assert(sizeof(SceneHeader) == 16);

uint64_t checksum_of(const Header& header, std::span<const uint8_t> table) {
  std::vector<uint8_t> bytes(offsetof(Header, checksum));
  std::memcpy(bytes.data(), &header, bytes.size());
  bytes.insert(bytes.end(), table.begin(), table.end());
  return checksum(bytes);
}

tl::unexpected<Error> damaged(std::string problem) {
  return fail({ErrorKind::bad_input, "", "", std::move(problem),
               "make the file again with `sinew voxelize`"});
}

}  // namespace

Result<uint64_t> table_end(std::span<const uint8_t> bytes, uint64_t size) {
  Header header;
  if (bytes.size() < sizeof(kMagic) || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    return damaged("is no .svo file of sinew");
  }
  if (bytes.size() < sizeof(Header)) return damaged("ends too soon");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.version != kVersion) {
    return damaged("is of version " + std::to_string(header.version) + ", this program reads " +
                   std::to_string(kVersion));
  }
  if (header.size != size) {
    return damaged("has " + std::to_string(size) + " bytes, not " + std::to_string(header.size));
  }
  const uint64_t end = sizeof(Header) + 8 * (uint64_t{header.octrees} + 1);
  if (size < end) return damaged("ends too soon");
  return end;
}

Result<SectionTable> read_table(std::span<const uint8_t> bytes, uint64_t size) {
  SINEW_TRY(const uint64_t end, table_end(bytes, size));
  if (bytes.size() < end) return damaged("ends too soon");
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  const std::span<const uint8_t> table = bytes.subspan(sizeof(Header), end - sizeof(Header));
  if (checksum_of(header, table) != header.checksum) {
    return damaged("is damaged: the header's checksum does not fit");
  }
  SectionTable sections;
  uint64_t at = end;
  for (uint64_t i = 0; i <= header.octrees; ++i) {
    SectionPlace place{at, 0};
    std::memcpy(&place.size, table.data() + 8 * i, 8);
    if (place.size > size - at) return damaged("ends too soon");
    at += place.size;
    if (i == 0) {
      sections.scene = place;
    } else {
      sections.octrees.push_back(place);
    }
  }
  if (at != size) return damaged("has bytes after its end");
  return sections;
}

Result<Sections> find_sections(std::span<const uint8_t> bytes) {
  SINEW_TRY(const SectionTable table, read_table(bytes, bytes.size()));
  Sections sections;
  sections.scene = bytes.subspan(table.scene.offset, table.scene.size);
  for (const SectionPlace& place : table.octrees) {
    sections.octrees.push_back(bytes.subspan(place.offset, place.size));
  }
  return sections;
}

std::vector<uint8_t> make_header(uint64_t scene, std::span<const uint64_t> octrees) {
  std::vector<uint64_t> table = {scene};
  table.insert(table.end(), octrees.begin(), octrees.end());
  Header header = {};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kVersion;
  header.octrees = static_cast<uint32_t>(octrees.size());
  header.size = sizeof(Header) + 8 * table.size();
  for (const uint64_t size : table) header.size += size;
  const auto* const table_bytes = reinterpret_cast<const uint8_t*>(table.data());
  header.checksum = checksum_of(header, {table_bytes, 8 * table.size()});
  std::vector<uint8_t> bytes(sizeof(Header));
  std::memcpy(bytes.data(), &header, sizeof(Header));
  bytes.insert(bytes.end(), table_bytes, table_bytes + 8 * table.size());
  return bytes;
}

std::vector<uint8_t> pack_scene(std::span<const uint8_t> glb, int effort) {
  const Packed packed = pack(glb, {}, effort);
  const SceneHeader header{glb.size(), checksum(packed.bytes)};
  std::vector<uint8_t> section(sizeof(SceneHeader));
  std::memcpy(section.data(), &header, sizeof(SceneHeader));
  // The size is under the checksum too.
  section.insert(section.end(), packed.bytes.begin(), packed.bytes.end());
  const uint64_t whole = checksum({section.data(), 8}) ^ header.checksum;
  std::memcpy(section.data() + offsetof(SceneHeader, checksum), &whole, 8);
  return section;
}

Result<std::vector<uint8_t>> unpack_scene(std::span<const uint8_t> section, uint64_t limit) {
  SceneHeader header;
  if (section.size() < sizeof(SceneHeader)) return damaged("its scene ends too soon");
  std::memcpy(&header, section.data(), sizeof(SceneHeader));
  const std::span<const uint8_t> packed = section.subspan(sizeof(SceneHeader));
  if ((checksum(section.first(8)) ^ checksum(packed)) != header.checksum) {
    return damaged("is damaged: the checksum of its scene does not fit");
  }
  if (header.unpacked > most_unpacked(packed.size())) {
    return damaged("its scene claims an impossible size");
  }
  if (header.unpacked > limit) {
    return fail({ErrorKind::bad_input, "", "",
                 "its scene has " + std::to_string(header.unpacked) + " bytes, but at most " +
                     std::to_string(limit) + " are allowed",
                 "raise the memory limit or use a smaller file"});
  }
  std::vector<uint8_t> glb(header.unpacked);
  if (!unpack(packed, glb)) return damaged("its scene cannot be unpacked");
  return glb;
}

}  // namespace sinew::svo_file
