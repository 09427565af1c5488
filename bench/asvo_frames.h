// Parts `frames`, `size`, `grade`, `resolution`, `splats`: what pictures cost.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/asvo.h"
#include "bench/asvo_body.h"

namespace sinew::bench {

// Whole frames with Phong shading, normals of normal maps, a shadow map and skinning; rows
// "asvo_frame" with the time of every stage.
Result<void> measure_frames(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// The same against the body's share of the picture, after A's figure 3; rows "asvo_size".
Result<void> measure_sizes(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// How far levels of detail reach against how much is animated, after A's figure 9; rows
// "asvo_grade": the clip's movement from none to twice itself, and voxels drawn for a small picture
// of the body.
void measure_grades(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// Frames of the body in coarser and finer voxels; rows "asvo_resolution". The body is left in
// the finest of them.
Result<void> measure_resolutions(AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// Splats a second of one thread; rows "asvo_splats".
void measure_splats(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows);

// `fps_800` and `splats_per_core` from the rows.
void add_drawing_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
