// A horse at the gallop over uneven ground: hooves stay where they were set down.
// Based on: M. Hildebrand, "Analysis of asymmetrical gaits", Journal of Mammalogy 58, 1977 (the
// transverse gallop: hind, hind, fore, fore, then all in the air).
#pragma once

#include <array>
#include <functional>

#include "sinew/scene/procedural/horse.h"

namespace sinew {

inline constexpr float kGallopDuty = 0.25f;  // share of a stride that a hoof stands

struct Gallop {
  float stride_seconds = 0.5f;
  float phase = 0.0f;       // of the stride at time 0, 0 to 1
  bool right_lead = false;  // which fore hoof is last
  float scale = 1.0f;       // of the horse
  float speed = 8.0f;       // metres a second

  // Where the horse's origin is at a time, on the ground, and how it is turned.
  std::function<JointFrame(double time)> way;
  std::function<float(float x, float z)> ground;  // height, metres
};

struct HorsePose {
  vec3 croup{0.0f};                         // position in the horse's own space
  std::array<quat, kHorseJoints> rotation;  // against the parent; at rest all are identity
};

HorsePose gallop_pose(const Gallop& gallop, double time);

// Whether the hoof of this leg stands at the time.
bool hoof_stands(const Gallop& gallop, uint32_t leg, double time);

}  // namespace sinew
