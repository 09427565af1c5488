#include "bench/tsah.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "bench/figures.h"
#include "bench/parts.h"
#include "bench/tsah_convergence.h"
#include "bench/tsah_costs.h"
#include "bench/tsah_frames.h"
#include "bench/tsah_methods.h"
#include "bench/tsah_pictures.h"
#include "bench/tsah_poses.h"
#include "bench/tsah_scenes.h"
#include "sinew/base/parallel.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

bool wants(const TsahOptions& options, std::string_view part) {
  return wants_part(options.only, part);
}

bool is_there(const TsahScene& scene) {
  const size_t from = scene.input.starts_with("aff:") ? scene.input.rfind(',') + 1 : 0;
  const size_t plus = scene.input.rfind('+');
  return !scene.is_data || std::filesystem::exists(scene.input.substr(from, plus - from));
}

// Scenes that nobody named are skipped where their file is absent.
std::vector<TsahScene> chosen_scenes(const TsahOptions& options, json& skipped) {
  std::vector<TsahScene> out;
  const auto add_listed = [&](bool quick) {
    for (const TsahScene& listed : tsah_scenes()) {
      if (listed.quick != quick) continue;
      TsahScene scene = find_tsah_scene(listed.name, options.data);
      if (is_there(scene)) {
        out.push_back(std::move(scene));
      } else {
        skipped.push_back(
            fmt::format("{}: {} is not there (say where with --data)", scene.name, scene.input));
      }
    }
  };
  if (options.scenes.empty()) add_listed(true);
  for (const std::string& name : options.scenes) {
    if (name == "all") {
      add_listed(false);
    } else {
      out.push_back(find_tsah_scene(name, options.data));
    }
  }
  return out;
}

Result<void> measure_scene(const TsahScene& scene, const TsahOptions& options, json& rows,
                           std::string& pictures) {
  SINEW_TRY(FlatClip clip, FlatClip::open(scene));
  SINEW_TRY(const std::vector<MethodTrees> methods,
            make_methods(clip, {.representatives = options.representatives,
                                .reference = options.reference,
                                .segments = scene.motion == SceneMotion::scattering}));
  if (wants(options, "costs")) measure_costs(scene, clip, methods, options, rows);
  if (wants(options, "frames")) SINEW_CHECKED(measure_frames(scene, clip, methods, options, rows));
  if (wants(options, "convergence")) measure_convergence(scene, clip, options, rows);
  if (wants(options, "pictures")) {
    SINEW_TRY(const std::string trees, tree_pictures(scene, clip, methods));
    pictures += trees;
  }
  return {};
}

}  // namespace

std::vector<std::string> tsah_parts() {
  return {"costs", "frames", "convergence", "pictures", "poses"};
}

Result<TsahReport> bench_tsah(const TsahOptions& options) {
  SINEW_CHECKED(check_parts(options.only, tsah_parts()));
  const ThreadLimit limit(options.threads);
  json rows = json::array(), figures = json::array(), skipped = json::array();
  TsahReport out;
  const bool only_poses = options.only == std::vector<std::string>{"poses"};
  for (const TsahScene& scene : chosen_scenes(options, skipped)) {
    if (!only_poses) SINEW_CHECKED(measure_scene(scene, options, rows, out.pictures));
  }
  if (wants(options, "poses")) SINEW_CHECKED(measure_poses(options, rows, skipped));
  if (!options.reference) {
    skipped.push_back("T's own algorithm, which takes minutes: ask for it with --reference");
  }
  add_cost_figures(rows, figures);
  add_frame_figures(rows, figures);
  out.json = report_head("tsah");
  out.json["figures"] = std::move(figures);
  out.json["rows"] = std::move(rows);
  out.json["skipped"] = std::move(skipped);
  return out;
}

}  // namespace sinew::bench
