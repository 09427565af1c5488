// `sinew bench asvo`: animated octrees.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct AsvoCommand {
  std::function<bool()> parsed;
  Run run;
};
AsvoCommand define_asvo(CLI::App& bench);

}  // namespace sinew::app
