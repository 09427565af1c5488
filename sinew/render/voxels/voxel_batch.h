// VoxelBatch: what shading needs to know about some voxels that win pixels, fetched once each.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/svo/draw/visibility.h"

namespace sinew {

inline constexpr uint32_t kMostWinners = 512;

// Arrays are filled up to the next multiple of 16 with copies of the last voxel.
struct VoxelBatch {
  uint32_t count = 0;
  alignas(64) float place[kMostWinners][4];   // world: middle of the drawn voxel; its diagonal
  alignas(64) float normal[kMostWinners][4];  // world, of any length; then VoxelSample::spread
  alignas(64) float color[kMostWinners][4];   // linear; then 0
  alignas(64) uint32_t material[kMostWinners];

  void set(uint32_t i, const VoxelSample& sample);
  void pad();
};

// A view of a callable `void(std::span<const VisibilityKey> keys, VoxelBatch& out)`, which fills a
// batch for at most kMostWinners keys. No ownership.
class VoxelFetch {
 public:
  template <class F>
  VoxelFetch(const F& function)
      : context_(&function),
        call_([](const void* context, std::span<const VisibilityKey> keys, VoxelBatch& out) {
          (*static_cast<const F*>(context))(keys, out);
        }) {}
  void operator()(std::span<const VisibilityKey> keys, VoxelBatch& out) const {
    call_(context_, keys, out);
  }

 private:
  const void* context_;
  void (*call_)(const void*, std::span<const VisibilityKey>, VoxelBatch&);
};

// From octrees in poses, whose blocks with these voxels must have been made. Cells that many voxels
// of a batch lie in are prepared once. Equal to sample_voxel() but for rounding, and for the
// diagonal, which is that of the deformed cell's eighth.
void fetch_voxels(std::span<const VoxelInstance> instances, std::span<const VisibilityKey> keys,
                  VoxelBatch& out);

}  // namespace sinew
