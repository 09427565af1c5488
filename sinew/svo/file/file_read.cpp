// Bytes to octrees, and trusting none of them.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "sinew/base/packing.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/file/file_layout.h"
#include "sinew/svo/levels.h"

namespace sinew {
namespace svo_file {
namespace {

Result<Header> read_header(std::span<const uint8_t> bytes, uint64_t size) {
  Header header;
  if (bytes.size() < sizeof(Header)) return damaged("its octree ends too soon");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.magic == kFirstMagic) {
    return damaged("its octree is of version 1, this program reads version 2");
  }
  if (header.magic != kMagic) return damaged("its octree is of a kind that is not known");
  if (header.checksum != checksum_of(header)) {
    return damaged("its octree is damaged: the header's checksum does not fit");
  }
  if (header.flags > (kSkinned | kColors | kLevels)) return damaged("its octree has unknown flags");
  if (header.size != size) {
    return damaged("its octree has " + std::to_string(size) + " bytes, not " +
                   std::to_string(header.size));
  }
  if (header.head_packed > size - sizeof(Header)) {
    return damaged("its octree ends too soon");
  }
  return header;
}

// The packed bytes as they were before, if they fit into what is left of the memory.
Result<std::vector<uint8_t>> unpack_checked(std::span<const uint8_t> packed, uint64_t size,
                                            uint64_t expected, uint64_t limit) {
  if (checksum(packed) != expected) return damaged("its octree is damaged: a checksum differs");
  if (size > most_unpacked(packed.size())) return damaged("its octree claims an impossible size");
  if (size > limit) {
    return fail({ErrorKind::bad_input, "", "",
                 "needs more memory than the limit of " + std::to_string(limit) + " bytes",
                 "raise the memory limit or use a smaller file"});
  }
  std::vector<uint8_t> bytes(size);
  if (!unpack(packed, bytes)) return damaged("its octree cannot be unpacked");
  return bytes;
}

void resize(SvoLevel& level, size_t count) {
  level.normals.resize(count);
  level.colors.resize(count);
  level.spreads.resize(count);
}

// Of SvoColorEnds' selectors.
uint64_t words_of(uint32_t voxels) {
  return (uint64_t{voxels} + 15) / 16;
}

PageFormat format_of(const SvoIndex& index) {
  return {index.skinned, index.colors, index.levels};
}

bool read_nodes(StreamReader& in, size_t count, Svo& svo) {
  const std::vector<uint8_t> levels = in.take<uint8_t>(count);
  const std::vector<uint16_t> counts = in.take<uint16_t>(count);
  const std::vector<uint32_t> differences = in.take<uint32_t>(count);
  if (!in.ok()) return false;
  FirstChild first;
  for (size_t i = 0; i < count; ++i) {
    SvoNode node{0, counts[i], levels[i], 0};
    node.first = first.guess(node) + differences[i];
    first.add(node);
    svo.nodes.push_back(node);
  }
  resize(svo.node_level, count);
  return read_level(in, 0, count, svo.node_level);
}

// Adds the sizes to where the block's arrays begin; false if they are more than the format holds.
bool advance(const SvoBlock& from, const Counts& counts, SvoBlock& to) {
  constexpr uint64_t kMost = std::numeric_limits<uint32_t>::max();
  bool fits = true;
  const auto add = [&](uint32_t first, uint32_t count, uint32_t& out) {
    fits = fits && uint64_t{first} + count <= kMost;
    out = first + count;
  };
  add(from.first_cell, counts.cells, to.first_cell);
  add(from.first_corner, counts.corners, to.first_corner);
  add(from.first_brick, counts.bricks, to.first_brick);
  add(from.first_voxel, counts.voxels, to.first_voxel);
  add(from.first_joint, counts.joints, to.first_joint);
  add(from.first_target, counts.targets, to.first_target);
  return fits && counts.corners <= kMostCorners;
}

uint64_t deltas_of(const Svo& svo) {
  uint64_t sum = 0;
  for (uint32_t i = 0; i < svo.block_count(); ++i) {
    const Counts counts = counts_of(svo, i);
    sum += uint64_t{counts.targets} * counts.corners;
  }
  return sum;
}

// What the head knows of one kind of pages.
struct PageTable {
  std::vector<uint32_t> unpacked, packed;
  std::vector<uint64_t> checksums;
};
PageTable read_table(StreamReader& in, size_t count) {
  PageTable table;
  table.unpacked = in.take<uint32_t>(count);
  table.packed = in.take<uint32_t>(count);
  table.checksums = in.take<uint64_t>(count);
  return table;
}

// Adds the pages, which begin at `next`. `least` and `spare`: bytes that the one of a block has
// unpacked, and how many more it may have: so sizes claim no memory without bytes.
template <class Least, class Spare>
Result<void> place_pages(const PageTable& table, uint64_t size, const Least& least,
                         const Spare& spare, uint64_t& next, std::vector<SvoPage>& out) {
  for (uint32_t i = 0; i < table.packed.size(); ++i) {
    const uint32_t unpacked = table.unpacked[i], packed = table.packed[i];
    if (unpacked > most_unpacked(packed) || unpacked < least(i) || unpacked > least(i) + spare(i)) {
      return damaged("a block is larger than its page");
    }
    if (packed > size - next) return damaged("its octree ends too soon");
    out.push_back({next, unpacked, packed, table.checksums[i]});
    next += packed;
  }
  return {};
}

Result<void> read_pages(StreamReader& in, size_t count, uint64_t first_page, uint64_t size,
                        SvoIndex& out) {
  const PageTable skeletons = read_table(in, count), details = read_table(in, count);
  if (!in.ok()) return damaged("its octree's head ends too soon");
  const PageFormat format = format_of(out);
  const auto counts = [&](uint32_t i) { return counts_of(out.svo, i); };
  SINEW_CHECKED(place_pages(
      skeletons, size, [&](uint32_t i) { return skeleton_size(counts(i), format); },
      [](uint32_t) { return uint64_t{0}; }, first_page, out.skeletons));
  SINEW_CHECKED(place_pages(
      details, size, [&](uint32_t i) { return detail_size(counts(i), format) + counts(i).bricks; },
      [&](uint32_t i) { return uint64_t{7} * counts(i).bricks; }, first_page, out.details));
  if (first_page != size) return damaged("its octree has bytes after its end");
  return {};
}

Result<void> read_blocks(StreamReader& in, size_t entries, uint64_t first_page, uint64_t size,
                         SvoIndex& out) {
  if (entries == 0) {
    if (first_page != size) return damaged("its octree has bytes after its end");
    return {};
  }
  const size_t count = entries - 1;
  std::array<std::vector<uint16_t>, 3> places;
  std::array<std::vector<uint32_t>, kCounts> counts;
  for (auto& plane : places) plane = in.take<uint16_t>(count);
  for (auto& plane : counts) plane = in.take<uint32_t>(count);
  if (!in.ok()) return damaged("its octree's head ends too soon");
  std::vector<SvoBlock>& blocks = out.svo.blocks;
  blocks.resize(entries);
  std::array<uint16_t, 3> place{};
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      place[k] = static_cast<uint16_t>(place[k] + unfold(places[k][i]));
    }
    blocks[i].x = place[0], blocks[i].y = place[1], blocks[i].z = place[2];
    std::array<uint32_t, kCounts> numbers;
    for (size_t k = 0; k < kCounts; ++k) numbers[k] = counts[k][i];
    const Counts own = std::bit_cast<Counts>(numbers);
    if (!advance(blocks[i], own, blocks[i + 1])) return damaged("a block has impossible sizes");
  }
  SINEW_CHECKED(read_pages(in, count, first_page, size, out));
  if (deltas_of(out.svo) > std::numeric_limits<uint32_t>::max()) {
    return damaged("it has more morph deltas than the format holds");
  }
  return {};
}

