#include "bench/asvo_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/asvo.h"
#include "bench/asvo_report.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::AsvoOptions options;
  std::string json, report;
};

Result<int> print_tables(const Job& job) {
  for (const std::string& file : {job.json, job.report}) {
    if (!file.empty()) SINEW_CHECKED(check_writable(file));
  }
  SINEW_TRY(const bench::AsvoReport report, bench::bench_asvo(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", bench::asvo_text(report.json)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report.json)));
  if (!job.report.empty()) SINEW_CHECKED(write_file(job.report, bench::asvo_page(report)));
  return kOk;
}

}  // namespace

AsvoCommand define_asvo(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::AsvoOptions& o = job->options;
  o.data = SINEW_BENCH_DATA;
  CLI::App* const command = bench.add_subcommand(
      "asvo", "Animated octrees, against the thesis's method and against voxelising every frame");
  command->footer(
      "Every method draws the same voxels: those of a thin shell around the body.\n\n"
      "Examples:\n"
      "  sinew bench asvo --report report.html\n"
      "  sinew bench asvo --only frames,splats --repeats 15\n"
      "  sinew bench asvo --only holes --resolution 512 --body coarse\n");
  CLI::App& c = *command;
  c.add_option(
       "--only", o.only,
       fmt::format("Measure only these, after commas: {}", fmt::join(bench::asvo_parts(), ", ")))
      ->delimiter(',');
  c.add_option(
       "--body", o.bodies,
       fmt::format("Only these bodies, after commas: {}", fmt::join(bench::asvo_bodies(), ", ")))
      ->delimiter(',');
  c.add_option("--creature", o.creature, fmt::format("The creature (default: {})", o.creature));
  c.add_option("--fine", o.fine,
               fmt::format("Voxels along the creature's longest side where times and bytes count "
                           "(default: {}, which makes 3 million)",
                           o.fine))
      ->check(whole_number_in(8, 4096));
  c.add_option("--resolution", o.resolution,
               fmt::format("The same of all else (default: {})", o.resolution))
      ->check(whole_number_in(8, 4096));
  c.add_option("--size", o.size, fmt::format("Pixels a side (default: {})", o.size))
      ->check(whole_number_in(16, 8192));
  c.add_option("--frames", o.frames,
               fmt::format("Of each clip, where holes are sought (default: {})", o.frames))
      ->check(whole_number_in(1, 10000));
  c.add_option("--repeats", o.repeats,
               fmt::format("Of every measurement; medians count (default: {})", o.repeats))
      ->check(whole_number_in(1, 1000));
  c.add_option("--threads", o.threads,
               fmt::format("Of all but what counts by core (default: {})", o.threads))
      ->check(whole_number_in(1, 256));
  c.add_option("--data", o.data, "Folder that holds skinned/pigman/pigman.glb");
  c.add_option("--json", job->json, "Write figures and rows; - for stdout, instead of the tables");
  c.add_option("--report", job->report,
               "Write a page with plots and pictures: one .html that needs nothing else");
  return {[command] { return command->parsed(); }, [job] { return print_tables(*job); }};
}

}  // namespace sinew::app
