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

// Where the attributes of one cell stand: of its first voxel at levels 0, 1, 2, and its own.
struct CellAttributes {
  uint16_t* normals[4];
  uint16_t* colors[4];
  uint8_t* spreads[4];  // [0] is not used
};

// Fills levels 1 to 3 of a cell from level 0. `bricks` are the cell's; of the cell, `coarse` and
// `bricks` must be filled. Returns the sum over its voxels.
AttributeSum filter_cell(const SvoCell& cell, const uint64_t* bricks, const CellAttributes& at);

// Fills levels[1], levels[2] and cell_level of one block from levels[0] and the topology. All
// arrays have their sizes.
void filter_levels(Svo& svo, uint32_t block);

}  // namespace sinew
