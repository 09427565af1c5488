// Bytes to octrees, and trusting none of them.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "sinew/base/packing.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/file_layout.h"
#include "sinew/svo/levels.h"

namespace sinew {
namespace svo_file {
namespace {

Result<Header> read_header(std::span<const uint8_t> bytes) {
  Header header;
  if (bytes.size() < sizeof(Header)) return damaged("its octree ends too soon");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.magic != kMagic) return damaged("its octree is of a kind that is not known");
  if (header.checksum != checksum_of(header)) {
    return damaged("its octree is damaged: the header's checksum does not fit");
  }
  if (header.flags > (kSkinned | kColors | kLevels)) return damaged("its octree has unknown flags");
  if (header.size != bytes.size()) {
    return damaged("its octree has " + std::to_string(bytes.size()) + " bytes, not " +
                   std::to_string(header.size));
  }
  if (header.head_packed > bytes.size() - sizeof(Header)) {
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

Result<void> read_blocks(StreamReader& in, size_t entries, uint64_t first_page, uint64_t size,
                         SvoIndex& out) {
  if (entries == 0) return {};
  const size_t count = entries - 1;
  std::array<std::vector<uint16_t>, 3> places;
  std::array<std::vector<uint32_t>, kCounts> counts;
  for (auto& plane : places) plane = in.take<uint16_t>(count);
  for (auto& plane : counts) plane = in.take<uint32_t>(count);
  const std::vector<uint32_t> unpacked = in.take<uint32_t>(count);
  const std::vector<uint32_t> packed = in.take<uint32_t>(count);
  const std::vector<uint64_t> checksums = in.take<uint64_t>(count);
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
    // So sizes claim no memory without bytes.
    const uint64_t least = page_size(own, format_of(out));
    if (unpacked[i] > most_unpacked(packed[i]) || unpacked[i] < least + own.bricks ||
        unpacked[i] > least + uint64_t{8} * own.bricks) {
      return damaged("a block is larger than its page");
    }
    if (packed[i] > size - first_page) return damaged("its octree ends too soon");
    out.pages.push_back({first_page, unpacked[i], packed[i], checksums[i]});
    first_page += packed[i];
  }
  if (first_page != size) return damaged("its octree has bytes after its end");
  if (deltas_of(out.svo) > std::numeric_limits<uint32_t>::max()) {
    return damaged("it has more morph deltas than the format holds");
  }
  return {};
}

// Memory of the whole octree, once its pages are read.
uint64_t memory_of(const SvoIndex& index) {
  const Svo& svo = index.svo;
  if (svo.blocks.empty()) return svo.bytes();
  const SvoBlock& end = svo.blocks.back();
  constexpr uint64_t kLevel = 5;  // of an entry
  uint64_t sum = svo.bytes() + uint64_t{end.first_cell} * (sizeof(SvoCell) + kLevel);
  sum += uint64_t{end.first_brick} * (sizeof(uint64_t) + kLevel) + uint64_t{2} * end.first_voxel;
  if (index.colors) {
    sum += uint64_t{2} * end.first_voxel;
  } else {
    sum += sizeof(SvoColorEnds) * uint64_t{end.first_brick} + 4 * words_of(end.first_voxel);
  }
  sum += uint64_t{end.first_corner} * (index.skinned ? 14 : 2) + uint64_t{end.first_joint} * 2;
  return sum + uint64_t{end.first_target} * sizeof(SvoTarget) + deltas_of(svo) * 6;
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
  out.bytes = memory_of(out);
  return out;
}

Result<Svo> decode(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(SvoIndex index, decode_svo_index(bytes, limit));
  allocate_pages(index);
  Svo svo = std::move(index.svo);
  index.svo = {};
  std::vector<Result<void>> results(index.pages.size());
  parallel_for(results.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      results[i] = decode_svo_page(index, bytes, static_cast<uint32_t>(i), svo);
    }
  });
  for (const Result<void>& result : results) SINEW_CHECKED(result);
  parallel_for(results.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) fill_levels(index, static_cast<uint32_t>(i), svo);
  });
  return svo;
}

}  // namespace
}  // namespace svo_file

Result<SvoIndex> decode_svo_index(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(const svo_file::Header header, svo_file::read_header(bytes));
  SINEW_TRY(const std::vector<uint8_t> head,
            svo_file::unpack_checked(bytes.subspan(sizeof(svo_file::Header), header.head_packed),
                                     header.head_unpacked, header.head_checksum, limit));
  SINEW_TRY(SvoIndex index, svo_file::read_head(head, header));
  if (index.bytes > limit) {
    return fail({ErrorKind::bad_input, "", "",
                 "needs " + std::to_string(index.bytes) + " bytes of memory, but at most " +
                     std::to_string(limit) + " are allowed",
                 "raise the memory limit or use a smaller file"});
  }
  return index;
}

void allocate_pages(SvoIndex& index) {
  Svo& svo = index.svo;
  if (svo.blocks.empty()) return;
  const SvoBlock& end = svo.blocks.back();
  svo.cells.resize(end.first_cell);
  svo.bricks.resize(end.first_brick);
  svo.normals.resize(end.first_voxel);
  if (index.colors) {
    svo.colors.resize(end.first_voxel);
  } else {
    svo.color_ends.resize(end.first_brick);
    svo.color_selectors.resize(svo_file::words_of(end.first_voxel));
  }
  svo_file::resize(svo.brick_level, end.first_brick);
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

Result<void> decode_svo_page(const SvoIndex& index, std::span<const uint8_t> bytes, uint32_t block,
                             Svo& svo) {
  constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();
  const SvoPage& page = index.pages[block];
  SINEW_TRY(const std::vector<uint8_t> unpacked,
            svo_file::unpack_checked(bytes.subspan(page.offset, page.packed), page.unpacked,
                                     page.checksum, kNoLimit));
  if (!svo_file::read_page(unpacked, block, svo_file::format_of(index), svo)) {
    return svo_file::damaged("the page of block " + std::to_string(block) + " is damaged");
  }
  return {};
}

void fill_levels(const SvoIndex& index, uint32_t block, Svo& svo) {
  if (!index.levels) filter_levels(svo, block);
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
