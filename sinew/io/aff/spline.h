// Kochanek-Bartels splines as BART defines its keyframes by them.
// Based on: D. Kochanek, R. Bartels, "Interpolating Splines with Local Tension, Continuity, and
// Bias Control", SIGGRAPH 1984; D. Eberly's adaptation to keys of uneven spacing and to quaternions
// (squad with tangents in the logarithm), which BART's animation code uses; the first and the last
// key only shape the tangents.
// Differs in that axes are brought to unit length, and that arcs below 0.001 radians are
// interpolated too.
#pragma once

#include <span>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/clip.h"

namespace sinew::aff {

template <class Value>
struct SplineKey {
  double time = 0.0;  // seconds
  Value value{};
  double tension = 0.0;
  double continuity = 0.0;
  double bias = 0.0;
};
using VectorKey = SplineKey<glm::dvec3>;
using RotationKey = SplineKey<glm::dquat>;  // unit length; either of the two signs counts

inline constexpr size_t kLeastKeys = 4;
inline constexpr int kMostPieces = 256;  // keys of a rotation channel for each key of the file

// Keys whose time goes back are passed over until time has come up with them again, and keys at one
// time make a jump, as BART's code does.

// Exactly the spline, as a cubic_spline channel of 3 values; the node and path are the caller's.
// At least kLeastKeys keys.
Channel vector_channel(std::span<const VectorKey> keys);

// The spline to within 2e-5 radians, as a cubic_spline rotation channel.
Channel rotation_channel(std::span<const RotationKey> keys);

}  // namespace sinew::aff
