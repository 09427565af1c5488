#include "bench/bounds_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/bounds.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::BoundsOptions options;
  std::string json;
};

std::string table(const nlohmann::json& report) {
  std::string out = fmt::format("{:>9} {:>9} {:>6} {:>6} {:>6} {:>9} {:>9} {:>9} {:>6} {:>7}  {}\n",
                                "clusters", "triangles", "area", "upper", "body", "derive ns",
                                "exact ns", "move ns", "parts", "bytes/t", "scene");
  for (const auto& row : report["rows"]) {
    const auto number = [&](const char* name) { return row[name].get<double>(); };
    out += fmt::format(
        "{:9.0f} {:9.0f} {:6.3f} {:6.3f} {:6.3f} {:9.1f} {:9.1f} {:9.1f} {:6.2f} {:7.2f}  {}\n",
        number("clusters"), number("triangles"), number("area_ratio"), number("upper_sah_ratio"),
        number("body_area_ratio"), number("derive_ns"), number("exact_ns"), number("positions_ns"),
        number("pieces_per_cluster"), number("bytes_per_triangle"),
        row["scene"].get<std::string>());
  }
  return out;
}

Result<int> print_table(const Job& job) {
  if (!job.json.empty()) SINEW_CHECKED(check_writable(job.json));
  SINEW_TRY(const nlohmann::json report, bench::bench_bounds(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", table(report)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report)));
  return kOk;
}

}  // namespace

BoundsCommand define_bounds(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::BoundsOptions& o = job->options;
  CLI::App* const command = bench.add_subcommand(
      "bounds", "How loose boxes of clusters are that follow from a pose, and what they cost");
  command->footer(
      "area: of derived boxes over that of exact ones, summed over clusters and frames. upper: "
      "the\n"
      "same for all nodes of a tree above the clusters; body: for the whole body. Times are of "
      "one\n"
      "thread, a cluster: to derive its box, to find it exactly, to move its vertices. parts: "
      "fits\n"
      "a cluster. bytes/t: what is kept for this, a triangle.\n\n"
      "Example:\n"
      "  sinew bench bounds --scene walk.glb study:creature\n");
  CLI::App& c = *command;
  c.add_option("--scene", o.scenes, "Files or study:NAME (default: study scenes that deform)");
  c.add_option("--clip", o.clip, "Name or index (default: the first)");
  c.add_option("--skip", o.skip, "Names of nodes to leave out");
  c.add_option("--frames", o.frames, "How many times of the clip (default: 8)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--repeats", o.repeats, "Of every measurement; medians count (default: 7)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--pieces", o.most_pieces, "Parts of a cluster, at most (default: 4)")
      ->check(whole_number_in(1, 4));
  c.add_option("--json", job->json, "Write the report; - for stdout, without the table");
  return {[command] { return command->parsed(); }, [job] { return print_table(*job); }};
}

}  // namespace sinew::app
