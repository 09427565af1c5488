// Part `holes`: holes, excess, and how far the lattice is from true skinning.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/asvo.h"
#include "bench/asvo_body.h"

namespace sinew::bench {

// Adds rows "asvo_holes" and "asvo_distance" of the body: its clip, and its longest bone 1 to 8
// times as long. Rigid bodies have no distance and no stretch.
void measure_holes(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// `holes` and `excess` from the rows.
void add_hole_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
