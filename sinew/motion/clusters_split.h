// Fits a cluster by one piece, or by a few where trial poses show that this pays.
#pragma once

#include <span>

#include "sinew/motion/clusters_fit.h"

namespace sinew {

// Appends the pieces of a cluster whose vertices can all be finite. `motion` is the source's.
void fit_cluster(const FitSource& source, const Motion& motion, std::span<const uint32_t> vertices,
                 const ClusterConfig& config, FitStore& out);

}  // namespace sinew
