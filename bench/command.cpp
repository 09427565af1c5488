#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/asvo_command.h"
#include "bench/bench.h"
#include "bench/bounds_command.h"
#include "bench/larsson_command.h"
#include "bench/report.h"
#include "bench/stream_command.h"
#include "bench/tables.h"
#include "bench/trace.h"
#include "bench/tsah_command.h"
#include "bench/update.h"
#include "bench/voxtrace_command.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct BenchOptions {
  bench::TraceOptions trace;
  bench::UpdateOptions update;
  std::string json, report;
  bool does_update = false;
};

Result<int> run(const BenchOptions& options) {
  for (const std::string& file : {options.json, options.report}) {
    if (!file.empty()) SINEW_CHECKED(check_writable(file));
  }
  const auto measure = [&] {
    return options.does_update ? bench::bench_update(options.update)
                               : bench::bench_trace(options.trace);
  };
  SINEW_TRY(const nlohmann::json report, measure());
  if (options.json != "-") {
    const std::string text =
        options.does_update ? bench::update_text(report) : bench::trace_text(report);
    SINEW_CHECKED(write_file("-", text));
  }
  if (!options.json.empty()) SINEW_CHECKED(write_file(options.json, json_text(report)));
  if (!options.report.empty()) {
    SINEW_CHECKED(write_file(options.report, bench::report_page(report)));
  }
  return kOk;
}

void add_common(CLI::App& command, BenchOptions& options, uint32_t& width, uint32_t& height,
                uint32_t& repeats, int& threads) {
  command.add_option("--width", width, fmt::format("Pixels (default: {})", width))
      ->check(whole_number_in(1, 8192));
  command.add_option("--height", height, fmt::format("Pixels (default: {})", height))
      ->check(whole_number_in(1, 8192));
  command
      .add_option("--repeats", repeats,
                  fmt::format("Of every measurement; medians count (default: {})", repeats))
      ->check(whole_number_in(1, 1000));
  command.add_option("--threads", threads, "For both opponents (default: 2)")
      ->check(whole_number_in(1, 256));
  command.add_option("--json", options.json,
                     "Write figures and rows; - for stdout, instead of the tables");
  command.add_option("--report", options.report,
                     "Write a page with plots: one .html that needs nothing else");
}

void define_trace(CLI::App& command, BenchOptions& options) {
  bench::TraceOptions& t = options.trace;
  command.add_option("--scene", t.scenes,
                     "Files or study:NAME (default: bodies, creature, twist, a small herd)");
  command.add_option("--clip", t.clip, "Name or index (default: the first)");
  command.add_option("--frames", t.frames, "How many times of the clip (default: 1)")
      ->check(whole_number_in(1, 1000));
  command
      .add_option("--rays", t.most_rays,
                  fmt::format("About how many of each kind at most (default: {})", t.most_rays))
      ->check(whole_number_in(1024, 1000000000));
  add_common(command, options, t.width, t.height, t.repeats, t.threads);
}

void define_update(CLI::App& command, BenchOptions& options) {
  bench::UpdateOptions& u = options.update;
  u.data = SINEW_BENCH_DATA;
  command
      .add_option("--only", u.only,
                  fmt::format("Measure only these, after commas: {}",
                              fmt::join(bench::update_parts(), ", ")))
      ->delimiter(',');
  command.add_option("--scene", u.scenes,
                     "Scenes of the visible-fraction sweep: files, study:NAME, or N*FILE for "
                     "copies side by side (default: a small herd, and 25 PigMen)");
  command.add_option("--bodies", u.bodies,
                     "Scene of picks, ray counts and refit (default: study:bodies)");
  command.add_option("--herd", u.herd, "Scene of herd_frame (default: study:herd)");
  command
      .add_option("--rays", u.most_rays,
                  fmt::format("Where the ray-count sweep ends (default: {})", u.most_rays))
      ->check(whole_number_in(1, 1000000));
  command.add_option("--data", u.data, "Folder that holds skinned/pigman/pigman.glb");
  add_common(command, options, u.width, u.height, u.repeats, u.threads);
}

}  // namespace

Run define_bench(CLI::App& command) {
  const auto options = std::make_shared<BenchOptions>();
  command.require_subcommand(1);
  command.footer(
      "Examples:\n"
      "  sinew bench trace --scene study:twist\n"
      "  sinew bench trace --scene walk.glb --clip Run --threads 8 --json report.json\n"
      "  sinew bench update --json report.json --report report.html\n"
      "  sinew bench update --only picks_100,refit_bodies\n"
      "  sinew bench tsah --scene museum --report report.html\n"
      "  sinew bench asvo --only holes --json report.json\n");
  define_trace(
      *command.add_subcommand("trace", "Rays a second against Embree, by kind of ray and by call"),
      *options);
  CLI::App* const update = command.add_subcommand(
      "update", "Time from a new pose to its hits, against Embree's refit and rebuild");
  define_update(*update, *options);
  update->callback([options] { options->does_update = true; });
  const LarssonCommand larsson = define_larsson(command);
  const BoundsCommand bounds = define_bounds(command);
  const TsahCommand tsah = define_tsah(command);
  const AsvoCommand asvo = define_asvo(command);
  const StreamCommand stream = define_stream(command);
  const VoxtraceCommand voxtrace = define_voxtrace(command);
  return [options, larsson, bounds, tsah, asvo, stream, voxtrace] {
    if (voxtrace.parsed()) return voxtrace.run();
    if (stream.parsed()) return stream.run();
    if (asvo.parsed()) return asvo.run();
    if (tsah.parsed()) return tsah.run();
    if (bounds.parsed()) return bounds.run();
    return larsson.parsed() ? larsson.run() : run(*options);
  };
}

}  // namespace sinew::app
