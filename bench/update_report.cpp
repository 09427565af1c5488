#include "bench/update_report.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "sinew/base/check.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

const SweepLine* find_line(std::span<const SweepLine> lines, std::string_view method) {
  for (const SweepLine& line : lines) {
    if (line.method == method) return &line;
  }
  return nullptr;
}

// x as people say it in this sweep.
std::string say_x(std::string_view table, double x) {
  return table == "visible_fraction" ? fmt::format("{:.0f}%", 100.0 * x)
                                     : fmt::format("{:.0f} rays", x);
}

std::string say_crossing(std::string_view table, const SweepLine& a, const SweepLine& b,
                         const std::vector<double>& at) {
  const bool first = a.ms.front() < b.ms.front();
  if (at.empty()) {
    return fmt::format("{} is faster than {} everywhere from {} to {}", first ? a.method : b.method,
                       first ? b.method : a.method, say_x(table, a.x.front()),
                       say_x(table, a.x.back()));
  }
  std::string where;
  for (const double x : at) where += (where.empty() ? "" : ", ") + say_x(table, x);
  return fmt::format("{} is faster than {} up to {}{}", first ? a.method : b.method,
                     first ? b.method : a.method, where,
                     at.size() > 1 ? " (the lines cross more than once)" : "");
}

}  // namespace

void add_sweep_point(UpdateReport& report, const char* table, const std::string& scene, double x,
                     std::span<const Rival> rivals) {
  for (const Rival& rival : rivals) {
    const auto [low, high] = std::ranges::minmax(rival.ms);
    report.rows.push_back({{"table", table},
                           {"scene", scene},
                           {"x", x},
                           {"method", rival.name},
                           {"ms", rival.median_ms()},
                           {"low_ms", low},
                           {"high_ms", high}});
  }
}

std::vector<std::string> sweep_scenes(const json& rows, std::string_view table) {
  std::vector<std::string> scenes;
  for (const json& row : rows) {
    if (row["table"] != table) continue;
    const std::string scene = row["scene"];
    if (std::ranges::find(scenes, scene) == scenes.end()) scenes.push_back(scene);
  }
  return scenes;
}

std::vector<SweepLine> sweep_lines(const json& rows, std::string_view table,
                                   std::string_view scene) {
  std::vector<SweepLine> lines;
  std::map<std::string, std::map<double, double>> points;
  std::vector<std::string> order;
  for (const json& row : rows) {
    if (row["table"] != table || row["scene"] != scene) continue;
    const std::string method = row["method"];
    if (!points.contains(method)) order.push_back(method);
    points[method][row["x"]] = row["ms"];
  }
  for (const std::string& method : order) {
    SweepLine& line = lines.emplace_back(SweepLine{method, {}, {}});
    for (const auto& [x, ms] : points[method]) {
      line.x.push_back(x);
      line.ms.push_back(ms);
    }
  }
  return lines;
}

SweepLine fastest_line(std::span<const SweepLine> lines, std::string_view prefix) {
  SweepLine best;
  for (const SweepLine& line : lines) {
    if (!line.method.starts_with(prefix)) continue;
    if (best.x.empty()) {
      best = line;
      best.method = std::string(prefix) + " at its best";
    }
    for (size_t i = 0; i < best.ms.size(); ++i) best.ms[i] = std::min(best.ms[i], line.ms[i]);
  }
  return best;
}

double interpolate(const SweepLine& line, double x) {
  SINEW_CHECK(!line.x.empty());
  if (x <= line.x.front()) return line.ms.front();
  for (size_t i = 1; i < line.x.size(); ++i) {
    if (x > line.x[i]) continue;
    const double u = std::log(x / line.x[i - 1]) / std::log(line.x[i] / line.x[i - 1]);
    return line.ms[i - 1] * std::pow(line.ms[i] / line.ms[i - 1], u);
  }
  return line.ms.back();
}

std::vector<double> crossings(const SweepLine& a, const SweepLine& b) {
  SINEW_CHECK(a.x == b.x);
  std::vector<double> out;
  for (size_t i = 1; i < a.x.size(); ++i) {
    const double before = std::log(a.ms[i - 1] / b.ms[i - 1]), after = std::log(a.ms[i] / b.ms[i]);
    if ((before < 0.0) == (after < 0.0)) continue;
    const double u = before / (before - after);
    out.push_back(a.x[i - 1] * std::pow(a.x[i] / a.x[i - 1], u));
  }
  return out;
}

void add_crossings(UpdateReport& report, const char* table) {
  constexpr std::pair<const char*, const char*> kPairs[] = {
      {"sinew auto", "embree refit"}, {"sinew auto", "embree low rebuild"},
      {"sinew lazy", "embree refit"}, {"sinew full", "embree refit"},
      {"sinew lazy", "sinew hybrid"}, {"sinew lazy", "sinew full"},
      {"sinew hybrid", "sinew full"}, {"embree refit", "embree low rebuild"}};
  for (const std::string& scene : sweep_scenes(report.rows, table)) {
    const std::vector<SweepLine> lines = sweep_lines(report.rows, table, scene);
    for (const auto& [a_name, b_name] : kPairs) {
      const SweepLine* const a = find_line(lines, a_name);
      const SweepLine* const b = find_line(lines, b_name);
      if (a == nullptr || b == nullptr || a->x.size() < 2) continue;
      const std::vector<double> at = crossings(*a, *b);
      report.rows.push_back({{"table", "crossing"},
                             {"sweep", table},
                             {"scene", scene},
                             {"a", a_name},
                             {"b", b_name},
                             {"x", at},
                             {"says", say_crossing(table, *a, *b, at)}});
    }
  }
}

std::optional<Regret> worst_regret(const json& rows) {
  std::optional<Regret> worst;
  for (const char* const table : {"visible_fraction", "ray_count"}) {
    for (const std::string& scene : sweep_scenes(rows, table)) {
      const std::vector<SweepLine> lines = sweep_lines(rows, table, scene);
      const SweepLine* const chosen = find_line(lines, "sinew auto");
      const SweepLine* const full = find_line(lines, "sinew full");
      const SweepLine* const hybrid = find_line(lines, "sinew hybrid");
      const SweepLine* const lazy = find_line(lines, "sinew lazy");
      if (!chosen || !full || !hybrid || !lazy) continue;
      for (size_t i = 0; i < chosen->x.size(); ++i) {
        const double best = std::min({full->ms[i], hybrid->ms[i], lazy->ms[i]});
        const double ratio = chosen->ms[i] / best;
        if (worst && ratio <= worst->ratio) continue;
        worst = {ratio, scene + " at " + say_x(table, chosen->x[i])};
      }
    }
  }
  return worst;
}

}  // namespace sinew::bench
