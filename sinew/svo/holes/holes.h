// Holes and excess: how the pixels that voxels cover differ from the surface that they stand for.
//
//   hole     a pixel whose centre the surface covers, but no voxel, or only one that lies more than
//            two deformed voxels behind
//   excess   a pixel that voxels cover though no part of the surface is within 1.5 pixels of its
//            centre
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/svo/draw/visibility.h"

namespace sinew {

inline constexpr float kHoleVoxels = 2.0f;    // deformed voxels
inline constexpr float kExcessPixels = 1.5f;  // from the surface

// The surface as a picture should show it; see hole_reference.h for who makes it.
struct SurfacePicture {
  uint32_t width = 0, height = 0;
  std::vector<float> depth;       // at the pixel's centre; infinite: the surface is not there
  std::vector<float> size;        // the longest side of a deformed voxel there; world
  std::vector<uint16_t> touched;  // bit x + 4 y: a point of the surface lies in this 16th of the
                                  // pixel
};

struct HoleCount {
  uint64_t surface = 0;  // pixels whose centre the surface covers
  uint64_t covered = 0;  // by voxels
  uint64_t holes = 0;
  uint64_t excess = 0;

  HoleCount& operator+=(const HoleCount& more);
};

// Sizes must agree (checked). `marks`, if not null, gets one entry a pixel: 1 a hole, 2 excess.
HoleCount count_holes(const SurfacePicture& surface, const Visibility& picture,
                      std::vector<uint8_t>* marks = nullptr);

}  // namespace sinew
