// Octrees to bytes.
#include <cstring>
#include <limits>

#include "sinew/base/packing.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/file/file_layout.h"

namespace sinew {
namespace svo_file {
namespace {

struct PackedPage {
  std::vector<uint8_t> bytes;
  uint32_t unpacked = 0;
  SvoFileParts parts;
};
using PackedPages = std::vector<PackedPage>;  // one a block

std::vector<SvoPage> list_pages(const PackedPages& pages) {
  std::vector<SvoPage> list;
  for (const PackedPage& page : pages) {
    list.push_back(
        {0, page.unpacked, static_cast<uint32_t>(page.bytes.size()), checksum(page.bytes)});
  }
  return list;
}

PackedPage pack_page(const StreamWriter& page, int effort) {
  PackedPage result;
  Packed packed = pack(page.bytes(), page.ends(), effort);
  result.unpacked = static_cast<uint32_t>(page.bytes().size());
  size_t begin = 0;
  for (size_t i = 0; i < page.ends().size(); ++i) {
    *part_of(result.parts, page.parts()[i]) += packed.ends[i] - begin;
    begin = packed.ends[i];
  }
  result.bytes = std::move(packed.bytes);
  return result;
}

void write_nodes(const Svo& svo, StreamWriter& out) {
  const size_t count = svo.nodes.size();
  out.add<uint8_t>(Part::tables, count, [&](size_t i) { return svo.nodes[i].level; });
  out.add<uint16_t>(Part::tables, count, [&](size_t i) { return svo.nodes[i].count; });
  FirstChild first;
  std::vector<uint32_t> differences;
  for (const SvoNode& node : svo.nodes) {
    differences.push_back(node.first - first.guess(node));
    first.add(node);
  }
  out.add(Part::tables, differences);
  write_level(svo.node_level, 0, count, Part::tables, out);
}

void write_table(std::span<const SvoPage> pages, StreamWriter& out) {
  out.add<uint32_t>(Part::tables, pages.size(), [&](size_t i) { return pages[i].unpacked; });
  out.add<uint32_t>(Part::tables, pages.size(), [&](size_t i) { return pages[i].packed; });
  out.add<uint64_t>(Part::tables, pages.size(), [&](size_t i) { return pages[i].checksum; });
}

void write_blocks(const Svo& svo, StreamWriter& out) {
  const uint32_t blocks = svo.block_count();
  for (uint16_t SvoBlock::*axis : {&SvoBlock::x, &SvoBlock::y, &SvoBlock::z}) {
    out.add<uint16_t>(Part::tables, blocks, [&](size_t i) {
      const int before = i == 0 ? 0 : svo.blocks[i - 1].*axis;
      return fold(static_cast<uint16_t>(svo.blocks[i].*axis - before));
    });
  }
  std::vector<std::array<uint32_t, kCounts>> counts;
  for (uint32_t i = 0; i < blocks; ++i) {
    counts.push_back(std::bit_cast<std::array<uint32_t, kCounts>>(counts_of(svo, i)));
  }
  for (size_t k = 0; k < kCounts; ++k) {
    out.add<uint32_t>(Part::tables, blocks, [&](size_t i) { return counts[i][k]; });
  }
}

StreamWriter write_head(const Svo& svo, std::span<const SvoPage> skeletons,
                        std::span<const SvoPage> details, SvoFileParts& parts) {
  HeadNumbers numbers;
  numbers.name = static_cast<uint32_t>(svo.name.size());
  numbers.voxel = std::bit_cast<uint32_t>(svo.grid.voxel);
  for (int axis = 0; axis < 3; ++axis) {
    numbers.origin[axis] = std::bit_cast<uint32_t>(svo.grid.origin[axis]);
    numbers.resolution[axis] = svo.grid.resolution[axis];
  }
  numbers.joints = svo.joints;
  numbers.morph_targets = svo.morph_targets;
  numbers.morph_weights = static_cast<uint32_t>(svo.morph_weights.size());
  numbers.root_level = svo.root_level;
  numbers.nodes = static_cast<uint32_t>(svo.nodes.size());
  numbers.blocks = static_cast<uint32_t>(svo.blocks.size());
  const auto words = std::bit_cast<std::array<uint32_t, kHeadNumbers>>(numbers);
  StreamWriter out;
  out.add<uint32_t>(Part::tables, words.size(), [&](size_t i) { return words[i]; });
  out.add<uint64_t>(Part::tables, kStoredParts,
                    [&](size_t i) { return *part_of(parts, static_cast<Part>(i + 1)); });
  out.add<uint8_t>(Part::tables, svo.name.size(), [&](size_t i) { return svo.name[i]; });
  out.add<uint32_t>(Part::tables, svo.morph_weights.size(),
                    [&](size_t i) { return std::bit_cast<uint32_t>(svo.morph_weights[i]); });
  write_nodes(svo, out);
  write_blocks(svo, out);
  write_table(skeletons, out);
  write_table(details, out);
  return out;
}

// What stands before the pages. `parts` are those of the pages.
std::vector<uint8_t> make_front(const Svo& svo, std::span<const SvoPage> skeletons,
                                std::span<const SvoPage> details, const PageFormat& format,
                                int effort, SvoFileParts& parts) {
  const StreamWriter head = write_head(svo, skeletons, details, parts);
  const Packed packed = pack(head.bytes(), head.ends(), effort);
  Header header;
  header.flags = (format.skinned ? kSkinned : 0) | (format.colors ? kColors : 0) |
                 (format.levels ? kLevels : 0);
  header.head_unpacked = head.bytes().size();
  header.head_packed = packed.bytes.size();
  header.head_checksum = checksum(packed.bytes);
  header.size = sizeof(Header) + packed.bytes.size();
  parts.tables = header.size;
  for (const SvoPage& page : skeletons) header.size += page.packed;
  for (const SvoPage& page : details) header.size += page.packed;
  header.checksum = checksum_of(header);
  std::vector<uint8_t> bytes(sizeof(Header));
  std::memcpy(bytes.data(), &header, sizeof(Header));
  bytes.insert(bytes.end(), packed.bytes.begin(), packed.bytes.end());
  return bytes;
}

EncodedSvo encode(const Svo& svo, const PageFormat& format, int effort) {
  PackedPages skeletons(svo.block_count()), details(svo.block_count());
  parallel_for(details.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      StreamWriter skeleton, detail;
      write_skeleton(svo, static_cast<uint32_t>(i), format, skeleton);
      write_detail(svo, static_cast<uint32_t>(i), format, detail);
      skeletons[i] = pack_page(skeleton, effort);
      details[i] = pack_page(detail, effort);
    }
  });
  EncodedSvo result;
  for (const PackedPages* const pages : {&skeletons, &details}) {
    for (const PackedPage& page : *pages) result.parts.add(page.parts);
  }
  result.bytes =
      make_front(svo, list_pages(skeletons), list_pages(details), format, effort, result.parts);
  for (const PackedPages* const pages : {&skeletons, &details}) {
    for (const PackedPage& page : *pages) {
      result.bytes.insert(result.bytes.end(), page.bytes.begin(), page.bytes.end());
    }
  }
  return result;
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const SvoLevel& a, const SvoLevel& b) {
  return same(a.normals, b.normals) && same(a.colors, b.colors) && same(a.spreads, b.spreads);
}

}  // namespace
}  // namespace svo_file

