#include "sinew/svo/file.h"

#include <bit>
#include <cstring>
#include <limits>

#include "sinew/base/packing.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/levels.h"
#include "sinew/svo/page.h"

namespace sinew {
namespace {

using svo_file::Counts;
using svo_file::counts_of;
using svo_file::kCounts;
using svo_file::page_size;
using svo_file::PageFormat;
using svo_file::Part;
using svo_file::read_page;
using svo_file::StreamReader;
using svo_file::StreamWriter;

static_assert(std::endian::native == std::endian::little);

constexpr uint32_t kMagic = 0x316f7673;  // "svo1"
constexpr uint32_t kSkinned = 1, kLevels = 2;
constexpr uint32_t kMostCorners = 1u << 16;  // of a block: cells name them by 16 bits

struct Header {
  uint32_t magic = kMagic;
  uint32_t flags = 0;
  uint64_t size = 0;
  uint64_t head_unpacked = 0;
  uint64_t head_packed = 0;
  uint64_t head_checksum = 0;
  uint64_t checksum = 0;
};
static_assert(sizeof(Header) == 48);

uint64_t checksum_of(const Header& header) {
  return checksum({reinterpret_cast<const uint8_t*>(&header), offsetof(Header, checksum)});
}

// What the head begins with.
struct HeadNumbers {
  uint32_t name = 0;  // bytes
  uint32_t origin[3] = {}, voxel = 0;  // bits of floats
  uint32_t resolution[3] = {};
  uint32_t joints = 0, morph_targets = 0, morph_weights = 0;
  uint32_t root_level = 0;
  uint32_t nodes = 0, blocks = 0;  // entries of Svo::nodes and ::blocks
};
constexpr size_t kHeadNumbers = sizeof(HeadNumbers) / sizeof(uint32_t);

tl::unexpected<Error> damaged(std::string problem) {
  return fail({ErrorKind::bad_input, "", "", std::move(problem), "make the file again"});
}

constexpr size_t kStoredParts = svo_file::kParts - 1;  // all but Part::tables
uint64_t* part_of(SvoFileParts& parts, Part part) {
  uint64_t* const all[] = {&parts.tables, &parts.topology, &parts.normals,
                           &parts.colors, &parts.levels,   &parts.lattice};
  return all[static_cast<size_t>(part)];
}

// ---- writing ----

struct PackedPage {
  std::vector<uint8_t> bytes;
  SvoFileParts parts;
};

PackedPage pack_page(const Svo& svo, uint32_t block, const PageFormat& format, int effort) {
  StreamWriter page;
  write_page(svo, block, format, page);
  PackedPage result;
  Packed packed = pack(page.bytes(), page.ends(), effort);
  size_t begin = 0;
  for (size_t i = 0; i < page.ends().size(); ++i) {
    *part_of(result.parts, page.parts()[i]) += packed.ends[i] - begin;
    begin = packed.ends[i];
  }
  result.bytes = std::move(packed.bytes);
  return result;
}

// The node or cell that the children of node i begin with, if nothing stands between those of the
// nodes before it and its own.
class FirstChild {
 public:
  uint32_t guess(const SvoNode& node) const {
    return node.level == kCellLevel + 1 ? next_cell_ : next_node_;
  }
  void add(const SvoNode& node) {
    (node.level == kCellLevel + 1 ? next_cell_ : next_node_) += node.count;
  }

