// Svo: a sparse voxel octree as it lies in memory. Linear buffers of plain values, indices only, no
// pointers: it can be written to a file, mapped and moved as it is.
//
//   level 0    voxels                      bit (x, y, z) of a brick of 4^3, 64 bits
//   level 1    2^3 voxels                  bit (x, y, z) of coarse_voxels(cell), 64 bits
//   level 2    4^3 voxels, a brick         bit of SvoCell::bricks, 8 bits
//   level 3    8^3 voxels, a *cell*        SvoCell: corners of its own in the skin lattice
//   level 4-5  inner nodes                 SvoNode
//   level 6    64^3 voxels, a *block*      SvoNode and SvoBlock: what is posed, and later paged, as
//   one level 7-   inner nodes                 SvoNode, up to the root
//
//   nodes   [ root | ... | level 7 | level 6 = blocks | level 5 | level 4 ]   breadth-first, each
//                                                       level in Morton order, children adjacent
//   blocks  [ 0 | 1 | ... | end ]      first_*: where the block's cells, corners, ... begin
//   cells   [ of block 0 | of block 1 | ...        in Morton order; copies of one cell adjacent
//   bricks  [ of cell 0: one a bit of `bricks`, rising | of cell 1 ...
//   voxels  attributes in the order of cells, bricks and bits. Of level 1 none are stored: they are
//           the mean of its voxels, three on average, whenever somebody asks. Levels 2 and up have
//           arrays with one entry a brick, a cell, a node
//   colours of voxels: two ends a brick, and for each voxel two bits that say where between them it
//           is; or one colour a voxel, which octrees of plain voxels have
//
// The *skin lattice*: the corners of cells are points that a Motion moves, and the inside of a cell
// follows trilinearly. Where a cell holds sheets of different limbs, or different materials, it has
// a copy for each; copies share a corner if and only if their sheets connect across it. Corners on
// the faces between two blocks stand in both, with the same values, so that a block is posed alone.
// Based on: D. Bautembach, "Animated Sparse Voxel Octrees", Hamburg 2011, section 8.1.3. Differs:
// corners of cells move, not of voxels.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/math/vec.h"

namespace sinew {

inline constexpr uint32_t kCellLevel = 3;
inline constexpr uint32_t kBlockLevel = 6;
inline constexpr uint32_t kCellSide = 1u << kCellLevel;    // voxels
inline constexpr uint32_t kBlockSide = 1u << kBlockLevel;  // voxels
inline constexpr uint32_t kHighestResolution = 4096;       // voxels a side
inline constexpr uint32_t kSvoInfluences = 4;              // joints a corner

// Voxel (x, y, z) is the cube origin + voxel * [(x, y, z), (x + 1, y + 1, z + 1)], in the object's
// space at rest.
struct VoxelGrid {
  vec3 origin{0.0f};
  float voxel = 1.0f;   // side
  uvec3 resolution{0};  // voxels along each axis, at most kHighestResolution

  vec3 center(uvec3 v) const { return origin + voxel * (vec3(v) + 0.5f); }
};

struct SvoNode {
  uint32_t first = 0;  // child: a node, or at level 4 a cell
  uint16_t count = 0;  // children; more than 8 where cells have copies
  uint8_t level = 0;   // 4 and above
  uint8_t reserved = 0;
};
static_assert(sizeof(SvoNode) == 8);

// All `first_*` of a block end where the next block's begin; `blocks` ends with an entry for that.
struct SvoBlock {
  uint16_t x = 0, y = 0, z = 0;  // in blocks
  uint16_t reserved = 0;
  uint32_t first_cell = 0;
  uint32_t first_corner = 0;
  uint32_t first_brick = 0;
  uint32_t first_voxel = 0;
  uint32_t first_joint = 0;   // in joint_palette
  uint32_t first_target = 0;  // in targets
};
static_assert(sizeof(SvoBlock) == 32);

// Indices are relative to the block's.
struct SvoCell {
  uint16_t corner[8] = {};  // bit 0 of the index is x, 1 is y, 2 is z
  uint32_t first_brick = 0;
  uint32_t first_voxel = 0;
  uint16_t place = 0;     // x + 8 y + 64 z within the block, in cells
  uint16_t material = 0;  // index into the scene's materials
  uint16_t voxels = 0;    // 1 to 512
  uint8_t bricks = 0;     // level 2: bit x + 2 y + 4 z
  uint8_t reserved = 0;
};
static_assert(sizeof(SvoCell) == 32);

// A voxel of a cell, of any of its levels, in 10 bits.
//   0..511 level 0: 64 * brick + bit; 512..575 level 1; 576..583 level 2; 584 the cell itself.
using VoxelCode = uint32_t;
inline constexpr VoxelCode kFirstCode[4] = {0, 512, 576, 584};
inline constexpr uint32_t kCodes = 585;

inline uint32_t level_of(VoxelCode code) {
  return code < 512 ? 0 : code < 576 ? 1 : code < 584 ? 2 : 3;
}

// Where in its cell the voxel begins, and how long its side is; in voxels of level 0.
struct VoxelPlace {
  uvec3 min{0};
  uint32_t side = 1;
};
inline VoxelPlace place_of(VoxelCode code) {
  const uint32_t level = level_of(code), local = code - kFirstCode[level], side = 1u << level;
  const auto bits = [](uint32_t i, uint32_t side_bits) {
    const uint32_t mask = (1u << side_bits) - 1;
    return uvec3(i & mask, (i >> side_bits) & mask, i >> (2 * side_bits));
  };
  if (level == 0) return {4u * bits(local >> 6, 1) + bits(local & 63, 2), 1};
  return {side * bits(local, 3 - level), side};
}

// Attributes of what is above voxels.
struct SvoLevel {
  std::vector<uint16_t> normals;  // see pack_normal: at rest
  std::vector<uint16_t> colors;   // see pack_color: base colour
  std::vector<uint8_t> spreads;   // length of the mean normal * 255
};

// Between which colours those of a brick's voxels are: selector s stands for mix(a, b, s / 3) of
// the packed colours' square roots.
struct SvoColorEnds {
  uint16_t a = 0, b = 0;
};

// Which corners of a block a morph target moves, and by what: delta = unit * deltas, one a corner
// of the block.
struct SvoTarget {
  uint32_t target = 0;
  float unit = 0.0f;
  uint32_t first_delta = 0;
};

class PagedSvo;  // see svo/file/stream.h

// Who brings and takes away an octree's bricks and their attributes block by block; null: they are
// all there. They come into the very buffers of the octree, so that it may be moved, but not copied
// (checked).
class PagedSvoPtr {
 public:
  PagedSvoPtr() = default;
  explicit PagedSvoPtr(std::shared_ptr<PagedSvo> pages) : pages_(std::move(pages)) {}
  PagedSvoPtr(const PagedSvoPtr& other);
  PagedSvoPtr& operator=(const PagedSvoPtr& other);
  PagedSvoPtr(PagedSvoPtr&&) noexcept = default;
  PagedSvoPtr& operator=(PagedSvoPtr&&) noexcept = default;