constexpr uint64_t kLevelEntry = 5;

// Memory of what skeletons hold, and of what is there without pages.
uint64_t skeleton_memory(const SvoIndex& index) {
  const Svo& svo = index.svo;
  if (svo.blocks.empty()) return svo.bytes();
  const SvoBlock& end = svo.blocks.back();
  uint64_t sum = svo.bytes() + uint64_t{end.first_cell} * (sizeof(SvoCell) + kLevelEntry);
  sum += uint64_t{end.first_corner} * (index.skinned ? 14 : 2) + uint64_t{end.first_joint} * 2;
  return sum + uint64_t{end.first_target} * sizeof(SvoTarget) + deltas_of(svo) * 6;
}

uint64_t detail_memory(const SvoIndex& index) {
  const Svo& svo = index.svo;
  if (svo.blocks.empty()) return 0;
  const SvoBlock& end = svo.blocks.back();
  uint64_t sum = uint64_t{end.first_brick} * (sizeof(uint64_t) + kLevelEntry);
  sum += uint64_t{2} * end.first_voxel;
  if (index.colors) {
    sum += uint64_t{2} * end.first_voxel;
  } else {
    sum += sizeof(SvoColorEnds) * uint64_t{end.first_brick} + 4 * words_of(end.first_voxel);
  }
  return sum;
}

