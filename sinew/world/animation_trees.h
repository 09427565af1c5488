// Trees for the bodies of a scene that suit a whole animation (T-SAH), or its segments: made once,
// kept in a file, given to prepare().
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/frames/segments.h"
#include "sinew/bvh/frames/tree_file.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct TreeProgress {
  uint32_t body = 0, bodies = 0;
  std::string name;  // of the body's mesh
  OptimizeStep step;
};

struct AnimationTreeOptions {
  std::string clip{};   // as PrepareOptions::clip; "all": the poses of all clips
  uint32_t frames = 5;  // representatives, of each segment
  FrameChoice choice = FrameChoice::uniform;
  uint32_t exponent = 0;       // T's k: 0 the average counts, 2 or 4 the dearest frames more; to 64
  uint32_t most_segments = 1;  // the fewest trees that keep the cost limit are taken
  double cost_limit = 1.15;    // of a tree's average cost over that of a tree a frame
  size_t byte_budget = 0;      // of all trees of all bodies (bytes_of_trees()); 0: no limit
  uint32_t most_samples = 64;  // frames of the clip that are looked at
  // The expected camera: world to clip space (camera_frames.h) in a pose. `view_share` of the cost
  // is that of its primary rays; 0: only random rays count.
  std::function<mat4(const ScenePose&)> view{};
  float view_share = 0.0f;
  bool derived_boxes = false;  // the upper tree suits the boxes that update mode `lazy` derives
  std::function<bool(const TreeProgress&)> on_step{};  // false ends a body's optimisation early
};

// What became of a body.
struct BodyTreeReport {
  std::string name;
  uint32_t triangles = 0;
  bool deforms = false;
  uint32_t frames = 0;  // that were looked at
  uint32_t segments = 0;
  double seconds = 0.0;
  // Average SAH costs (c_T = 3, c_I = 2, one triangle a leaf) over some of these frames, the same
  // for all, most of which were no representatives:
  double cost = 0.0;
  double highest_cost = 0.0;
  double middle_frame_cost = 0.0;  // of a tree built for the clip's middle alone
  double rebuild_cost = 0.0;       // of a new tree a frame; 0: not measured, as with several clips
};

struct AnimationTrees {
  TreeFile trees;  // one list a body, in the order of scene_bodies()
  std::vector<BodyTreeReport> bodies;
};

Result<AnimationTrees> optimize_trees(const Scene& scene, const AnimationTreeOptions& options = {});

// Whether the trees were made for this scene and may be traced with this clip (find_clip()); an
// error that says why not. Only segments are bound to their clip: a body's single tree serves any.
Result<void> check_trees(const TreeFile& trees, const Scene& scene, int clip);

}  // namespace sinew
