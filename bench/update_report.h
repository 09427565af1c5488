// What the parts of `sinew bench update` write their results into.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "bench/contest.h"
#include "bench/figures.h"
#include "bench/parts.h"
#include "bench/update.h"

namespace sinew::bench {

struct UpdateReport {
  nlohmann::json figures = nlohmann::json::array();
  nlohmann::json rows = nlohmann::json::array();
  nlohmann::json skipped = nlohmann::json::array();  // sentences
};

inline bool wants(const UpdateOptions& options, std::string_view part) {
  return wants_part(options.only, part);
}

// One point of a sweep: a row a rival, {"table", "scene", "x", "method", "ms", "low_ms",
// "high_ms"}, where low and high are the extreme repeats.
void add_sweep_point(UpdateReport& report, const char* table, const std::string& scene, double x,
                     std::span<const Rival> rivals);

// The lines of a sweep, x rising: for each method its (x, ms).
struct SweepLine {
  std::string method;
  std::vector<double> x, ms;
};
std::vector<SweepLine> sweep_lines(const nlohmann::json& rows, std::string_view table,
                                   std::string_view scene);
std::vector<std::string> sweep_scenes(const nlohmann::json& rows, std::string_view table);

// The fastest of the lines whose method begins with `prefix`, at every x.
SweepLine fastest_line(std::span<const SweepLine> lines, std::string_view prefix);

// Time at x, straight in log(x) and log(ms) between the measured points; x is clamped to them.
double interpolate(const SweepLine& line, double x);

// Where the lines cross, as x; measured points only bracket it, so it lies on straight lines in
// log-log between them. Both lines have the same x.
std::vector<double> crossings(const SweepLine& a, const SweepLine& b);

// Rows {"table": "crossing", "sweep", "scene", "a", "b", "x": [...], "says"} for the pairs of
// methods that matter.
void add_crossings(UpdateReport& report, const char* table);

// `auto` over the best of the other modes: the worst case over both sweeps. Nullopt if there is no
// point that has all of them.
struct Regret {
  double ratio = 0.0;
  std::string where;
};
std::optional<Regret> worst_regret(const nlohmann::json& rows);

}  // namespace sinew::bench
