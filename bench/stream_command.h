// `sinew bench stream`: octrees larger than their share of memory.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct StreamCommand {
  std::function<bool()> parsed;
  Run run;
};
StreamCommand define_stream(CLI::App& bench);

}  // namespace sinew::app
