// What T measured: J. Bittner, D. Meister, "T-SAH: Animation Optimized Bounding Volume
// Hierarchies", 2015, table 1. One thread of a Xeon E5-1620 at 3.6 GHz; c_T = 3, c_I = 2.
#pragma once

#include <string_view>

namespace sinew::bench {

struct PaperCost {
  std::string_view scene;   // of our list
  std::string_view theirs;  // T's name for it
  bool same = false;        // the same input; else one of the same kind, so only ratios compare
  std::string_view method;
  double seconds = 0.0;
  double average = 0.0;
  double maximum = 0.0;
};

// nullptr if T has no such line.
const PaperCost* paper_cost(std::string_view scene, std::string_view method);

}  // namespace sinew::bench
