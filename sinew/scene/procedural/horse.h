// A horse: 26 joints, flesh on them, and coats. It faces +Z, stands on y = 0, has its left side at
// +X and is 1.6 m high at the withers. Proportions after E. Muybridge, "Animals in Motion", 1899.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/scene/mesh.h"
#include "sinew/scene/procedural/skeleton.h"

namespace sinew {

enum HorseJoint : uint32_t {
  kCroup,  // the root
  kLoin,
  kWithers,
  kNeck,
  kNape,
  kSkull,
  kDock,                   // the first of kHorseTail
  kHorseLegs = kDock + 4,  // four legs of kLegJoints each
  kHorseJoints = kHorseLegs + 16
};
inline constexpr uint32_t kHorseTail = 4;

// Left before right, fore before hind.
inline constexpr uint32_t kHorseLegCount = 4;
inline LegJoints horse_leg(uint32_t leg) {
  const uint32_t first = kHorseLegs + kLegJoints * leg;
  return {first, first + 1, first + 2, first + 3};
}

using HorseSkeleton = std::array<SkeletonJoint, kHorseJoints>;
const HorseSkeleton& horse_skeleton();

// Bay, chestnut, black, grey, dun.
inline constexpr uint32_t kCoats = 5;

// The same shape in every coat, as vertex colours; about `triangles` triangles, one closed surface.
std::vector<Mesh> make_horses(uint32_t triangles, uint32_t material);

}  // namespace sinew