  explicit operator bool() const { return pages_ != nullptr; }
  PagedSvo* operator->() const { return pages_.get(); }

 private:
  std::shared_ptr<PagedSvo> pages_;
};

struct Svo {
  std::string name;
  VoxelGrid grid;
  uint32_t joints = 0;                // that a pose must have; 0: not skinned
  uint32_t morph_targets = 0;         // that a pose must have weights for
  uint32_t root_level = kBlockLevel;  // at least kBlockLevel
  std::vector<float> morph_weights;   // default weight of each target

  std::vector<SvoNode> nodes;
  std::vector<SvoBlock> blocks;  // and one more, for its ends; empty if there are no voxels
  std::vector<SvoCell> cells;
  std::vector<uint64_t> bricks;
  std::vector<uint16_t> normals;  // one a voxel
  std::vector<uint16_t> colors;   // one a voxel; or none, and then:
  std::vector<SvoColorEnds> color_ends;
  std::vector<uint32_t> color_selectors;  // voxel i: bits 2 i, 2 i + 1, the lowest first
  SvoLevel brick_level;                   // one a brick: level 2
  SvoLevel cell_level;                    // one a cell: level 3
  SvoLevel node_level;                    // one a node: levels 4 and above

  // Of corners, block by block.
  std::vector<uint16_t> corner_places;  // x + 9 y + 81 z in cells, within the block: 0 to 8 each
  std::vector<std::array<uint8_t, kSvoInfluences>> corner_joints;    // in the block's palette
  std::vector<std::array<uint16_t, kSvoInfluences>> corner_weights;  // of 65535, which is their sum
  std::vector<uint16_t> joint_palette;
  std::vector<SvoTarget> targets;
  std::vector<std::array<int16_t, 3>> deltas;

  PagedSvoPtr paging;

  uint32_t block_count() const {
    return blocks.empty() ? 0 : static_cast<uint32_t>(blocks.size() - 1);
  }
  uint64_t voxel_count() const { return normals.size(); }
  // The node of block 0; those of the other blocks follow.
  uint32_t first_block_node() const;
  size_t bytes() const;  // of all buffers
};

// Octahedral, 8 bits an axis. The direction need not be of unit length; (0, 0, 0) becomes +Z.
// Based on: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit
// Vectors", JCGT 3(2), 2014.
uint16_t pack_normal(vec3 direction);
vec3 unpack_normal(uint16_t packed);

// Linear RGB in 0..1 as 5, 6 and 5 bits of its square root.
uint16_t pack_color(vec3 linear);
vec3 unpack_color(uint16_t packed);

// Level 1 of a cell: bit x + 4 y + 16 z where one of the 2^3 voxels is. `bricks` are the cell's
// own.
uint64_t coarse_voxels(const SvoCell& cell, const uint64_t* bricks);

// Where a voxel of level 0 stands in its arrays, and its brick in those of bricks: how many come
// before it. It must be occupied.
struct VoxelIndex {
  uint32_t voxel = 0;
  uint32_t brick = 0;
};
VoxelIndex voxel_index(const Svo& svo, const SvoBlock& block, const SvoCell& cell, VoxelCode code);

vec3 voxel_color(const Svo& svo, VoxelIndex at);  // linear

// How a voxel of a cell, of any of its levels, looks at rest. It must be occupied.
struct VoxelAttributes {
  vec3 normal{0.0f};    // unit
  vec3 color{0.0f};     // linear
  float spread = 1.0f;  // length of the mean normal
};
VoxelAttributes voxel_attributes(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
                                 VoxelCode code);
VoxelAttributes level_attributes(const SvoLevel& level, size_t index);

// Every invariant stated above; of an octree whose blocks come and go all that is always there.
// Empty text if all hold, else what is wrong and where.
std::string validate(const Svo& svo);
// The bricks of one block, in an octree of which the rest is valid.
std::string validate_bricks(const Svo& svo, uint32_t block);

}  // namespace sinew
