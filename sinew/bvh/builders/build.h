// Builders of binary trees over primitive boxes.
//   build_binned  binned SAH, parallel: I. Wald, "On fast Construction of SAH-based Bounding Volume
//                 Hierarchies", 2007. The product's default.
//   build_sweep   full-sweep SAH: V. Havran, "Heuristic Ray Shooting Algorithms", 2000, section
//                 4.4.1 over sorted centroids on all axes. Slower, slightly better.
//   build_hlbvh   along a Morton curve, parallel: J. Pantaleoni, D. Luebke, "HLBVH: Hierarchical
//                 LBVH Construction for Real-Time Ray Tracing of Dynamic Geometry", 2010; K.
//                 Garanzha, J. Pantaleoni, D. McAllister, "Simpler and Faster HLBVH with Work
//                 Queues", 2011. The fastest, for a new tree every frame.
// All give the same tree for every thread count.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/bvh/tree.h"
#include "sinew/math/box.h"

namespace sinew {

struct BuildConfig {
  float traversal_cost = 2.0f;     // of a node, relative to intersection_cost
  float intersection_cost = 1.0f;  // of one block of `leaf_block` primitives
  uint32_t leaf_block = 4;         // primitives tested together; leaf cost is ceil(n / leaf_block)
  uint32_t max_leaf = 8;           // primitives in a leaf, at most; 1: one primitive a leaf
  uint32_t bins = 16;              // build_binned only: 2..32 a axis
};

// Boxes must be finite. A primitive may have an empty extent, not an empty box.
Tree build_binned(std::span<const Box> primitive_boxes, const BuildConfig& config = {});
Tree build_sweep(std::span<const Box> primitive_boxes, const BuildConfig& config = {});

// Morton codes have 30 bits, ten an axis, of the centroids in their box. Halves that hold nothing
// make no node; primitives with equal codes are halved by number.
enum class HlbvhSplit : uint8_t {
  median,  // in the spatial middle, by the bits of the code (HLBVH-med of T-SAH 2015)
  sah,     // clusters with equal upper 15 bits: binned SAH above them, medians inside
};

// Ranges of at most config.max_leaf primitives become leaves. config's costs and bins serve
// HlbvhSplit::sah only.
Tree build_hlbvh(std::span<const Box> primitive_boxes, HlbvhSplit split,
                 const BuildConfig& config = {});

}  // namespace sinew
