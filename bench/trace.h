// `sinew bench trace`: our trees and kernels against Embree's on T's workload.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sinew/base/error.h"

namespace sinew::bench {

struct TraceOptions {
  std::string scene = "study:bodies";
  std::string clip;
  uint32_t width = 1024;
  uint32_t height = 768;
  uint32_t frames = 3;   // evenly spread over the clip
  uint32_t repeats = 5;  // of every measurement; medians count
  int threads = 2;
};

// The report in the form that all benches share: bench, version, machine, opponents, figures, rows.
Result<nlohmann::json> bench_trace(const TraceOptions& options);

}  // namespace sinew::bench
