// `sinew bench voxtrace`: rays through octrees in poses, against the triangles that they come from
// and against octrees that are voxelised anew in each pose.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct VoxtraceOptions {
  std::vector<std::string> only;                          // parts (voxtrace_parts()); empty: all
  std::string body = "study:creature,triangles=1000000";  // as load() takes it; skinned
  std::string crowd_body = "study:creature,triangles=100000";
  uint32_t resolution = 1024;
  uint32_t crowd_resolution = 512;
  uint32_t crowd = 1000;      // where the sweep of crowds ends
  uint32_t poses = 3;         // of the first clip
  uint32_t size = 800;        // pixels a side
  uint32_t rays = 1'000'000;  // about how many of each kind at most
  uint32_t repeats = 7;       // of every time; medians count
  int threads = 2;
};

std::vector<std::string> voxtrace_parts();

// A report in the form that all benches share; `rows` have a "table" each.
Result<nlohmann::json> bench_voxtrace(const VoxtraceOptions& options);

std::string voxtrace_text(const nlohmann::json& report);
std::string voxtrace_page(const nlohmann::json& report);

}  // namespace sinew::bench
