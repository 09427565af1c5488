// `sinew bench asvo`: animated octrees against the thesis that had the idea, against skinning every
// voxel, and against voxelising every frame.
// After the figures of: D. Bautembach, "Animated Sparse Voxel Octrees", Hamburg 2011.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct AsvoOptions {
  std::vector<std::string> only;    // parts (asvo_parts()); empty: all
  std::vector<std::string> bodies;  // of asvo_bodies(); empty: all
  std::string data;                 // folder of the bodies that are not ours
  std::string creature = "study:creature,triangles=250000";
  uint32_t fine = 2560;        // the creature's, where times and bytes count: about 3M voxels
  uint32_t resolution = 1024;  // of all else, but for the sweep of resolutions
  uint32_t size = 800;         // pixels a side
  uint32_t frames = 12;        // of each clip, where pictures are compared
  uint32_t repeats = 7;        // of every time; medians count
  int threads = 2;
};

// What `only` and `bodies` may name.
std::vector<std::string> asvo_parts();
std::vector<std::string> asvo_bodies();

// A report in the form that all benches share (`rows` have a "table" each), and pictures for its
// page as HTML.
struct AsvoReport {
  nlohmann::json json;
  std::string pictures;
};
Result<AsvoReport> bench_asvo(const AsvoOptions& options);

}  // namespace sinew::bench
