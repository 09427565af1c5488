// Parts `memory`, `voxelise`, `revoxelise`: what octrees take, and what making them costs.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/asvo.h"
#include "bench/asvo_body.h"

namespace sinew::bench {

// Bytes by part in memory and in a file, beside those of the thesis's methods; rows "asvo_bytes".
Result<void> measure_bytes(const AsvoBody& body, nlohmann::json& rows);

// Voxels and triangles a second of one thread, with attributes; rows "asvo_voxelise".
Result<void> measure_voxelise(const AsvoBody& body, const AsvoOptions& options,
                              nlohmann::json& rows);

// From a pose to an octree that can be drawn: moving the vertices, voxelising and making a rigid
// octree, against our pose with every block made; rows "asvo_revoxelise".
Result<void> measure_revoxelise(const AsvoBody& body, const AsvoOptions& options,
                                nlohmann::json& rows);

// `bytes_memory`, `bytes_disk`, `voxelise_per_core`, `over_revoxelise` from the rows.
void add_volume_figures(const nlohmann::json& rows, nlohmann::json& figures);

}  // namespace sinew::bench
