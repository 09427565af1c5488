// Convergence in `sinew bench tsah`: the average cost while trees are optimised (T's figures 3 and
// 4, right).
#pragma once

#include <nlohmann/json.hpp>

#include "bench/tsah.h"
#include "bench/tsah_scenes.h"

namespace sinew::bench {

// Rows "convergence_selection" (T's own algorithm with its three ways to select nodes, and ours)
// and "convergence_exponent" (k = 0, 2, 4): a line each. T's own only if options.reference.
void measure_convergence(const TsahScene& scene, const FlatClip& clip, const TsahOptions& options,
                         nlohmann::json& rows);

}  // namespace sinew::bench
