// `sinew bench update`: what a frame costs from the pose to the hits, ours against Embree's refit
// and rebuild, over the share of the scene that rays reach and over the number of rays.
// After: the tables of T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy
// Updates for Ray Tracing of Deformable Models", 2003, section 4, with today's opponents.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct UpdateOptions {
  std::vector<std::string> only;  // names of parts (update_parts); empty: all
  // Scenes of the visible-fraction sweep: files, study:NAME, or N*FILE for N copies side by side.
  // Empty: the default ones.
  std::vector<std::string> scenes;
  std::string bodies = "study:bodies";  // refit, picks, ray counts
  std::string herd = "study:herd";      // herd_frame
  std::string data;                     // folder of the data that the default scenes need
  uint32_t width = 640;
  uint32_t height = 480;
  uint32_t most_rays = 1000000;  // where the ray-count sweep ends
  uint32_t repeats = 7;          // of every measurement; medians count
  int threads = 2;
};

// What `only` may name: the figures, and the two sweeps that some of them need.
std::vector<std::string> update_parts();

// The report in the form that all benches share; `rows` have a "table" each.
Result<nlohmann::json> bench_update(const UpdateOptions& options);

}  // namespace sinew::bench
