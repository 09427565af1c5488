// The methods that `sinew bench tsah` compares: what each makes before the animation is played.
// Based on: J. Bittner, D. Meister, "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015
// (T), section 6; SAH* after I. Wald, S. Boulos, P. Shirley, "Ray tracing deformable scenes using
// dynamic bounding volume hierarchies", 2007.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/tsah_scenes.h"
#include "sinew/bvh/frames/frames.h"
#include "sinew/bvh/tree.h"

namespace sinew::bench {

// A tree, and from when on it counts.
struct TreePart {
  double begin = 0.0;             // u of the clip
  Tree tree = {};                 // leaves as T's cost model wants them: what table 1 is about
  Tree traced = {};               // leaves as packets of four triangles want them
  std::vector<float> areas = {};  // of the nodes of `traced`, for the eight-wide layout
};

struct MethodTrees {
  std::string name;
  double seconds = 0.0;              // wall time to make the trees, from the boxes of the frames
  std::vector<TreePart> parts = {};  // one tree, or some that follow each other
  std::string note = {};

  const TreePart& at(double u) const;
};

inline constexpr std::string_view kSahRebuild = "SAH-rebuild";  // made anew for every frame
inline constexpr std::string_view kSahFirst = "SAH0";
inline constexpr std::string_view kSahMiddle = "SAH middle frame";
inline constexpr std::string_view kSahBest = "SAH*";
inline constexpr std::string_view kTsah = "T-SAH k=0";
inline constexpr std::string_view kSegments3 = "T-SAH, 3 trees";
inline constexpr std::string_view kSegmentsAuto = "T-SAH, at most 4 trees";

struct MethodConfig {
  uint32_t representatives = 5;
  bool reference = false;  // T's own algorithm too: one thread, minutes
  bool segments = false;
};

// The boxes of some frames, all of the same weight.
FrameBoxes boxes_at(const FlatClip& clip, std::span<const double> u);
// u of `count` frames, first and last included.
std::vector<double> even_frames(uint32_t count);

// Trees of one triangle a leaf, made for a single frame: a full sweep, and the same with
// insertion-based optimisation.
Tree sweep_tree(const FrameBoxes& frame);
Tree best_tree_of_frame(const FrameBoxes& frame);

// The tree with leaves as T's cost model wants them, and with those of both kinds, from one with
// one triangle a leaf; `frames` and `exponent` say what its areas count.
Tree cost_leaves(const Tree& deep, const FrameBoxes& frames, uint32_t exponent);
TreePart finish(const Tree& deep, const FrameBoxes& frames, uint32_t exponent, double begin);

Result<std::vector<MethodTrees>> make_methods(const FlatClip& clip, const MethodConfig& config);

// nullptr if there is none.
const MethodTrees* find(std::span<const MethodTrees> methods, std::string_view name);

}  // namespace sinew::bench
