// `sinew bench larsson`: prints L's tables.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct LarssonCommand {
  std::function<bool()> parsed;
  Run run;
};
LarssonCommand define_larsson(CLI::App& bench);

}  // namespace sinew::app
