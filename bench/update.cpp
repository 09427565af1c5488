#include "bench/update.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>

#include "bench/copies.h"
#include "bench/picks.h"
#include "bench/update_report.h"
#include "bench/visible.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kPigMen = 25;

// The scenes of the visible-fraction sweep. Default scenes whose file is absent are skipped.
std::vector<std::string> sweep_names(const UpdateOptions& options, json& skipped) {
  if (!options.scenes.empty()) return options.scenes;
  std::vector<std::string> names = {"study:herd,count=24,triangles=20000,terrain=500000"};
  const std::string pigman = options.data + "/skinned/pigman/pigman.glb";
  if (std::filesystem::exists(pigman)) {
    names.push_back(fmt::format("{}*{}", kPigMen, pigman));
  } else {
    skipped.push_back(
        fmt::format("PigMan copies: {} is not there (say where with --data)", pigman));
  }
  return names;
}

// "N*FILE" or "FILE".
Result<Scene> load_copies(const std::string& name) {
  const size_t star = name.find('*');
  uint32_t copies = 0;
  const auto parsed =
      std::from_chars(name.data(), name.data() + std::min(star, name.size()), copies);
  const bool counted =
      star != std::string::npos && parsed.ec == std::errc() && parsed.ptr == name.data() + star;
  if (!counted) return load(name);
  if (copies == 0 || copies > 10000) {
    return fail({ErrorKind::usage, name, "", "the number of copies must be 1 to 10000",
                 "write N*FILE, as in 25*walk.glb"});
  }
  SINEW_TRY(Scene one, load(name.substr(star + 1)));
  const bool pigman = name.ends_with("/pigman.glb");
  return copies_of(std::move(one), copies,
                   pigman ? std::span<const std::string_view>(kPigManStrays)
                          : std::span<const std::string_view>());
}

// The last part of a path, so that tables stay narrow: "25*pigman.glb".
std::string short_name(const std::string& name) {
  const size_t star = name.find('*'), slash = name.rfind('/');
  if (slash == std::string::npos) return name;
  const std::string copies = star < slash ? name.substr(0, star + 1) : "";
  return copies + name.substr(slash + 1);
}

Result<void> run_bodies(const UpdateOptions& options, UpdateReport& report) {
  const bool picks = wants(options, "picks_100") || wants(options, "picks_10000") ||
                     wants(options, "ray_count_sweep") || wants(options, "auto_regret");
  const bool refit = wants(options, "refit_bodies"), bytes = wants(options, "bytes_per_triangle");
  if (!picks && !refit && !bytes) return {};
  SINEW_TRY(const Scene scene, load(options.bodies));
  if (scene.objects.empty()) {
    return fail({ErrorKind::bad_input, options.bodies, "", "it has no triangles to pick",
                 "name a scene with meshes"});
  }
  if (refit) SINEW_CHECKED(measure_refit(scene, options, report));
  if (picks) SINEW_CHECKED(measure_picks(scene, options, report));
  if (bytes) SINEW_CHECKED(measure_bytes(scene, report));
  return {};
}

Result<void> run_visible(const UpdateOptions& options, UpdateReport& report) {
  if (!wants(options, "visible_sweep") && !wants(options, "visible_30") &&
      !wants(options, "auto_regret")) {
    return {};
  }
  for (const std::string& name : sweep_names(options, report.skipped)) {
    SINEW_TRY(Scene scene, load_copies(name));
    if (scene.objects.empty()) {
      return fail({ErrorKind::bad_input, name, "", "it has no triangles to look at",
                   "name a scene with meshes"});
    }
    SINEW_CHECKED(sweep_visible(std::move(scene), short_name(name), options, report));
  }
  if (wants(options, "visible_30")) add_visible_30(report);
  return {};
}

}  // namespace

std::vector<std::string> update_parts() {
  return {"refit_bodies", "picks_100",          "picks_10000",     "herd_frame",   "visible_30",
          "auto_regret",  "bytes_per_triangle", "ray_count_sweep", "visible_sweep"};
}

Result<json> bench_update(const UpdateOptions& options) {
  SINEW_CHECKED(check_parts(options.only, update_parts()));
  const ThreadLimit limit(options.threads);
  UpdateReport report;
  SINEW_CHECKED(run_bodies(options, report));
  if (wants(options, "herd_frame")) SINEW_CHECKED(measure_herd(options, report));
  SINEW_CHECKED(run_visible(options, report));
  add_crossings(report, "ray_count");
  add_crossings(report, "visible_fraction");
  if (wants(options, "auto_regret")) {
    if (const auto regret = worst_regret(report.rows)) {
      report.figures.push_back(figure("auto_regret", regret->ratio, "worst: " + regret->where));
    }
  }
  json out = report_head("update");
  out["figures"] = std::move(report.figures);
  out["rows"] = std::move(report.rows);
  out["skipped"] = std::move(report.skipped);
  return out;
}

}  // namespace sinew::bench
