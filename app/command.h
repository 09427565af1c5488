// How subcommands plug into the program: one file each, one row in main.cpp's table.
// A command declares its options on a CLI::App and returns what is to be done once they are parsed.
#pragma once

#include <functional>

#include "sinew/base/error.h"

namespace CLI {
class App;
}

namespace sinew::app {

// Beside these, a program that a signal ends exits with 128 + the signal's number.
enum ExitCode : int {
  kOk = 0,
  kRuntimeError = 1,
  kUsageError = 2,
  kBadInput = 3,
  kOutputFailure = 4,
  kMismatch = 5,  // compare: the images differ
};

int exit_code(ErrorKind kind);

using Run = std::function<Result<int>()>;  // gives the exit code

struct Command {
  const char* name;
  const char* summary;
  Run (*define)(CLI::App& options);
};

Run define_info(CLI::App& options);
Run define_render(CLI::App& options);
Run define_optimize(CLI::App& options);
Run define_compare(CLI::App& options);
Run define_scene(CLI::App& options);
Run define_voxelize(CLI::App& options);

}  // namespace sinew::app
