// `sinew bench voxtrace`: rays through octrees in poses.
#pragma once

#include "app/command.h"

namespace sinew::app {

// Adds the subcommand to `bench`. Run what comes back if `parsed` says that it was given.
struct VoxtraceCommand {
  std::function<bool()> parsed;
  Run run;
};
VoxtraceCommand define_voxtrace(CLI::App& bench);

}  // namespace sinew::app
