// `sinew bench bounds`: how loose the derived boxes of clusters are, and what they cost.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

struct BoundsOptions {
  std::vector<std::string> scenes = {"study:creature", "study:herd", "study:bodies",
                                     "study:bodies,subdivisions=4"};
  std::string clip;
  std::vector<std::string> skip;  // nodes to leave out, by name
  uint32_t frames = 8;            // evenly spread over the clip
  uint32_t repeats = 7;           // of every measurement; medians count
  uint32_t most_pieces = 4;       // see ClusterConfig
};

// One row a scene. Clusters are the treelets of the layout that is built for the middle of the
// clip; only bodies that deform count. The report has the form that all benches share.
Result<nlohmann::json> bench_bounds(const BoundsOptions& options);

}  // namespace sinew::bench
