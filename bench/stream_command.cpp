#include "bench/stream_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/stream.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::StreamOptions options;
  std::string json, report;
};

Result<int> print_tables(const Job& job) {
  for (const std::string& file : {job.json, job.report}) {
    if (!file.empty()) SINEW_CHECKED(check_writable(file));
  }
  SINEW_TRY(const nlohmann::json report, bench::bench_stream(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", bench::stream_text(report)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report)));
  if (!job.report.empty()) SINEW_CHECKED(write_file(job.report, bench::stream_page(report)));
  return kOk;
}

}  // namespace

StreamCommand define_stream(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::StreamOptions& o = job->options;
  o.data = SINEW_BENCH_DATA;
  CLI::App* const command = bench.add_subcommand(
      "stream", "Octrees whose detail comes and goes under a budget, against the whole octree");
  command->footer(
      "Examples:\n"
      "  sinew bench stream --report report.html\n"
      "  sinew bench stream --resolution 4096 --json report.json\n"
      "  sinew bench stream --file walk.svo --budgets 128,512\n");
  CLI::App& c = *command;
  c.add_option("--file", o.file, "A .svo, instead of a body that is voxelised");
  c.add_option("--body", o.body, fmt::format("pigman or creature (default: {})", o.body));
  c.add_option("--resolution", o.resolution,
               fmt::format("Voxels along its longest side (default: {})", o.resolution))
      ->check(whole_number_in(8, 4096));
  c.add_option("--budgets", o.budgets, "MiB, after commas (default: 64,256,1024)")
      ->delimiter(',')
      ->check(whole_number_in(1, 1 << 20));
  c.add_option("--flight-budget", o.flight_budget,
               fmt::format("MiB, of the flight (default: {})", o.flight_budget))
      ->check(whole_number_in(1, 1 << 20));
  c.add_option("--size", o.size, fmt::format("Pixels a side (default: {})", o.size))
      ->check(whole_number_in(16, 8192));
  c.add_option("--frames", o.frames, fmt::format("Of the flight (default: {})", o.frames))
      ->check(whole_number_in(10, 100000));
  c.add_option("--threads", o.threads, fmt::format("At most (default: {})", o.threads))
      ->check(whole_number_in(1, 256));
  c.add_option("--data", o.data, "Folder that holds skinned/pigman/pigman.glb");
  c.add_option("--json", job->json, "Write figures and rows; - for stdout, instead of the tables");
  c.add_option("--report", job->report, "Write a page: one .html that needs nothing else");
  return {[command] { return command->parsed(); }, [job] { return print_tables(*job); }};
}

}  // namespace sinew::app
