// Rasterised against ray traced voxels, and crowds.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/voxtrace.h"
#include "bench/voxtrace_engines.h"

namespace sinew::bench {

// Rows "voxtrace_picture": silhouettes and PSNR, at the finest level and at that of a pixel.
void compare_pictures(const VoxtraceWorlds& worlds, const CameraView& camera, double u,
                      const VoxtraceOptions& options, nlohmann::json& rows);

// Rows "voxtrace_crowd": instances each in a pose of its own.
Result<void> measure_crowds(const AsvoBody& body, const VoxtraceOptions& options,
                            nlohmann::json& rows);

}  // namespace sinew::bench