 private:
  uint32_t next_node_ = 1, next_cell_ = 0;
};

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

void write_blocks(const Svo& svo, std::span<const PackedPage> pages, StreamWriter& out) {
  for (uint16_t SvoBlock::*axis : {&SvoBlock::x, &SvoBlock::y, &SvoBlock::z}) {
    out.add<uint16_t>(Part::tables, pages.size(), [&](size_t i) {
      const int before = i == 0 ? 0 : svo.blocks[i - 1].*axis;
      return svo_file::fold(static_cast<uint16_t>(svo.blocks[i].*axis - before));
    });
  }
  std::vector<std::array<uint32_t, kCounts>> counts;
  for (uint32_t i = 0; i < pages.size(); ++i) {
    counts.push_back(std::bit_cast<std::array<uint32_t, kCounts>>(counts_of(svo, i)));
  }
  for (size_t k = 0; k < kCounts; ++k) {
    out.add<uint32_t>(Part::tables, pages.size(), [&](size_t i) { return counts[i][k]; });
  }
  out.add<uint32_t>(Part::tables, pages.size(), [&](size_t i) { return pages[i].bytes.size(); });
  out.add<uint64_t>(Part::tables, pages.size(), [&](size_t i) { return checksum(pages[i].bytes); });
}

StreamWriter write_head(const Svo& svo, std::span<const PackedPage> pages, SvoFileParts& parts) {
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
  write_blocks(svo, pages, out);
  return out;
}

EncodedSvo encode(const Svo& svo, const PageFormat& format, int effort) {
  std::vector<PackedPage> pages(svo.block_count());
  parallel_for(pages.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      pages[i] = pack_page(svo, static_cast<uint32_t>(i), format, effort);
    }
  });
  EncodedSvo result;
  for (const PackedPage& page : pages) result.parts.add(page.parts);
  const StreamWriter head = write_head(svo, pages, result.parts);
  const Packed packed = pack(head.bytes(), head.ends(), effort);
  Header header;
  header.flags = (format.skinned ? kSkinned : 0) | (format.levels ? kLevels : 0);
  header.head_unpacked = head.bytes().size();
  header.head_packed = packed.bytes.size();
  header.head_checksum = checksum(packed.bytes);
  header.size = sizeof(Header) + packed.bytes.size();
  result.parts.tables = header.size;
  for (const PackedPage& page : pages) header.size += page.bytes.size();
  header.checksum = checksum_of(header);
  result.bytes.reserve(header.size);
  result.bytes.resize(sizeof(Header));
  std::memcpy(result.bytes.data(), &header, sizeof(Header));
  result.bytes.insert(result.bytes.end(), packed.bytes.begin(), packed.bytes.end());
  for (const PackedPage& page : pages) {
    result.bytes.insert(result.bytes.end(), page.bytes.begin(), page.bytes.end());
  }
  return result;
}

// ---- reading ----

Result<Header> read_header(std::span<const uint8_t> bytes) {
  Header header;
  if (bytes.size() < sizeof(Header)) return damaged("its octree ends too soon");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.magic != kMagic) return damaged("its octree is of a kind that is not known");
  if (header.checksum != checksum_of(header)) {
    return damaged("its octree is damaged: the header's checksum does not fit");
  }
  if (header.flags > (kSkinned | kLevels)) return damaged("its octree has unknown flags");
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
  svo.node_level.normals.resize(count);
  svo.node_level.colors.resize(count);
  svo.node_level.spreads.resize(count);
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
  for (int level = 0; level < 3; ++level) {
    add(from.first_voxel[level], counts.voxels[level], to.first_voxel[level]);
  }
  add(from.first_joint, counts.joints, to.first_joint);
  add(from.first_target, counts.targets, to.first_target);
  // Voxels of level 1 lie above those of level 0, and so on.
  return fits && counts.corners <= kMostCorners && counts.voxels[1] <= counts.voxels[0] &&
         counts.voxels[2] == counts.bricks && counts.bricks <= counts.voxels[1];
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
  const std::vector<uint32_t> packed = in.take<uint32_t>(count);
  const std::vector<uint64_t> checksums = in.take<uint64_t>(count);
  if (!in.ok()) return damaged("its octree's head ends too soon");
  std::vector<SvoBlock>& blocks = out.svo.blocks;
  blocks.resize(entries);
  std::array<uint16_t, 3> place{};
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      place[k] = static_cast<uint16_t>(place[k] + svo_file::unfold(places[k][i]));
    }
    blocks[i].x = place[0], blocks[i].y = place[1], blocks[i].z = place[2];
    std::array<uint32_t, kCounts> numbers;
    for (size_t k = 0; k < kCounts; ++k) numbers[k] = counts[k][i];
    const Counts own = std::bit_cast<Counts>(numbers);
    if (!advance(blocks[i], own, blocks[i + 1])) return damaged("a block has impossible sizes");
    // So sizes claim no memory without bytes.
    const uint64_t unpacked = page_size(own, {out.skinned, out.levels});
    if (unpacked > most_unpacked(packed[i])) return damaged("a block is larger than its page");
    if (packed[i] > size - first_page) return damaged("its octree ends too soon");
    out.pages.push_back({first_page, unpacked, packed[i], checksums[i]});
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
  uint64_t sum = svo.bytes() + uint64_t{end.first_cell} * (sizeof(SvoCell) + 5);
  sum += uint64_t{end.first_brick} * 8 + uint64_t{end.first_voxel[0]} * 4;
  sum += uint64_t{5} * end.first_voxel[1] + uint64_t{5} * end.first_voxel[2];
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

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const SvoLevel& a, const SvoLevel& b) {
  return same(a.normals, b.normals) && same(a.colors, b.colors) && same(a.spreads, b.spreads);
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
  return svo;
}

}  // namespace

