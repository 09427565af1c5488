// Attributes of the levels above the voxels: means over the voxels below.
#pragma once

#include "sinew/svo/format.h"

namespace sinew {

// What the attributes of a node are the mean of: its voxels.
struct AttributeSum {
  vec3 normal{0.0f};
  vec3 color{0.0f};
  float voxels = 0.0f;

  void add(const AttributeSum& other) {
    normal += other.normal;
    color += other.color;
    voxels += other.voxels;
  }
};

// A node's attributes as they are stored.
struct PackedMean {
  uint16_t normal = 0;
  uint16_t color = 0;
  uint8_t spread = 0;
};
PackedMean mean_of(const AttributeSum& sum);

// Sums over the voxels of a brick.
AttributeSum sum_of_brick(const uint16_t* normals, const uint16_t* colors, uint32_t count);
AttributeSum sum_of_brick(const uint16_t* normals, SvoColorEnds ends, const uint8_t* selectors,
                          uint32_t count);

void append_mean(const AttributeSum& sum, SvoLevel& out);

// Fills brick_level and cell_level of one block from its voxels. All arrays have their sizes.
void filter_levels(Svo& svo, uint32_t block);
// Level 2 alone.
void filter_brick_level(Svo& svo, uint32_t block);

}  // namespace sinew
