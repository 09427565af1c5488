// Evaluates a clip at a time: node transforms, joint matrices, morph weights, cache keys.
// Based on: glTF 2.0 specification, sections 3.7.3 (skins), 3.11 (animations), appendix C
// (interpolation).
#pragma once

#include <span>
#include <vector>

#include "sinew/motion/pose.h"
#include "sinew/scene/scene.h"

namespace sinew {

inline constexpr int kRestPose = -1;  // a clip index: no animation, nodes as the file places them

// A node relative to its parent, after animation. A node with a matrix keeps it unless a channel
// moves it.
struct LocalTransform {
  vec3 translation{0.0f};
  quat rotation = glm::identity<quat>();
  vec3 scale{1.0f};
  bool has_matrix = false;
  bool visible = true;
};

// The scene at one time. Owns what its Pose spans point to; reuse one object for all frames and
// nothing is allocated after the first.
struct ScenePose {
  ScenePose() = default;
  ScenePose(ScenePose&&) = default;
  ScenePose& operator=(ScenePose&&) = default;

  double time = 0.0;
  std::vector<Affine> nodes;     // node -> world
  std::vector<uint8_t> visible;  // one a node
  std::vector<Pose> objects;     // one a Scene::objects
  std::vector<Pose> voxels;      // one a Scene::voxels
  uint32_t absent = 0;           // objects left out: placement singular, or a placement, joint or
                                 // morph weight that is not finite; hidden ones do not count

  std::vector<LocalTransform> local;  // scratch: one a node
  std::vector<size_t> skin_begin;     // scratch: where each skin's joints begin in `joints`
  std::vector<Affine> joints;         // what Pose::joints points to: skin by skin, rest -> world
  std::vector<float> weights;         // what Pose::weights points to
  std::vector<vec3> free;             // what Pose::positions points to
};

// `clip` is an index into scene.clips or kRestPose; checked. Before a channel's first key its first
// value holds, after its last key its last value.
void sample(const Scene& scene, int clip, double time, ScenePose& out);

// One channel at one time: writes channel.width values. Rotations come out normalised.
void sample_channel(const Channel& channel, double time, std::span<float> out);

// Positions of object `object` in the world: positions() of its motion, then its placement. One
// entry a vertex.
void world_positions(const Scene& scene, const ScenePose& pose, uint32_t object,
                     std::span<vec3> out);

// Contains every present object, of triangles or voxels, over `samples` times of the clip (at least
// 1).
Box animation_bounds(const Scene& scene, int clip, int samples);

}  // namespace sinew