void SvoFileParts::add(const SvoFileParts& other) {
  tables += other.tables;
  topology += other.topology;
  normals += other.normals;
  colors += other.colors;
  levels += other.levels;
  lattice += other.lattice;
}

bool is_same(const Svo& a, const Svo& b) {
  bool levels = same(a.cell_level, b.cell_level) && same(a.node_level, b.node_level);
  for (int level = 0; level < 3; ++level) levels = levels && same(a.levels[level], b.levels[level]);
  return levels && a.name == b.name && a.grid.origin == b.grid.origin &&
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
    EncodedSvo encoded = encode(svo, {!svo.corner_joints.empty(), levels}, effort);
    SINEW_TRY(const Svo again, decode(encoded.bytes, kNoLimit));
    if (is_same(svo, again)) return encoded;
  }
  return fail({ErrorKind::bad_input, svo.name, "", "its octree is not in the order of the format",
               "make the octree again"});
}

Result<SvoIndex> decode_svo_index(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(const Header header, read_header(bytes));
  SINEW_TRY(const std::vector<uint8_t> head,
            unpack_checked(bytes.subspan(sizeof(Header), header.head_packed),
                           header.head_unpacked, header.head_checksum, limit));
  SINEW_TRY(SvoIndex index, read_head(head, header));
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
  for (int level = 0; level < 3; ++level) {
    svo.levels[level].normals.resize(end.first_voxel[level]);
    svo.levels[level].colors.resize(end.first_voxel[level]);
    if (level > 0) svo.levels[level].spreads.resize(end.first_voxel[level]);
  }
  svo.cell_level.normals.resize(end.first_cell);
  svo.cell_level.colors.resize(end.first_cell);
  svo.cell_level.spreads.resize(end.first_cell);
  svo.corner_places.resize(end.first_corner);
  if (index.skinned) {
    svo.corner_joints.resize(end.first_corner);
    svo.corner_weights.resize(end.first_corner);
  }
  svo.joint_palette.resize(end.first_joint);
  svo.targets.resize(end.first_target);
  svo.deltas.resize(deltas_of(svo));
  uint32_t delta = 0;
  for (uint32_t i = 0; i < svo.block_count(); ++i) {
    for (uint32_t t = svo.blocks[i].first_target; t < svo.blocks[i + 1].first_target; ++t) {
      svo.targets[t].first_delta = delta;
      delta += counts_of(svo, i).corners;
    }
  }
}

Result<void> decode_svo_page(const SvoIndex& index, std::span<const uint8_t> bytes, uint32_t block,
                             Svo& svo) {
  constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();
  const SvoPage& page = index.pages[block];
  SINEW_TRY(const std::vector<uint8_t> unpacked,
            unpack_checked(bytes.subspan(page.offset, page.packed), page.unpacked, page.checksum,
                           kNoLimit));
  if (!read_page(unpacked, block, {index.skinned, index.levels}, svo)) {
    return damaged("the page of block " + std::to_string(block) + " is damaged");
  }
  if (!index.levels) filter_levels(svo, block);
  return {};
}

Result<Svo> decode_svo(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(Svo svo, decode(bytes, limit));
  if (const std::string problem = validate(svo); !problem.empty()) {
    return damaged("its octree is damaged: " + problem);
  }
  return svo;
}

Result<SvoFileParts> parts_of_svo(std::span<const uint8_t> bytes, uint64_t limit) {
  SINEW_TRY(const SvoIndex index, decode_svo_index(bytes, limit));
  return index.parts;
}

}  // namespace sinew
