// The parts of `sinew bench update` that draw: 640x480 primary and shadow rays of a scene of which
// more and more is seen, and of `herd` as its own camera sees it.
#pragma once

#include "bench/engines.h"
#include "bench/update_report.h"

namespace sinew::bench {

// Rows "visible_fraction". A camera looks at the scene's middle through a narrower and narrower
// lens; the fraction is of the deforming objects' treelets that rays reached in mode `lazy`.
Result<void> sweep_visible(Scene scene, const std::string& name, const UpdateOptions& options,
                           UpdateReport& report);

// Figure visible_30, from the rows of all sweeps.
void add_visible_30(UpdateReport& report);

// Rows "herd_frame"; the figure of that name.
Result<void> measure_herd(const UpdateOptions& options, UpdateReport& report);

}  // namespace sinew::bench
