#include "app/report.h"

#include <nlohmann/json.hpp>

#include "app/json_text.h"
#include "sinew/bvh/traverse.h"

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;

Json rays_json(const RayCounts& rays) {
  return {{"primary", rays.primary},
          {"shadow", rays.shadow},
          {"ao", rays.ambient},
          {"reflection", rays.reflection},
          {"refraction", rays.refraction}};
}

}  // namespace

double mrays_per_s(const FrameStats& stats) {
  if (!(stats.trace_ms > 0.0)) return 0.0;
  return static_cast<double>(stats.rays.total()) / stats.trace_ms * 1e-3;
}

static Json update_json(const UpdateStats& stats) {
  return {{"unchanged", stats.unchanged},
          {"full", stats.full},
          {"hybrid", stats.hybrid},
          {"lazy", stats.lazy},
          {"skipped", stats.objects_skipped},
          {"treelets", stats.treelets},
          {"treelets_made", stats.treelets_made}};
}

std::string to_json(const RenderReport& report) {
  Json frames = Json::array();
  for (const FrameRecord& frame : report.frames) {
    Json entry = {
        {"frame", frame.shot.frame},           {"time_s", frame.shot.time},
        {"update_ms", frame.update.update_ms}, {"trace_ms", frame.stats.trace_ms},
        {"shade_ms", frame.stats.shade_ms},    {"total_ms", frame.total_ms},
        {"rays", rays_json(frame.stats.rays)}, {"mrays_per_s", mrays_per_s(frame.stats)},
    };
    entry["update"] = update_json(frame.update);
    if (frame.view.steps) {
      entry["steps"] = {{"mean", frame.view.steps->mean},
                        {"largest", frame.view.steps->largest},
                        {"scale", frame.view.scale}};
    }
    if (frame.view.boxes) entry["boxes"] = *frame.view.boxes;
    if (report.settings.time_budget_ms > 0.0) {
      entry["rays_skipped"] = rays_json(frame.stats.skipped);
    }
    frames.push_back(std::move(entry));
  }
  Json document = {
      {"version", SINEW_VERSION},
      {"kernel_target", kernel_target()},
      {"threads", report.threads},
      {"input", report.input},
      {"output", report.output},
      {"clip", report.clip},
      {"fps", report.fps},
      {"width", report.settings.width},
      {"height", report.settings.height},
      {"samples", report.settings.samples},
      {"subsampling", report.settings.subsampling},
      {"triangles", report.triangles},
      {"warnings", report.warnings},
      {"frames", frames},
  };
  return json_text(document);
}

}  // namespace sinew::app
