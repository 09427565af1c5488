// Animated octrees as they were published: the opponent, scalar and as simple as its text.
//
//   queue = { root }
//   of every node in it:  its centre follows from its place in the octree, is moved by the
//                         accumulated matrices of its own joints, and projected;
//                         larger than a pixel and not a leaf: its children join the queue,
//                         else it is drawn: a square of its projected size
//
// A skinned node is S = min(2, W) times as large, W the number of its positive weights: that should
// close the holes where surfaces stretch. Normals stay as they rest. Nothing is culled.
// Based on: D. Bautembach, "Animated Sparse Voxel Octrees", Hamburg 2011, sections 3, 4 and figure
// 8. Differs: the queue is not served by the threads of a GPU; where two nodes lie at equal depths
// the earlier one wins, so that pictures can be compared.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/thesis/thesis_voxels.h"

namespace sinew {

// The thesis states 48 bytes a voxel; what they hold is ours to guess.
struct ThesisNode {
  uint32_t first_child = 0;  // children are adjacent
  uint8_t children = 0;      // bit x + 2 y + 4 z; 0: a leaf
  uint8_t level = 0;         // its side is 1 << level voxels
  uint16_t material = 0;
  ThesisWeights skin{};
  vec3 normal{0.0f};   // at rest, unit
  uint16_t color = 0;  // see pack_color
  uint16_t reserved = 0;
};
static_assert(sizeof(ThesisNode) == 48);

struct ThesisOctree {
  VoxelGrid grid;
  uint32_t joints = 0;            // that a pose must have; 0: not skinned
  std::vector<ThesisNode> nodes;  // root first, level by level, each in Morton order
  // Of each node: Morton code of its place among those of its level. Rasterising finds places on
  // its way; this is for sample_thesis() alone, and not counted.
  std::vector<VoxelMorton> places;

  uint32_t leaves = 0;
  size_t bytes() const { return nodes.size() * sizeof(ThesisNode); }
};

// `voxels` in Morton order, each place once; at least one (checked). Inner nodes have the mean
// normal, colour and weights of their children, and the first one's material.
ThesisOctree make_thesis_octree(const VoxelGrid& grid, std::span<const ThesisVoxel> voxels,
                                uint32_t joints);

// S; 1 for nodes that no joint moves, as in the thesis's rotation.
float stretch_factor(const ThesisNode& node);

struct ThesisInstance {
  const ThesisOctree* octree = nullptr;
  std::span<const Affine> joints;  // as many as the octree says
  Affine placement = identity_affine();
  uint32_t first_unit = 0;  // a unit of keys stands for 1024 nodes
};
inline uint32_t unit_count(const ThesisOctree& octree) {
  return static_cast<uint32_t>((octree.nodes.size() + 1023) / 1024);
}

struct ThesisSettings {
  float pixel = 1.0f;   // nodes that seem larger are subdivided
  bool lod = true;      // else down to leaves
  bool enlarge = true;  // by S
};

struct ThesisStats {
  uint64_t visited = 0;  // nodes that were in the queue
  uint64_t drawn = 0;
  uint64_t leaves_drawn = 0;
};

// A node in the queue; the place is in voxels.
struct ThesisVisit {
  uint32_t node = 0;
  uint16_t x = 0, y = 0, z = 0;
};
struct ThesisScratch {
  std::vector<ThesisVisit> queue, next;
};

// Where a node is drawn: a square in the picture, in pixels.
struct ThesisSquare {
  float x = 0.0f, y = 0.0f;  // its middle
  float size = 0.0f;         // its side
  float depth = 0.0f;
  bool visible = false;  // beyond the near plane, finite
};
class ThesisPlacing {
 public:
  ThesisPlacing(const ThesisInstance& instance, const RasterView& view,
                const ThesisSettings& settings);
  ThesisSquare operator()(const ThesisVisit& visit) const;

 private:
  const ThesisOctree& octree_;
  std::span<const Affine> joints_;
  Affine placement_;
  RasterView view_;
  bool enlarge_;
  float pixels_;  // that a voxel at rest seems to be long at depth 1, in the middle of the picture
};

// Covers the pixel that the middle lies in, and every one whose centre lies in the square.
ThesisStats rasterize_thesis(std::span<const ThesisInstance> instances, const RasterView& view,
                             const ThesisSettings& settings, ThesisScratch& scratch,
                             Visibility& out);

// What a key of rasterize_thesis names.
VoxelSample sample_thesis(std::span<const ThesisInstance> instances, VisibilityKey key);

}  // namespace sinew
