// The program: finds the subcommand, reads its options, runs it, and turns what happened into an
// exit code. Each subcommand has its own file and one row in the table below.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/help_format.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/values.h"
#include "sinew/bvh/trace/traverse.h"
#include "sinew/io/output_file.h"
#ifdef SINEW_HAVE_BENCH
#include "bench/bench.h"
#endif

namespace sinew::app {
namespace {

constexpr Command kCommands[] = {
    {"info", "Says what a file holds: sizes, clips, cameras, warnings", define_info},
    {"render", "Draws an animation: a .png or .exr a frame, or a .webp or .mp4 movie",
     define_render},
    {"optimize", "Makes trees that suit a whole animation, for render --tree", define_optimize},
    {"compare", "Says how much two pictures differ", define_compare},
    {"voxelize", "Turns meshes into octrees of voxels that move with their skeletons",
     define_voxelize},
    {"scene", "Writes a scene as glTF, for other programs", define_scene},
#ifdef SINEW_HAVE_BENCH
    {"bench", "Measures against Embree", define_bench},
#endif
};

constexpr const char* kHelp =
    "sinew ray traces and draws animated geometry without rebuilding anything per frame.";

constexpr const char* kFooter =
    "Examples:\n"
    "  sinew info walk.glb\n"
    "  sinew render walk.glb -o walk.webp\n"
    "  sinew render study:creature -o out_####.png --frames 1-24\n"
    "`sinew COMMAND --help` says more.\n"
    "\n"
    "Exit codes: 0 done, 1 something failed, 2 wrong usage, 3 bad input, 4 output failure,\n"
    "5 the pictures differ, 130 and 143 ended by a signal.";

// CLI11's help, wrapped, and without its notes on what a flag's words stand for.
class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    std::string name = Formatter::make_option_name(option, is_positional);
    return name.substr(0, name.find('{'));
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrap(option->get_description(), kHelpWidth - get_column_width());
  }
};

int report(const Error& error) {
  print_error(error.message());
  return exit_code(error.kind);
}

int print(const std::string& text) {
  const Result<void> written = write_file("-", text);
  return written ? kOk : report(written.error());
}

std::string hint(const std::string& typed, const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(typed, known);
  return nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest);
}

// What is wrong with the first word after the program's name; empty if it may be a command.
std::string check_command(int argc, char** argv) {
  std::vector<std::string> names;
  for (const Command& command : kCommands) names.emplace_back(command.name);
  if (argc < 2) return fmt::format("a command is missing: {}", fmt::join(names, ", "));
  const std::string word = argv[1];
  if (word.starts_with("-") || std::find(names.begin(), names.end(), word) != names.end())
    return "";
  return fmt::format("'{}' is not a command{}", word, hint(word, names));
}

// The innermost command that was read: `sinew bench update`.
const CLI::App& innermost(const CLI::App& app) {
  const auto below = app.get_subcommands();
  return below.empty() ? app : innermost(*below.front());
}

std::string full_name(const CLI::App& app) {
  const CLI::App* const above = app.get_parent();
  return above == nullptr ? app.get_name() : full_name(*above) + " " + app.get_name();
}

// What CLI11 has to say, with a suggestion where an option was misspelt.
std::string explain(const CLI::ParseError& error, const CLI::App& command) {
  const std::vector<std::string> unknown = command.remaining();
  const bool is_option = !unknown.empty() && unknown[0].starts_with("-");
  if (command.get_require_subcommand_min() > 0 && !is_option) {
    std::vector<std::string> names;
    for (const CLI::App* below : command.get_subcommands({})) names.push_back(below->get_name());
    if (unknown.empty()) return fmt::format("a command is missing: {}", fmt::join(names, ", "));
    return fmt::format("'{}' is not a command of {}{}", unknown[0], full_name(command),
                       hint(unknown[0], names));
  }
  if (!is_option) return error.what();
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& word : option->get_lnames()) options.push_back("--" + word);
  }
  const std::string word = unknown[0].substr(0, unknown[0].find('='));
  return fmt::format("{} is not an option of this command{}", word, hint(word, options));
}

int run(int argc, char** argv) {
  if (const std::string problem = check_command(argc, argv); !problem.empty()) {
    print_error(problem + "\nTry `sinew --help`.");
    return kUsageError;
  }
  CLI::App app{kHelp, "sinew"};
  app.formatter(std::make_shared<HelpFormat>());
  app.footer(kFooter);
  app.set_version_flag("--version", fmt::format("sinew {} ({})", SINEW_VERSION, kernel_target()));
  app.require_subcommand(1);
  Run work;
  for (const Command& command : kCommands) {
    CLI::App* const options = app.add_subcommand(command.name, command.summary);
    options->final_callback([&work, run = command.define(*options)] { work = run; });
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return print(app.help());
  } catch (const CLI::CallForVersion& version) {
    return print(std::string(version.what()) + "\n");
  } catch (const CLI::ParseError& error) {
    const CLI::App& command = innermost(app);
    print_error(fmt::format("{}\nTry `{} --help`.", explain(error, command), full_name(command)));
    return kUsageError;
  }
  const Result<int> result = work();
  return result ? *result : report(result.error());
}

}  // namespace

int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::runtime:
      return kRuntimeError;
    case ErrorKind::usage:
      return kUsageError;
    case ErrorKind::bad_input:
      return kBadInput;
    case ErrorKind::output:
      return kOutputFailure;
  }
  return kRuntimeError;
}

}  // namespace sinew::app

int main(int argc, char** argv) {
  sinew::app::watch_signals();
  try {
    return sinew::app::run(argc, argv);
  } catch (const std::bad_alloc&) {
    sinew::app::print_error("out of memory (use a smaller input or --size)");
  } catch (const std::exception& error) {
    sinew::app::print_error(error.what());
  }
  return sinew::app::kRuntimeError;
}
