// Animations of boxes, made up by a test.
#pragma once

#include <functional>
#include <utility>

#include "sinew/bvh/frames/frame_choice.h"

namespace sinew {

inline Box box_at(vec3 center, float half = 0.01f) {
  return {center - vec3(half), center + vec3(half)};
}

// Frames follow each other by `seconds`.
inline AnimatedBoxes animation_of(uint32_t primitives, uint32_t frames,
                                  std::function<void(uint32_t, std::span<Box>)> boxes,
                                  double seconds = 1.0) {
  AnimatedBoxes out;
  out.primitive_count = primitives;
  for (uint32_t f = 0; f < frames; ++f) out.times.push_back(seconds * f);
  out.boxes = std::move(boxes);
  return out;
}

}  // namespace sinew
