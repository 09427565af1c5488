// Part `thesis`: what the lattice is worth against skinning every voxel.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/asvo.h"
#include "bench/asvo_body.h"

namespace sinew::bench {

// Pictures of the moving body by the lattice, by our rasteriser with every voxel skinned (twice: by
// gathers, and by palettes in registers), and by the thesis's own method; rows "asvo_rival".
void measure_rivals(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// `over_thesis` and `over_thesis_literal` from the rows.
void add_rival_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
