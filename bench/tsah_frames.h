// Table 2 of `sinew bench tsah`: whole frames, from the vertices to the hits, by every method and
// by Embree's modes, on T's workload.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "bench/tsah.h"
#include "bench/tsah_methods.h"
#include "sinew/base/error.h"

namespace sinew::bench {

// Rows "tsah_frame" (means over the frames, one a method and triangle test) and "frame_time" (its
// line in a plot).
Result<void> measure_frames(const TsahScene& scene, FlatClip& clip,
                            std::span<const MethodTrees> methods, const TsahOptions& options,
                            nlohmann::json& rows);

// Figures frame_full, frame_primary, segments_regret, as far as scenes for them were measured.
void add_frame_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
