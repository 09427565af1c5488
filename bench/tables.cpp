#include "bench/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "bench/figures.h"
#include "bench/update_report.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

std::string number(const json& figure, const char* name) {
  if (!figure.contains(name)) return "";
  return fmt::format("{} {:g}",
                     figure["better"] == "more" ? ">=" : "<=", figure[name].get<double>());
}

// A sweep: a line for every x, a column for every method, in ms.
std::string sweep_text(const json& rows, const char* table, const char* x_name, bool percent) {
  std::string out;
  for (const std::string& scene : sweep_scenes(rows, table)) {
    const std::vector<SweepLine> lines = sweep_lines(rows, table, scene);
    out += fmt::format("\n{}, ms a frame (pose in, hits out)\n{:>9}", scene, x_name);
    for (const SweepLine& line : lines)
      out += fmt::format(" {:>{}}", line.method, std::max<size_t>(line.method.size(), 9));
    out += "\n";
    for (size_t i = 0; i < lines[0].x.size(); ++i) {
      const double x = lines[0].x[i];
      out += percent ? fmt::format("{:8.1f}%", 100.0 * x) : fmt::format("{:9.0f}", x);
      for (const SweepLine& line : lines) {
        out += fmt::format(" {:{}.2f}", line.ms[i], std::max<size_t>(line.method.size(), 9));
      }
      out += "\n";
    }
  }
  return out;
}

std::string crossings_text(const json& rows) {
  std::string out;
  for (const json& row : rows) {
    if (row["table"] != "crossing") continue;
    if (out.empty()) out = "\nwhere lines cross\n";
    out +=
        fmt::format("  {}: {}\n", row["scene"].get<std::string>(), row["says"].get<std::string>());
  }
  return out;
}

std::string trees_text(const json& rows) {
  std::string out = fmt::format("\n{:<34} {:>9} {:>20} {:>20}\n", "scene", "triangles",
                                "build ms / Embree", "update ms / refit");
  for (const json& row : rows) {
    if (row["table"] != "trees") continue;
    const json &build = row["build_ms"], &update = row["update_ms"];
    out += fmt::format("{:<34} {:>9} {:>9.1f} / {:>8.1f} {:>9.2f} / {:>8.2f}\n",
                       row["scene"].get<std::string>(), row["triangles"].get<uint64_t>(),
                       build["sinew"].get<double>(), build["embree"].get<double>(),
                       update["sinew"].get<double>(), update["embree"].get<double>());
  }
  return out;
}

// Lines and columns of the trace table, in the order in which they were measured.
struct TraceTable {
  std::vector<std::string> lines, calls;
  std::map<std::pair<std::string, std::string>, double> rate;

  static void add(std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  }
};

TraceTable trace_table(const json& rows) {
  TraceTable table;
  for (const json& row : rows) {
    if (row["table"] != "trace") continue;
    const std::string scene = row["scene"], call = row["call"];
    const std::string line =
        fmt::format("{:<24.24} {:5.1f} {:<6} {:<6} {:<8}", scene, row["time_s"].get<double>(),
                    row["tree"].get<std::string>(), row["test"].get<std::string>(),
                    row["kind"].get<std::string>());
    TraceTable::add(table.lines, line);
    TraceTable::add(table.calls, call);
    table.rate[{line, call}] = row["mrays_per_s"];
  }
  return table;
}

}  // namespace

std::string bench_head(const json& report) {
  const json& machine = report["machine"];
  return fmt::format("{}: {}, {} threads, {} kernels, against {}\n",
                     report["bench"].get<std::string>(), machine["processor"].get<std::string>(),
                     machine["threads"].get<int>(), machine["kernels"].get<std::string>(),
                     report["opponents"][0].get<std::string>());
}

std::string figures_text(const json& figures) {
  if (figures.empty()) return "";
  std::string out =
      fmt::format("\n{:<19}{:>8} {:>9} {:>9}  {}\n", "figure", "value", "goal", "floor", "");
  for (const json& f : figures) {
    out += fmt::format("{:<19}{:8.2f} {:>9} {:>9}  {:<9}  {}\n", f["name"].get<std::string>(),
                       f["value"].get<double>(), number(f, "goal"), number(f, "floor"),
                       name_of(verdict(f)), f["note"].get<std::string>());
  }
  return out;
}

std::string trace_text(const json& report) {
  const json& rows = report["rows"];
  const TraceTable table = trace_table(rows);
  std::string out = bench_head(report) + trees_text(rows);
  out += fmt::format("\nmillions of rays a second\n{:<53}", "scene, time, tree, test, rays");
  for (const std::string& call : table.calls) {
    out += fmt::format(" {:>{}}", call, std::max<size_t>(call.size(), 7));
  }
  out += "\n";
  for (const std::string& line : table.lines) {
    out += line;
    for (const std::string& call : table.calls) {
      const auto found = table.rate.find({line, call});
      const size_t width = std::max<size_t>(call.size(), 7);
      out += found == table.rate.end() ? fmt::format(" {:>{}}", "-", width)
                                       : fmt::format(" {:{}.1f}", found->second, width);
    }
    out += "\n";
  }
  return out + figures_text(report["figures"]);
}

std::string update_text(const json& report) {
  const json& rows = report["rows"];
  std::string out = bench_head(report);
  out += sweep_text(rows, "visible_fraction", "reached", true);
  out += sweep_text(rows, "ray_count", "rays", false);
  for (const json& row : rows) {
    if (row["table"] != "free_motion") continue;
    out += fmt::format(
        "\nfree motion, positions ready, {} picks: {:.2f} ms, Embree refit {:.2f} ms ({:.2f}x)",
        row["rays"].get<uint32_t>(), row["sinew_ms"].get<double>(), row["embree_ms"].get<double>(),
        row["ratio"].get<double>());
  }
  out += "\n" + crossings_text(rows) + figures_text(report["figures"]);
  for (const json& sentence : report["skipped"]) {
    out += "skipped: " + sentence.get<std::string>() + "\n";
  }
  return out;
}

std::string skipped_text(const nlohmann::json& report) {
  std::string out;
  for (const nlohmann::json& sentence : report["skipped"]) {
    out += "Skipped: " + sentence.get<std::string>() + "\n";
  }
  return out.empty() ? "" : "\n" + out;
}

}  // namespace sinew::bench
