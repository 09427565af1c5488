#include "bench/tsah_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/tsah.h"
#include "bench/tsah_report.h"
#include "bench/tsah_scenes.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::TsahOptions options;
  std::string json, report;
};

Result<int> print_tables(const Job& job) {
  for (const std::string& file : {job.json, job.report}) {
    if (!file.empty()) SINEW_CHECKED(check_writable(file));
  }
  SINEW_TRY(const bench::TsahReport report, bench::bench_tsah(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", bench::tsah_text(report.json)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report.json)));
  if (!job.report.empty()) SINEW_CHECKED(write_file(job.report, bench::tsah_page(report)));
  return kOk;
}

std::string scene_names(bool quick_only) {
  std::string out;
  for (const bench::TsahScene& scene : bench::tsah_scenes()) {
    if (quick_only && !scene.quick) continue;
    out += (out.empty() ? "" : ", ") + scene.name;
  }
  return out;
}

void add_sizes(CLI::App& c, bench::TsahOptions& o) {
  c.add_option("--evaluated", o.evaluated, "Frames that costs are averaged over (default: 50)")
      ->check(whole_number_in(2, 1000));
  c.add_option("--representatives", o.representatives,
               "Frames that a tree is made for, and twice as many in one row (default: 5)")
      ->check(whole_number_in(2, 64));
  c.add_option("--width", o.width, "Pixels of the ray traced frames (default: 1024)")
      ->check(whole_number_in(16, 8192));
  c.add_option("--height", o.height, "Pixels (default: 768)")->check(whole_number_in(16, 8192));
  c.add_option("--frames", o.frames, "How many frames are ray traced (default: 3)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--repeats", o.repeats, "Of every frame; medians count (default: 3)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--threads", o.threads, "For all but T's own algorithm (default: 2)")
      ->check(whole_number_in(1, 256));
}

}  // namespace

TsahCommand define_tsah(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::TsahOptions& o = job->options;
  o.data = SINEW_BENCH_DATA;
  CLI::App* const command = bench.add_subcommand(
      "tsah", "One tree for a whole animation, against single frames' trees, rebuilds and Embree");
  command->footer(
      "Every scene is one mesh whose vertices move. Costs are those of the surface area heuristic\n"
      "with c_T = 3 and c_I = 2; frames have T's workload: a primary ray a pixel, and two shadow\n"
      "rays and eight for ambient occlusion at every hit. Two small scenes take minutes, all of "
      "them an\n"
      "hour or more.\n\n"
      "Examples:\n"
      "  sinew bench tsah --report report.html\n"
      "  sinew bench tsah --scene museum fracture --only costs --reference\n"
      "  sinew bench tsah --scene all --json report.json --report report.html\n");
  CLI::App& c = *command;
  c.add_option("--scene", o.scenes,
               fmt::format("all, files, study:NAME, or of: {} (default: {})", scene_names(false),
                           scene_names(true)));
  c.add_option(
       "--only", o.only,
       fmt::format("Measure only these, after commas: {}", fmt::join(bench::tsah_parts(), ", ")))
      ->delimiter(',');
  c.add_flag("--reference", o.reference, "Measure T's own algorithm too: one thread, minutes");
  c.add_option("--limit", o.most_seconds,
               "Seconds of one run of T's own algorithm in convergence plots (default: 60)")
      ->check(number_in(0.1, 1e6));
  add_sizes(c, o);
  c.add_option("--data", o.data, "Folder that holds bart/, skinned/ and vertex-cache/");
  c.add_option("--json", job->json, "Write figures and rows; - for stdout, instead of the tables");
  c.add_option("--report", job->report,
               "Write a page with plots and pictures: one .html that needs nothing else");
  return {[command] { return command->parsed(); }, [job] { return print_tables(*job); }};
}

}  // namespace sinew::app
