// The pieces of study:fracture: how the shell is cut, and how the pieces fly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/mesh.h"

namespace sinew {

// Parts of a shell's mesh: its outer side, its inner side, and where it broke.
enum ShellPart : uint32_t { kShellOutside, kShellInside, kShellBreak };

// An egg-shaped shell, cut into pieces that are closed each; piece p's vertices are bound to joint
// p + 1 with weight 1. While all joints are in place the pieces fit without gaps.
// `triangles` is met exactly if it is even, else one less. Needs triangles >= 60 * pieces.
Mesh make_shell(uint32_t triangles, uint32_t pieces);

// Where a rigid piece is.
struct PiecePose {
  vec3 center{0.0f};
  quat rotation = glm::identity<quat>();
};

// One piece, thrown at `start` seconds and bouncing on the plane y = 0.
struct FlightConfig {
  vec3 velocity{0.0f};  // m/s
  vec3 spin{0.0f};      // rad/s
  float start = 0.0f;   // seconds
  float gravity = 9.81f;
  float restitution = 0.25f;
  float friction = 0.5f;
};

// The poses at `times` (increasing, from 0) of the piece made of `points` around `center`.
std::vector<PiecePose> fly(std::span<const vec3> points, vec3 center, const FlightConfig& config,
                           std::span<const float> times);

}  // namespace sinew
