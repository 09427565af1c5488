// `sinew bench trace`: our trees and kernels against Embree's, by kind of ray and by call, on T's
// workload; on trees made for the frame, and on trees of the clip's beginning refit to it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct TraceOptions {
  std::vector<std::string> scenes = {"study:bodies", "study:creature", "study:twist",
                                     "study:herd,count=24,triangles=20000,terrain=500000"};
  std::string clip;  // name or index; empty: the first
  uint32_t width = 1024;
  uint32_t height = 768;
  uint32_t frames = 1;          // evenly spread over the clip
  uint32_t repeats = 5;         // of every measurement; medians count
  uint32_t most_rays = 300000;  // of a kind
  int threads = 2;
};

// The report in the form that all benches share: bench, version, machine, opponents, figures, rows.
Result<nlohmann::json> bench_trace(const TraceOptions& options);

}  // namespace sinew::bench
