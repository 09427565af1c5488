// The parts of `sinew bench update` that pick: few or many random rays into bodies that deform; and
// the time and the size of a full update of these bodies.
#pragma once

#include "bench/engines.h"
#include "bench/update_report.h"
#include "sinew/scene/scene.h"

namespace sinew::bench {

// Rows "ray_count" and "free_motion"; figures picks_100 and picks_10000.
Result<void> measure_picks(const Scene& scene, const UpdateOptions& options, UpdateReport& report);

// Rows "refit"; figure refit_bodies.
Result<void> measure_refit(const Scene& scene, const UpdateOptions& options, UpdateReport& report);

// Rows "bytes"; figure bytes_per_triangle.
Result<void> measure_bytes(const Scene& scene, UpdateReport& report);

}  // namespace sinew::bench
