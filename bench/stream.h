// `sinew bench stream`: octrees larger than their share of memory, drawn while their detail comes
// and goes, against the same octrees read as a whole.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct StreamOptions {
  std::string file;             // a .svo; empty: `body` is voxelised
  std::string body = "pigman";  // or "creature"
  std::string creature = "study:creature,triangles=250000";
  std::string data;  // folder of pigman
  uint32_t resolution = 1536;
  uint32_t size = 800;                              // pixels a side
  uint32_t frames = 240;                            // of the flight
  std::vector<uint32_t> budgets = {64, 256, 1024};  // MiB
  uint32_t flight_budget = 256;                     // MiB
  int threads = 2;
};

// A report in the form that all benches share; `rows` have a "table" each.
Result<nlohmann::json> bench_stream(const StreamOptions& options);

std::string stream_text(const nlohmann::json& report);
std::string stream_page(const nlohmann::json& report);

}  // namespace sinew::bench
