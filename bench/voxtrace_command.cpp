#include "bench/voxtrace_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/voxtrace.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::VoxtraceOptions options;
  std::string json, report;
};

Result<int> print_tables(const Job& job) {
  for (const std::string& file : {job.json, job.report}) {
    if (!file.empty()) SINEW_CHECKED(check_writable(file));
  }
  SINEW_TRY(const nlohmann::json report, bench::bench_voxtrace(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", bench::voxtrace_text(report)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report)));
  if (!job.report.empty()) SINEW_CHECKED(write_file(job.report, bench::voxtrace_page(report)));
  return kOk;
}

}  // namespace

VoxtraceCommand define_voxtrace(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::VoxtraceOptions& o = job->options;
  CLI::App* const command = bench.add_subcommand(
      "voxtrace", "Rays through octrees in poses, against triangles and octrees made anew");
  command->footer(
      "Examples:\n"
      "  sinew bench voxtrace --report report.html\n"
      "  sinew bench voxtrace --only crowd --crowd 100\n"
      "  sinew bench voxtrace --only rays --resolution 512 --json report.json\n");
  CLI::App& c = *command;
  c.add_option("--only", o.only,
               fmt::format("Measure only these, after commas: {}",
                           fmt::join(bench::voxtrace_parts(), ", ")))
      ->delimiter(',');
  c.add_option("--body", o.body, fmt::format("A skinned body (default: {})", o.body));
  c.add_option("--resolution", o.resolution,
               fmt::format("Voxels along its longest side (default: {})", o.resolution))
      ->check(whole_number_in(8, 4096));
  c.add_option("--crowd-body", o.crowd_body,
               fmt::format("That of crowds (default: {})", o.crowd_body));
  c.add_option("--crowd-resolution", o.crowd_resolution,
               fmt::format("Its voxels (default: {})", o.crowd_resolution))
      ->check(whole_number_in(8, 4096));
  c.add_option("--crowd", o.crowd, fmt::format("Instances at most (default: {})", o.crowd))
      ->check(whole_number_in(1, 1000));
  c.add_option("--poses", o.poses, fmt::format("Of the first clip (default: {})", o.poses))
      ->check(whole_number_in(1, 1000));
  c.add_option("--size", o.size, fmt::format("Pixels a side (default: {})", o.size))
      ->check(whole_number_in(16, 8192));
  c.add_option("--rays", o.rays,
               fmt::format("About how many of each kind at most (default: {})", o.rays))
      ->check(whole_number_in(1024, 100000000));
  c.add_option("--repeats", o.repeats,
               fmt::format("Of every measurement; medians count (default: {})", o.repeats))
      ->check(whole_number_in(1, 1000));
  c.add_option("--threads", o.threads, fmt::format("At most (default: {})", o.threads))
      ->check(whole_number_in(1, 256));
  c.add_option("--json", job->json, "Write figures and rows; - for stdout, instead of the tables");
  c.add_option("--report", job->report, "Write a page: one .html that needs nothing else");
  return {[command] { return command->parsed(); }, [job] { return print_tables(*job); }};
}

}  // namespace sinew::app
