#include "app/report.h"

#include <nlohmann/json.hpp>

#include "app/json_text.h"
#include "sinew/bvh/trace/traverse.h"

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

Json voxels_json(const VoxelStats& stats, double draw_ms) {
  const RasterStats& camera = stats.camera;
  return {{"objects", stats.objects},
          {"objects_rasterised", stats.objects - stats.traced},
          {"objects_traced", stats.traced},
          {"shadow_maps", stats.shadow_maps},
          {"passes", stats.passes},
          {"blocks", camera.blocks},
          {"blocks_drawn", camera.blocks_drawn},
          {"cells", camera.cells},
          {"cells_hidden", camera.cells_hidden},
          {"voxels_drawn", camera.voxels_drawn},
          {"leaves_drawn", camera.leaves_drawn},
          {"nodes_drawn", camera.nodes_drawn},
          {"shadow_voxels_drawn", stats.shadows.voxels_drawn},
          {"draw_ms", draw_ms},
          {"pose_ms", stats.pose_ms},
          {"shadow_ms", stats.shadow_ms},
          {"view_ms", stats.draw_ms},
          {"shade_ms", stats.shade_ms}};
}

}  // namespace

double mrays_per_s(const FrameStats& stats) {
  if (!(stats.trace_ms > 0.0)) return 0.0;
  return static_cast<double>(stats.rays.total()) / stats.trace_ms * 1e-3;
}

static Json paging_json(const PagingStats& stats) {
  return {{"budget", stats.budget},     {"least", stats.least},
          {"skeleton", stats.skeleton}, {"detail", stats.detail},
          {"most", stats.most},         {"blocks", stats.blocks},
          {"resident", stats.resident}, {"missing", stats.missing},
          {"loaded", stats.loaded},     {"evicted", stats.evicted},
          {"parts", stats.parts},       {"unsettled", stats.unsettled},
          {"damaged", stats.damaged},   {"bytes_read", stats.bytes_read},
          {"read_ms", stats.read_ms}};
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
    if (report.voxels > 0) entry["voxels"] = voxels_json(frame.stats.voxels, frame.stats.draw_ms);
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
      {"voxels", report.voxels},
      {"warnings", report.warnings},
      {"frames", frames},
  };
  if (report.paging) document["paging"] = paging_json(*report.paging);
  return json_text(document);
}

}  // namespace sinew::app
