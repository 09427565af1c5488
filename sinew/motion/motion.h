// Motions: how the vertices of a body follow its pose. A motion is a small struct of views over
// constant mesh data; Motion is their variant. Each motion answers, for a Pose,
//   positions(vertices)  where these vertices are, in the object's space (before placement), and
//   bounds(vertices)     a box that contains those positions, bit for bit.
// Order as glTF 2.0 says: morph, then skin, then placement. A vertex is computed the same way in
// every call, whatever its neighbours are, so its bits do not depend on lanes, ranges or threads.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "sinew/math/box.h"
#include "sinew/motion/pose.h"

namespace sinew {

// The vertices stay where they rest; only the placement moves.
struct RigidMotion {
  std::span<const vec3> rest;
};

// Linear blend skinning: p' = (sum_k weight_k * joints[index_k]) * p, summed in the order of k.
struct SkinMotion {
  std::span<const vec3> rest;
  uint32_t influences = 0;           // a vertex; unused ones have weight 0
  std::span<const uint16_t> joints;  // vertex-major: [vertex * influences + k]
  std::span<const float> weights;    // same layout; sum to 1 a vertex
  uint32_t joint_count = 0;          // all of `joints` are below it
};

// Blend shapes: p' = p + sum_t weight_t * delta_t, then the skin if there is one.
struct MorphMotion {
  std::span<const vec3> rest;
  std::span<const vec3> deltas;  // target-major: [target * rest.size() + vertex]
  SkinMotion skin;               // influences == 0: none; its `rest` is ignored
};

// A vertex cache: linear in time between stored samples.
struct KeyframeMotion {
  uint32_t vertex_count = 0;
  std::span<const vec3> keys;  // key-major: [key * vertex_count + vertex]
};

// The caller gives new vertices each frame (Pose::positions).
struct FreeMotion {
  uint32_t vertex_count = 0;
};

using Motion = std::variant<RigidMotion, SkinMotion, MorphMotion, KeyframeMotion, FreeMotion>;

uint32_t vertex_count(const Motion& motion);

// Whether the vertices move within the object, so that its hierarchy must follow.
inline bool deforms(const Motion& motion) {
  return !std::holds_alternative<RigidMotion>(motion);
}

// Positions of the vertices [first, first + out.size()).
void positions(const Motion& motion, const Pose& pose, uint32_t first, std::span<vec3> out);

// Positions of the listed vertices: out[i] = position of vertices[i]. Sizes must agree.
void positions(const Motion& motion, const Pose& pose, std::span<const uint32_t> vertices,
               std::span<vec3> out);

// Contains positions() of each listed vertex. Exact now: it visits the vertices.
Box bounds(const Motion& motion, const Pose& pose, std::span<const uint32_t> vertices);

// The linear map that carries the vertex's neighbourhood from rest to pose (the blended skin
// matrix; identity for other motions). Normals follow its cofactor, tangents the map itself.
mat3 local_map(const Motion& motion, const Pose& pose, uint32_t vertex);

// Whether the pose fits the motion: at least joint_count joints, one weight a target, one position
// a vertex, a key in range (the last one with fraction 0). Constant time.
bool pose_fits(const Motion& motion, const Pose& pose);

// Every invariant that evaluation relies on: sizes that agree, joint indices below joint_count.
// Empty text if all hold. Visits all indices: for once a body, not for every frame.
std::string validate(const Motion& motion);

}  // namespace sinew
