#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "bench/bench.h"
#include "bench/bounds.h"
#include "bench/trace.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct BenchOptions {
  bench::TraceOptions trace;
  bench::BoundsOptions bounds;
  std::string json;
};

std::string bounds_table(const nlohmann::json& report) {
  std::string out = fmt::format("{:>9} {:>9} {:>6} {:>6} {:>6} {:>10} {:>10} {:>10} {:>7}  {}\n",
                                "clusters", "triangles", "area", "upper", "body", "derive ns",
                                "exact ns", "move ns", "B/tri", "scene");
  for (const auto& row : report["rows"]) {
    const auto number = [&](const char* name) { return row[name].get<double>(); };
    out += fmt::format(
        "{:9.0f} {:9.0f} {:6.3f} {:6.3f} {:6.3f} {:10.1f} {:10.1f} {:10.1f} {:7.2f}  {}\n",
        number("clusters"), number("triangles"), number("area_ratio"), number("upper_sah_ratio"),
        number("body_area_ratio"), number("derive_ns"), number("exact_ns"), number("positions_ns"),
        number("bytes_per_triangle"), row["scene"].get<std::string>());
  }
  return out;
}

Result<int> run_bounds(const BenchOptions& options) {
  SINEW_TRY(const nlohmann::json report, bench::bench_bounds(options.bounds));
  SINEW_CHECKED(write_file("-", bounds_table(report)));
  if (!options.json.empty()) SINEW_CHECKED(write_file(options.json, report.dump(2) + "\n"));
  return kOk;
}

CLI::App* define_bounds(CLI::App& command, BenchOptions& options) {
  CLI::App* const bounds = command.add_subcommand(
      "bounds", "How loose boxes of clusters are that follow from a pose, and what they cost");
  bench::BoundsOptions& b = options.bounds;
  bounds->add_option("--scene", b.scenes, "Files or study:NAME (default: the study scenes)");
  bounds->add_option("--clip", b.clip, "Name or index (default: the first)");
  bounds->add_option("--skip", b.skip, "Names of nodes to leave out");
  bounds->add_option("--frames", b.frames, "How many times of the clip (default: 8)")
      ->check(CLI::Range(1, 1000));
  bounds->add_option("--repeats", b.repeats, "Of every measurement; medians count (default: 7)")
      ->check(CLI::Range(1, 1000));
  bounds->add_option("--weight-groups", b.weight_groups, "Parts of a cluster (default: 4)")
      ->check(CLI::Range(1, 4));
  bounds->add_option("--json", options.json, "Write the report; - for stdout");
  return bounds;
}

std::string table(const nlohmann::json& report) {
  std::string out = fmt::format(
      "{} on {}, {} triangles, {} threads, {}\n", report["bench"].get<std::string>(),
      report["scene"].get<std::string>(), report["triangles"].get<uint64_t>(),
      report["machine"]["threads"].get<int>(), report["opponents"][0].get<std::string>());
  out +=
      fmt::format("{:>8} {:>10} {:>10} {:>10} {:>7}\n", "time s", "", "sinew", "embree", "ratio");
  for (const auto& row : report["rows"]) {
    const double time = row["time_s"];
    const auto line = [&](std::string_view name, double ours, double theirs) {
      out += fmt::format("{:8.3f} {:>10} {:10.2f} {:10.2f} {:7.2f}\n", time, name, ours, theirs,
                         ours / theirs);
    };
    line("build ms", row["build_ms"]["sinew"], row["build_ms"]["embree"]);
    line("update ms", row["update_ms"]["sinew"], row["update_ms"]["embree"]);
    for (const auto& [kind, rate] : row["mrays_per_s"].items()) {
      line(kind + " M/s", rate["sinew"], rate["embree"]);
    }
  }
  for (const auto& figure : report["figures"]) {
    out += fmt::format("{} = {:.3f} ({} is better): {}\n", figure["name"].get<std::string>(),
                       figure["value"].get<double>(), figure["better"].get<std::string>(),
                       figure["note"].get<std::string>());
  }
  return out;
}

Result<int> run_trace(const BenchOptions& options) {
  SINEW_TRY(const nlohmann::json report, bench::bench_trace(options.trace));
  SINEW_CHECKED(write_file("-", table(report)));
  if (!options.json.empty()) SINEW_CHECKED(write_file(options.json, report.dump(2) + "\n"));
  return kOk;
}

}  // namespace

Run define_bench(CLI::App& command) {
  const auto options = std::make_shared<BenchOptions>();
  command.require_subcommand(1);
  command.footer(
      "Examples:\n"
      "  sinew bench trace --scene study:twist\n"
      "  sinew bench trace --scene walk.glb --clip Run --threads 8 --json report.json\n"
      "  sinew bench bounds --scene walk.glb study:creature\n");
  CLI::App* const trace = command.add_subcommand(
      "trace", "Rays a second and update time against Embree on T-SAH's workload");
  bench::TraceOptions& t = options->trace;
  trace->add_option("--scene", t.scene, "A file or study:NAME (default: study:bodies)");
  trace->add_option("--clip", t.clip, "Name or index (default: the first)");
  trace->add_option("--width", t.width, "Pixels (default: 1024)")->check(CLI::Range(1, 8192));
  trace->add_option("--height", t.height, "Pixels (default: 768)")->check(CLI::Range(1, 8192));
  trace->add_option("--frames", t.frames, "How many times of the clip (default: 3)")
      ->check(CLI::Range(1, 1000));
  trace->add_option("--repeats", t.repeats, "Of every measurement; medians count (default: 5)")
      ->check(CLI::Range(1, 1000));
  trace->add_option("--threads", t.threads, "For both opponents (default: 2)")
      ->check(CLI::Range(1, 256));
  trace->add_option("--json", options->json, "Write the report; - for stdout");
  const CLI::App* const bounds = define_bounds(command, *options);
  return
      [options, bounds] { return bounds->parsed() ? run_bounds(*options) : run_trace(*options); };
}

}  // namespace sinew::app
