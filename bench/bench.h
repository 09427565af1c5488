// `sinew bench`: measures against opponents in one process, interleaved, medians, as ratios.
#pragma once

#include "app/command.h"

namespace sinew::app {

Run define_bench(CLI::App& options);

}  // namespace sinew::app
