// Table 1 of `sinew bench tsah`: what trees cost over the animation by the surface area heuristic.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "bench/tsah.h"
#include "bench/tsah_methods.h"

namespace sinew::bench {

// Rows "tsah_cost" (a method) and "cost_over_frames" (its line in a plot). Trees for every frame
// are made for some of the frames only where the scene is large; `average_common` is over these.
void measure_costs(const TsahScene& scene, const FlatClip& clip,
                   std::span<const MethodTrees> methods, const TsahOptions& options,
                   nlohmann::json& rows);

// A number of a row of "tsah_cost"; NaN if there is none.
double cost_of(const nlohmann::json& rows, std::string_view scene, std::string_view method,
               const char* what);

// Figures cost_moderate, recovered, best_single_frame, optimise_250k_s, optimise_1600k_s, as far as
// scenes for them were measured.
void add_cost_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
