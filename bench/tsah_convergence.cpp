#include "bench/tsah_convergence.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "bench/tsah_methods.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/bvh/tsah/tsah_reference.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr size_t kMostPoints = 60;  // of a line

struct Line {
  std::string method;
  std::vector<double> seconds, cost;

  // The average cost whatever the exponent, as in T's figures.
  void add(double at, std::span<const double> costs) {
    seconds.push_back(at);
    cost.push_back(std::accumulate(costs.begin(), costs.end(), 0.0) / double(costs.size()));
  }
};

// Every n-th point and the last one.
json line_row(const char* table, const std::string& scene, const Line& line) {
  json x = json::array(), y = json::array();
  const size_t step = std::max<size_t>(1, line.seconds.size() / kMostPoints);
  for (size_t i = 0; i < line.seconds.size(); ++i) {
    if (i % step != 0 && i + 1 != line.seconds.size()) continue;
    x.push_back(line.seconds[i]);
    y.push_back(line.cost[i]);
  }
  return {{"table", table},
          {"scene", scene},
          {"method", line.method},
          {"x", std::move(x)},
          {"y", std::move(y)}};
}

Line ours(const FrameBoxes& frames, uint32_t exponent, const std::string& name) {
  Line line{name, {}, {}};
  OptimizeConfig config{.exponent = exponent};
  config.on_step = [&](const OptimizeStep& step) {
    line.add(step.seconds, step.costs);
    return true;
  };
  (void)build_optimized(frames, config);
  return line;
}

Line theirs(const Tree& start, const FrameBoxes& frames, TsahConfig config, const std::string& name,
            double most_seconds) {
  Line line{name, {}, {}};
  config.on_batch = [&](const TsahStep& step) {
    line.add(step.seconds, step.costs);
    return step.seconds < most_seconds;
  };
  (void)optimize_tsah(start, frames, config);
  return line;
}

}  // namespace

void measure_convergence(const TsahScene& scene, const FlatClip& clip, const TsahOptions& options,
                         json& rows) {
  const FrameBoxes frames = boxes_at(clip, even_frames(options.representatives));
  const auto add = [&](const char* table, const Line& line) {
    rows.push_back(line_row(table, scene.name, line));
  };
  for (const uint32_t k : {0u, 2u, 4u}) {
    const Line line = ours(frames, k, fmt::format("T-SAH k={}", k));
    if (k == 0) add("convergence_selection", line);
    add("convergence_exponent", line);
  }
  if (!options.reference) return;
  const Tree start = sweep_tree(frames);
  constexpr std::array kSelections = {
      std::pair(TsahSelection::metropolis_hastings, "T, Metropolis-Hastings"),
      std::pair(TsahSelection::sorted_batch, "T, sorted batch"),
      std::pair(TsahSelection::random, "T, random")};
  for (const auto& [selection, name] : kSelections) {
    add("convergence_selection",
        theirs(start, frames, {.selection = selection}, name, options.most_seconds));
  }
  for (const double k : {0.0, 2.0, 4.0}) {
    add("convergence_exponent",
        theirs(start, frames, {.exponent = k}, fmt::format("T k={}", k), options.most_seconds));
  }
}

}  // namespace sinew::bench
