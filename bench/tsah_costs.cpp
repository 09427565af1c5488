#include "bench/tsah_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/figures.h"
#include "bench/measure.h"
#include "bench/tsah_paper.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/cost.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A method's cost in every frame, NaN where it was not asked.
struct CostLine {
  std::string method;
  double seconds = 0.0;
  size_t trees = 1;
  std::string note;
  std::vector<double> cost;
};

// Trees for every frame are made for each of 50 frames of a scene of T's usual size, for 13 of a
// large one, for 5 of a huge one.
uint32_t rebuild_step(uint32_t triangles, uint32_t frames) {
  const uint32_t wanted = triangles > 600000 ? 5 : triangles > 150000 ? 13 : frames;
  return std::max(1u, frames / std::max(wanted, 1u));
}

// T's SAH-rebuild in one frame, and the same without insertion-based optimisation.
void rebuild(const FrameBoxes& frame, size_t index, CostLine& best, CostLine& plain) {
  Tree swept;
  plain.seconds += 1e-3 * milliseconds([&] { swept = sweep_tree(frame); });
  plain.cost[index] = frame_costs(cost_leaves(swept, frame, 0), frame)[0];
  Tree deep;
  best.seconds += 1e-3 * milliseconds([&] { deep = best_tree_of_frame(frame); });
  best.cost[index] = frame_costs(cost_leaves(deep, frame, 0), frame)[0];
}

std::vector<CostLine> cost_lines(const FlatClip& clip, std::span<const MethodTrees> methods,
                                 std::span<const double> u) {
  std::vector<CostLine> lines(2);
  lines[0].method = kSahRebuild;
  lines[1].method = "SAH-rebuild, no insertion";
  for (const MethodTrees& m : methods) {
    lines.push_back({m.name, m.seconds, m.parts.size(), m.note, {}});
  }
  for (CostLine& line : lines) line.cost.assign(u.size(), kNone);
  const uint32_t step = rebuild_step(clip.triangle_count(), static_cast<uint32_t>(u.size()));
  for (size_t i = 0; i < u.size(); ++i) {
    const FrameBoxes frame = boxes_at(clip, u.subspan(i, 1));
    if (i % step == 0) rebuild(frame, i, lines[0], lines[1]);
    for (size_t m = 0; m < methods.size(); ++m) {
      lines[2 + m].cost[i] = frame_costs(methods[m].at(u[i]).tree, frame)[0];
    }
  }
  return lines;
}

// Over the frames where both have a cost.
double average(const CostLine& line, const CostLine& where) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < line.cost.size(); ++i) {
    if (std::isnan(line.cost[i]) || std::isnan(where.cost[i])) continue;
    sum += line.cost[i];
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

double maximum(const CostLine& line) {
  double most = 0.0;
  for (const double cost : line.cost) most = std::max(most, std::isnan(cost) ? 0.0 : cost);
  return most;
}

size_t frames_of(const CostLine& line) {
  return static_cast<size_t>(
      std::ranges::count_if(line.cost, [](double cost) { return !std::isnan(cost); }));
}

json cost_row(const TsahScene& scene, const FlatClip& clip, const CostLine& line,
              const CostLine& rebuilt) {
  json row = {{"table", "tsah_cost"},
              {"scene", scene.name},
              {"motion", name_of(scene.motion)},
              {"triangles", clip.triangle_count()},
              {"method", line.method},
              {"build_s", line.seconds},
              {"trees", line.trees},
              {"frames", frames_of(line)},
              {"average", average(line, line)},
              {"maximum", maximum(line)},
              {"average_common", average(line, rebuilt)},
              {"note", line.note}};
  if (const PaperCost* const paper = paper_cost(scene.name, line.method)) {
    row["paper"] = {{"scene", paper->theirs},
                    {"same_input", paper->same},
                    {"build_s", paper->seconds},
                    {"average", paper->average},
                    {"maximum", paper->maximum}};
  }
  return row;
}

json plot_row(const TsahScene& scene, const CostLine& line, std::span<const double> u) {
  json x = json::array(), y = json::array();
  for (size_t i = 0; i < u.size(); ++i) {
    if (std::isnan(line.cost[i])) continue;
    x.push_back(u[i]);
    y.push_back(line.cost[i]);
  }
  return {{"table", "cost_over_frames"},
          {"scene", scene.name},
          {"method", line.method},
          {"x", std::move(x)},
          {"y", std::move(y)}};
}

// The names of the measured scenes, with their motion and size.
struct Measured {
  std::string scene, motion;
  double triangles = 0.0;
};
std::vector<Measured> measured_scenes(const json& rows) {
  std::vector<Measured> out;
  for (const json& row : rows) {
    if (row["table"] != "tsah_cost" || row["method"] != kTsah) continue;
    out.push_back({row["scene"], row["motion"], row["triangles"]});
  }
  return out;
}

// A ratio for every scene, written down beside it.
struct Ratios {
  std::vector<double> values;
  std::string words;

  void add(const std::string& scene, double value) {
    values.push_back(value);
    words += fmt::format("{}{} {:.3f}", words.empty() ? "" : ", ", scene, value);
  }
};

void add_time_figure(const json& rows, const Measured& scene, const char* name, json& figures) {
  figures.push_back(figure(
      name, cost_of(rows, scene.scene, kTsah, "build_s"),
      fmt::format("{}, {:.0f} triangles: from the boxes of the frames to the tree, all threads",
                  scene.scene, scene.triangles)));
}

}  // namespace

