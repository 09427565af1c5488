// Pose space in `sinew bench tsah`: does one tree for the poses of some clips of a character serve
// others too? T (T-SAH 2015, section 4) suggests sampling the pose space, and does not measure it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/tsah.h"
#include "sinew/base/error.h"

namespace sinew::bench {

// Rows "tsah_poses", two for every clip of a character: the clip held out, and half of it blended
// with half of the next one. Characters whose files are absent add to `skipped`.
Result<void> measure_poses(const TsahOptions& options, nlohmann::json& rows,
                           nlohmann::json& skipped);

std::string poses_text(const nlohmann::json& rows);

}  // namespace sinew::bench
