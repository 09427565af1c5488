#include "sinew/render/voxels/voxel_batch.h"

#include <cmath>

namespace sinew {

void VoxelBatch::set(uint32_t i, const VoxelSample& sample) {
  for (int axis = 0; axis < 3; ++axis) {
    place[i][axis] = sample.position[axis];
    normal[i][axis] = sample.normal[axis];
    color[i][axis] = sample.color[axis];
  }
  place[i][3] = std::sqrt(3.0f) * sample.size;
  normal[i][3] = sample.spread;
  color[i][3] = 0.0f;
  material[i] = sample.material;
}

void VoxelBatch::pad() {
  for (uint32_t i = count; i % 16 != 0; ++i) {
    for (int axis = 0; axis < 4; ++axis) {
      place[i][axis] = place[count - 1][axis];
      normal[i][axis] = normal[count - 1][axis];
      color[i][axis] = color[count - 1][axis];
    }
    material[i] = material[count - 1];
  }
}

}  // namespace sinew
