// `sinew bench bounds`: prints what derived boxes are worth, scene by scene.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct BoundsCommand {
  std::function<bool()> parsed;
  Run run;
};
BoundsCommand define_bounds(CLI::App& bench);

}  // namespace sinew::app
