// Expected cameras as frames: a tree that is optimised for the rays of known views as well as for
// any ray. T (T-SAH 2015, section 7) leaves this to future work.
//
// The surface area heuristic counts with the chance that a ray which enters the root enters a node:
// the ratio of their areas. For the primary rays of one camera this chance is the ratio of what
// their boxes cover on the screen. So a view is one more frame, whose primitives have the
// rectangles that they cover on the screen as boxes, with no depth: half their area is dx * dy + 0
// + 0. Builders, optimisers and costs need not know.
//
// What is approximate: a node's rectangle is the union of its primitives', while rays meet its box
// in space. Far from the eye the two are nearly the same; for boxes about the eye they are not. So
// three scenes seen from outside gained at a share of 0.25, 3 to 10% fewer boxes and triangles a
// primary ray for 1% more by other rays, and at 0.5, 5 to 16% fewer for 3 to 5% more. With a camera
// in their midst they gained 1 to 26% at 0.25, but from -14 to 19% at 0.5.
#pragma once

#include <span>
#include <vector>

#include "sinew/bvh/frames/frames.h"
#include "sinew/math/vec.h"

namespace sinew {

// The rectangle of every triangle on the screen [-1, 1]^2, at depth 0. `world_to_clip` is glm's
// projection * view, for instance glm::infinitePerspective(yfov, aspect, near) * mat4(inverse of
// the camera's placement): what has z < -w lies before the near plane and is cut off; there is no
// far plane, as rays have none.
//
// What lies beside the screen is clamped to its border, so it has no area, but a node that holds
// such a triangle and a visible one reaches to the border, as its box in space does. A triangle
// wholly before the near plane becomes the point of the border that lies in its direction. One with
// a vertex that is not finite gets an empty box.
void view_boxes(std::span<const vec3> positions, std::span<const uvec3> triangles,
                const mat4& world_to_clip, std::span<Box> out);

// How much of the screen the root covers, 0 to 1. The cost of a view's frame is that of a ray which
// enters the root's rectangle, as it is in other frames; times this it is the cost of a primary
// ray, whose root is the screen: rays beside the rectangle cost nothing.
double screen_share(std::span<const Box> view_boxes);

// A view_boxes() of some pose, and how much its camera counts among the views.
struct ViewFrame {
  std::vector<Box> boxes;
  double weight = 1.0;
};

// Adds the views as frames. They get `share` (0 to 1) of the weight of all, the old frames the
// rest. Among the views a frame's weight is proportional to its own times its screen_share(): so
// many of their rays meet anything, so the sum of w_i C_i over views is the cost of one such ray,
// whichever view it is from. Views that show nothing are not added; if none is left, nothing
// changes.
void append_view_frames(FrameBoxes& frames, std::vector<ViewFrame> views, double share);

}  // namespace sinew
