// What `sinew voxelize` says it has done.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sinew::app {

struct VoxelizedObjectReport {
  std::string name;
  uint32_t resolution[3] = {};
  uint64_t triangles = 0;
  uint64_t voxels = 0;
  uint64_t bytes = 0;    // in memory; 0: not an octree
  uint64_t parts = 1;    // in which it was made
  double seconds = 0.0;  // from triangles to the octree
};

struct VoxelizeReport {
  std::string input, output;
  double voxel = 0.0;  // side, in the world
  std::string shell;
  bool solid = false;
  int threads = 1;
  uint32_t frames = 1;
  std::vector<VoxelizedObjectReport> objects;
  uint64_t voxels = 0;      // over objects and frames
  uint64_t file_bytes = 0;  // 0: standard output
  double make_s = 0.0;      // triangles to voxels and octrees, packed if they are kept on disk
  uint64_t peak_bytes = 0;  // of memory that the program held at once
  double total_s = 0.0;
  std::vector<std::string> warnings;
};

std::string table_of(const VoxelizeReport& report);
std::string json_of(const VoxelizeReport& report);

}  // namespace sinew::app