Result<SvoIndex> read_head(std::span<const uint8_t> head, const Header& header) {
  StreamReader in(head);
  const std::vector<uint32_t> words = in.take<uint32_t>(kHeadNumbers);
  const std::vector<uint64_t> parts = in.take<uint64_t>(kStoredParts);
  if (!in.ok()) return damaged("its octree's head ends too soon");
  std::array<uint32_t, kHeadNumbers> array;
  std::copy(words.begin(), words.end(), array.begin());
  const auto numbers = std::bit_cast<HeadNumbers>(array);
  SvoIndex out;
  out.skinned = (header.flags & kSkinned) != 0;
  out.colors = (header.flags & kColors) != 0;
  out.levels = (header.flags & kLevels) != 0;
  const uint64_t first_page = sizeof(Header) + header.head_packed;
  out.parts.tables = first_page;
  for (size_t i = 0; i < kStoredParts; ++i) {
    *part_of(out.parts, static_cast<Part>(i + 1)) = parts[i];
  }
  Svo& svo = out.svo;
  const std::vector<uint8_t> name = in.take<uint8_t>(numbers.name);
  svo.name.assign(name.begin(), name.end());
  svo.grid.voxel = std::bit_cast<float>(numbers.voxel);
  for (int axis = 0; axis < 3; ++axis) {
    svo.grid.origin[axis] = std::bit_cast<float>(numbers.origin[axis]);
    svo.grid.resolution[axis] = numbers.resolution[axis];
  }
  svo.joints = numbers.joints;
  svo.morph_targets = numbers.morph_targets;
  svo.root_level = numbers.root_level;
  for (const uint32_t bits : in.take<uint32_t>(numbers.morph_weights)) {
    svo.morph_weights.push_back(std::bit_cast<float>(bits));
  }
  if (!in.ok() || !read_nodes(in, numbers.nodes, svo)) {
    return damaged("its octree's head ends too soon");
  }
  SINEW_CHECKED(read_blocks(in, numbers.blocks, first_page, header.size, out));
  if (!in.at_end()) return damaged("its octree's head has bytes after its end");
  out.detail_bytes = detail_memory(out);
  out.bytes = skeleton_memory(out) + out.detail_bytes;
  return out;
}

Result<SvoIndex> decode_front(std::span<const uint8_t> front, uint64_t size, uint64_t limit) {
  SINEW_TRY(const Header header, read_header(front, size));
  if (header.head_packed > front.size() - sizeof(Header)) {
    return damaged("its octree ends too soon");
  }
  SINEW_TRY(const std::vector<uint8_t> head,
            unpack_checked(front.subspan(sizeof(Header), header.head_packed), header.head_unpacked,
                           header.head_checksum, limit));
  return read_head(head, header);
}

// A page unpacked.
Result<std::vector<uint8_t>> open_page(const SvoPage& page, std::span<const uint8_t> bytes) {
  if (bytes.size() != page.packed) return damaged("its octree ends too soon");
  return unpack_checked(bytes, page.unpacked, page.checksum, std::numeric_limits<uint64_t>::max());
}

Result<Svo> decode(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(SvoIndex index, decode_svo_index(bytes, limit));
  allocate_pages(index);
  Svo svo = std::move(index.svo);
  index.svo = {};
  std::vector<Result<void>> results(index.skeletons.size());
  parallel_for(results.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t block = static_cast<uint32_t>(i);
      const auto page = [&](const SvoPage& p) { return bytes.subspan(p.offset, p.packed); };
      results[i] = decode_skeleton(index, page(index.skeletons[i]), block, svo);
      if (results[i]) results[i] = decode_detail(index, page(index.details[i]), block, svo);
    }
  });
  for (const Result<void>& result : results) SINEW_CHECKED(result);
  parallel_for(results.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) fill_level(index, static_cast<uint32_t>(i), svo);
  });
  return svo;
}

}  // namespace
}  // namespace svo_file

