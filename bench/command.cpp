#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "bench/bench.h"
#include "bench/bounds_command.h"
#include "bench/larsson_command.h"
#include "bench/trace.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct BenchOptions {
  bench::TraceOptions trace;
  std::string json;
};

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
      "  sinew bench trace --scene walk.glb --clip Run --threads 8 --json report.json\n");
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
  const LarssonCommand larsson = define_larsson(command);
  const BoundsCommand bounds = define_bounds(command);
  return [options, larsson, bounds] {
    if (bounds.parsed()) return bounds.run();
    return larsson.parsed() ? larsson.run() : run_trace(*options);
  };
}

}  // namespace sinew::app
