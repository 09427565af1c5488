// `sinew bench tsah`: one tree for a whole animation.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct TsahCommand {
  std::function<bool()> parsed;
  Run run;
};
TsahCommand define_tsah(CLI::App& bench);

}  // namespace sinew::app
