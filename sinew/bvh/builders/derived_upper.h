// Trees for update mode `lazy`: what its rays meet first are not the exact boxes of treelets but
// those that derive_bounds() gives, a little larger and not by the same everywhere. So the part of
// the tree above the treelets is optimised over these.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/bvh/frames/optimize.h"
#include "sinew/math/vec.h"
#include "sinew/motion/motion.h"

namespace sinew {

// The same subtrees of at most kTreeletTriangles triangles under another top. `poses`: the
// representative frames, with `weights` as in FrameBoxes. The motion must be derivable(); poses of
// which nothing finite can be derived count as their neighbours do. Nodes come out in depth-first
// order.
Tree suit_derived_boxes(const Tree& tree, const Motion& motion, std::span<const uvec3> triangles,
                        std::span<const Pose> poses, std::span<const double> weights,
                        const OptimizeConfig& config);

}  // namespace sinew