Result<SvoIndex> decode_svo_index(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(SvoIndex index, svo_file::decode_front(bytes, bytes.size(), limit));
  if (index.bytes > limit) {
    return fail({ErrorKind::bad_input, "", "",
                 "needs " + std::to_string(index.bytes) + " bytes of memory, but at most " +
                     std::to_string(limit) + " are allowed",
                 "raise the memory limit or use a smaller file"});
  }
  return index;
}

Result<uint64_t> svo_front(std::span<const uint8_t> header, uint64_t size) {
  SINEW_TRY(const svo_file::Header found, svo_file::read_header(header, size));
  return sizeof(svo_file::Header) + found.head_packed;
}

Result<SvoIndex> decode_svo_front(std::span<const uint8_t> front, uint64_t size, uint64_t limit) {
  return svo_file::decode_front(front, size, limit);
}

void allocate_skeletons(SvoIndex& index) {
  Svo& svo = index.svo;
  if (svo.blocks.empty()) return;
  const SvoBlock& end = svo.blocks.back();
  svo.cells.resize(end.first_cell);
  svo_file::resize(svo.cell_level, end.first_cell);
  svo.corner_places.resize(end.first_corner);
  if (index.skinned) {
    svo.corner_joints.resize(end.first_corner);
    svo.corner_weights.resize(end.first_corner);
  }
  svo.joint_palette.resize(end.first_joint);
  svo.targets.resize(end.first_target);
  svo.deltas.resize(svo_file::deltas_of(svo));
  uint32_t delta = 0;
  for (uint32_t i = 0; i < svo.block_count(); ++i) {
    for (uint32_t t = svo.blocks[i].first_target; t < svo.blocks[i + 1].first_target; ++t) {
      svo.targets[t].first_delta = delta;
      delta += svo_file::counts_of(svo, i).corners;
    }
  }
}

void allocate_pages(SvoIndex& index) {
  Svo& svo = index.svo;
  if (svo.blocks.empty()) return;
  allocate_skeletons(index);
  const SvoBlock& end = svo.blocks.back();
  svo.bricks.resize(end.first_brick);
  svo.normals.resize(end.first_voxel);
  if (index.colors) {
    svo.colors.resize(end.first_voxel);
  } else {
    svo.color_ends.resize(end.first_brick);
    svo.color_selectors.resize(svo_file::words_of(end.first_voxel));
  }
  svo_file::resize(svo.brick_level, end.first_brick);
}

Result<void> decode_skeleton(const SvoIndex& index, std::span<const uint8_t> page, uint32_t block,
                             Svo& svo) {
  SINEW_TRY(const std::vector<uint8_t> bytes, svo_file::open_page(index.skeletons[block], page));
  if (!svo_file::read_skeleton(bytes, block, svo_file::format_of(index), svo)) {
    return svo_file::damaged("the skeleton of block " + std::to_string(block) + " is damaged");
  }
  return {};
}

namespace svo_file {
namespace {

// `at`: which block of `svo` it is.
Result<void> decode_detail_at(const SvoIndex& index, std::span<const uint8_t> page, uint32_t block,
                              uint32_t at, Svo& svo) {
  const std::string name = "the detail of block " + std::to_string(block);
  const Result<std::vector<uint8_t>> bytes = open_page(index.details[block], page);
  if (!bytes) return damaged(name + ": " + bytes.error().problem);
  if (!read_detail(*bytes, at, format_of(index), svo)) return damaged(name + " is damaged");
  return {};
}

}  // namespace
}  // namespace svo_file

Result<void> decode_detail(const SvoIndex& index, std::span<const uint8_t> page, uint32_t block,
                           Svo& svo) {
  return svo_file::decode_detail_at(index, page, block, block, svo);
}

Result<void> decode_detail_alone(const SvoIndex& index, std::span<const uint8_t> page,
                                 uint32_t block, Svo& svo) {
  return svo_file::decode_detail_at(index, page, block, 0, svo);
}

void fill_level(const SvoIndex& index, uint32_t block, Svo& svo) {
  if (!index.levels) filter_brick_level(svo, block);
}

Result<Svo> decode_svo(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(Svo svo, svo_file::decode(bytes, limit));
  if (const std::string problem = validate(svo); !problem.empty()) {
    return svo_file::damaged("its octree is damaged: " + problem);
  }
  return svo;
}

Result<SvoFileParts> parts_of_svo(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(const SvoIndex index, decode_svo_index(bytes, limit));
  return index.parts;
}

}  // namespace sinew