void SvoFileParts::add(const SvoFileParts& other) {
  tables += other.tables;
  topology += other.topology;
  normals += other.normals;
  colors += other.colors;
  levels += other.levels;
  lattice += other.lattice;
}

bool is_same(const Svo& a, const Svo& b) {
  using svo_file::same;
  const bool looks =
      same(a.normals, b.normals) && same(a.colors, b.colors) && same(a.color_ends, b.color_ends) &&
      same(a.color_selectors, b.color_selectors) && same(a.brick_level, b.brick_level) &&
      same(a.cell_level, b.cell_level) && same(a.node_level, b.node_level);
  return looks && a.name == b.name && a.grid.origin == b.grid.origin &&
         a.grid.voxel == b.grid.voxel && a.grid.resolution == b.grid.resolution &&
         a.joints == b.joints && a.morph_targets == b.morph_targets &&
         a.root_level == b.root_level && same(a.morph_weights, b.morph_weights) &&
         same(a.nodes, b.nodes) && same(a.blocks, b.blocks) && same(a.cells, b.cells) &&
         same(a.bricks, b.bricks) && same(a.corner_places, b.corner_places) &&
         same(a.corner_joints, b.corner_joints) && same(a.corner_weights, b.corner_weights) &&
         same(a.joint_palette, b.joint_palette) && same(a.targets, b.targets) &&
         same(a.deltas, b.deltas);
}

Result<EncodedSvo> encode_svo(const Svo& svo, int effort) {
  constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();
  if (const std::string problem = validate(svo); !problem.empty()) {
    return fail({ErrorKind::bad_input, svo.name, "", problem, "correct the octree"});
  }
  for (const bool levels : {false, true}) {
    EncodedSvo encoded =
        svo_file::encode(svo, {!svo.corner_joints.empty(), !svo.colors.empty(), levels}, effort);
    SINEW_TRY(const Svo again, decode_svo(encoded.bytes, kNoLimit));
    if (is_same(svo, again)) return encoded;
  }
  return fail({ErrorKind::bad_input, svo.name, "", "its octree is not in the order of the format",
               "make the octree again"});
}

Result<void> SvoEncoder::add(const Svo& part) {
  SINEW_TRY(const EncodedSvo encoded, encode_svo(part, effort_));
  constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();
  SINEW_TRY(const SvoIndex index, decode_svo_index(encoded.bytes, kNoLimit));
  if (index.levels) {
    return fail({ErrorKind::bad_input, part.name, "",
                 "level 2 of a part is not what its voxels make", "make the octree again"});
  }
  const auto take = [&](std::span<const SvoPage> from, std::vector<SvoPage>& pages,
                        const Sink& sink) -> Result<void> {
    uint64_t size = 0;
    for (const SvoPage& page : from) size += page.packed;
    pages.insert(pages.end(), from.begin(), from.end());
    return from.empty() ? Result<void>()
                        : sink(std::span(encoded.bytes).subspan(from.front().offset, size));
  };
  SINEW_CHECKED(take(index.skeletons, skeletons_, skeleton_sink_));
  SINEW_CHECKED(take(index.details, details_, detail_sink_));
  skinned_ = index.skinned;
  colors_ = index.colors;
  parts_.add(encoded.parts);
  return {};
}

EncodedSvo SvoEncoder::finish(const Svo& outline) {
  EncodedSvo front;
  front.parts = parts_;
  front.bytes = svo_file::make_front(outline, skeletons_, details_, {skinned_, colors_, false},
                                     effort_, front.parts);
  return front;
}

}  // namespace sinew
