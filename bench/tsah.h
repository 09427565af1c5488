// `sinew bench tsah`: one tree for a whole animation against trees of single frames, against
// rebuilding and against Embree. After the tables and figures of T: J. Bittner, D. Meister,
// "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015, section 6.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct TsahOptions {
  // See find_tsah_scene(). "all": the list but the quick ones; empty: the quick ones.
  std::vector<std::string> scenes;
  std::vector<std::string> only;  // parts (tsah_parts()); empty: all
  std::string data;               // folder of the scenes that are not ours
  uint32_t evaluated = 50;        // frames of table 1
  uint32_t representatives = 5;
  bool reference = false;      // T's own algorithm too: one thread, minutes
  double most_seconds = 60.0;  // of one run of it in convergence plots
  uint32_t width = 1024;       // table 2
  uint32_t height = 768;
  uint32_t frames = 3;  // of table 2, evenly spread over the clip
  uint32_t repeats = 3;
  int threads = 2;
};

// What `only` may name.
std::vector<std::string> tsah_parts();

// A report in the form that all benches share (`rows` have a "table" each), and pictures for its
// page as SVG, which are no figures and so stand apart.
struct TsahReport {
  nlohmann::json json;
  std::string pictures;
};
Result<TsahReport> bench_tsah(const TsahOptions& options);

}  // namespace sinew::bench