void measure_costs(const TsahScene& scene, const FlatClip& clip,
                   std::span<const MethodTrees> methods, const TsahOptions& options, json& rows) {
  const std::vector<double> u = even_frames(options.evaluated);
  const std::vector<CostLine> lines = cost_lines(clip, methods, u);
  for (const CostLine& line : lines) rows.push_back(cost_row(scene, clip, line, lines[0]));
  for (const CostLine& line : lines) rows.push_back(plot_row(scene, line, u));
}

double cost_of(const json& rows, std::string_view scene, std::string_view method,
               const char* what) {
  for (const json& row : rows) {
    if (row["table"] == "tsah_cost" && row["scene"] == scene && row["method"] == method) {
      return row[what];
    }
  }
  return kNone;
}

void add_cost_figures(const json& rows, json& figures) {
  Ratios moderate, recovered, single, single_scattering;
  for (const Measured& m : measured_scenes(rows)) {
    const auto common = [&](std::string_view method) {
      return cost_of(rows, m.scene, method, "average_common");
    };
    const double ours = common(kTsah), rebuilt = common(kSahRebuild), first = common(kSahFirst);
    const bool scatters = m.motion == "scattering";
    const double over_single =
        cost_of(rows, m.scene, kSahBest, "average") / cost_of(rows, m.scene, kTsah, "average");
    if (m.motion == "rigid" || m.motion == "moderate") moderate.add(m.scene, ours / rebuilt);
    if (scatters) recovered.add(m.scene, (first - ours) / (first - rebuilt));
    single.add(m.scene, over_single);
    if (scatters) single_scattering.add(m.scene, over_single);
    if (m.triangles > 2e5 && m.triangles < 3e5 && scatters) {
      add_time_figure(rows, m, "optimise_250k_s", figures);
    }
    if (m.triangles > 1.5e6 && scatters) add_time_figure(rows, m, "optimise_1600k_s", figures);
  }
  const auto add = [&](const char* name, double value, const Ratios& from, const char* note) {
    figures.push_back(figure(name, value, fmt::format("{}: {}", note, from.words)));
  };
  if (!moderate.values.empty()) {
    add("cost_moderate", geometric_mean(moderate.values), moderate,
        "average T-SAH cost over SAH-rebuild's, geometric mean");
  }
  if (!recovered.values.empty()) {
    add("recovered", geometric_mean(recovered.values), recovered,
        "of what SAH0 costs more than SAH-rebuild, geometric mean");
  }
  if (!single.values.empty()) {
    add("best_single_frame", *std::ranges::min_element(single.values), single,
        "cost of SAH*, the best single frame's tree, over T-SAH's; the least");
  }
  if (!single_scattering.values.empty()) {
    add("best_single_frame_scattering", geometric_mean(single_scattering.values), single_scattering,
        "the same, geometric mean of the scattering scenes");
  }
}

}  // namespace sinew::bench
