#include "bench/voxtrace.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/figures.h"
#include "bench/measure.h"
#include "bench/parts.h"
#include "bench/voxtrace_engines.h"
#include "bench/voxtrace_pictures.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/draw/rasterize.h"
#include "sinew/svo/leaves.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr float kShare = 0.9f;  // of the picture's side that the body takes
constexpr float kLift = 3.0f;   // voxels that secondary rays start above the triangles

double pose_of(uint32_t i, uint32_t poses) {
  return (double(i) + 0.5) / double(poses);
}

CameraView camera_of(const AsvoBody& body, double u) {
  AsvoPose pose;
  pose_at(body, 0, u, pose);
  return body_camera(body_box(body, pose), kShare);
}

// Speeds of all engines, of the finest voxels and of levels by the pixel's footprint, in turn.
void measure_speeds(const VoxtraceWorlds& worlds, const VoxtraceRays& rays,
                    const RayFootprint& pixel, double u, const VoxtraceOptions& options,
                    json& rows) {
  for (const RayKind kind : kRayKinds) {
    const std::vector<Ray>& own = rays.rays[size_t(kind)];
    std::vector<double> ms[3][2];
    uint64_t met[3][2] = {};
    VoxtraceHits hits;
    for (uint32_t i = 0; i <= options.repeats; ++i) {  // the first makes what is not there
      for (const VoxtraceEngine engine : kVoxtraceEngines) {
        for (const size_t lod : {0, 1}) {
          if (lod == 1 && engine == VoxtraceEngine::triangles) continue;
          QueryOptions query;
          if (lod == 1) query.footprint = pixel;
          const double took =
              milliseconds([&] { trace(worlds.world(engine), kind, own, query, hits); });
          if (i > 0) ms[size_t(engine)][lod].push_back(took);
          met[size_t(engine)][lod] = hits_of(kind, hits);
        }
      }
    }
    for (const VoxtraceEngine engine : kVoxtraceEngines) {
      for (const size_t lod : {0, 1}) {
        const std::vector<double>& own_ms = ms[size_t(engine)][lod];
        if (own_ms.empty() || own.empty()) continue;
        rows.push_back({{"table", "voxtrace_speed"},
                        {"engine", name_of(engine)},
                        {"level", lod == 0 ? "finest" : "by pixel"},
                        {"rays", name_of(kind)},
                        {"pose", u},
                        {"count", own.size()},
                        {"hits", met[size_t(engine)][lod]},
                        {"ms", median(own_ms)},
                        {"rays_per_s", 1e3 * double(own.size()) / median(own_ms)}});
      }
    }
  }
}

Result<void> measure_rays(const AsvoBody& body, VoxtraceWorlds& worlds,
                          const VoxtraceOptions& options, json& rows) {
  for (uint32_t i = 0; i < options.poses; ++i) {
    const double u = pose_of(i, options.poses);
    for (const VoxtraceEngine engine : kVoxtraceEngines) SINEW_CHECKED(worlds.set_pose(engine, u));
    const CameraView camera = camera_of(body, u);
    const VoxtraceRays rays =
        make_voxtrace_rays(worlds.world(VoxtraceEngine::triangles), camera, options.size,
                           kLift * body.surface.grid.voxel, options.rays);
    const CameraRays make(camera, options.size, options.size);
    const float smallest = RasterSettings().smallest;
    const RayFootprint pixel{smallest * make.pixel_width(), smallest * make.pixel_spread()};
    if (wants_part(options.only, "rays")) {
      measure_speeds(worlds, rays, pixel, u, options, rows);
      const UpdateStats stats = worlds.world(VoxtraceEngine::animated).stats();
      rows.push_back({{"table", "voxtrace_pose"},
                      {"pose", u},
                      {"hit_share", rays.hit_share},
                      {"blocks", stats.blocks},
                      {"blocks_made", stats.blocks_made},
                      {"cells_made", stats.cells_made},
                      {"voxels_anew", worlds.anew().voxel_count()}});
    }
    if (wants_part(options.only, "pictures")) compare_pictures(worlds, camera, u, options, rows);
  }
  return {};
}

// From a new pose to the hits of one ray a pixel, which make what they meet.
Result<void> measure_first(const AsvoBody& body, VoxtraceWorlds& worlds,
                           const VoxtraceOptions& options, json& rows) {
  const CameraView camera = camera_of(body, 0.5);
  const VoxtraceRays rays =
      make_voxtrace_rays(worlds.world(VoxtraceEngine::triangles), camera, options.size, 0.0f,
                         size_t{options.size} * options.size);
  const std::vector<Ray>& primary = rays.rays[size_t(RayKind::primary)];
  std::vector<double> pose_ms[3], trace_ms[3], again_ms[3], total_ms[3];
  VoxtraceHits hits;
  for (uint32_t i = 0; i <= options.repeats; ++i) {
    for (const VoxtraceEngine engine : kVoxtraceEngines) {
      if (engine == VoxtraceEngine::anew && i > 2) continue;
      Result<void> good;
      const double u = 0.4 + 0.2 * double(i) / double(options.repeats);
      const double posing = milliseconds([&] { good = worlds.set_pose(engine, u); });
      if (!good) return fail(good.error());
      const auto look = [&] { trace(worlds.world(engine), RayKind::primary, primary, {}, hits); };
      const double first = milliseconds(look), again = milliseconds(look);
      if (i == 0) continue;
      pose_ms[size_t(engine)].push_back(posing);
      trace_ms[size_t(engine)].push_back(first);
      again_ms[size_t(engine)].push_back(again);
      total_ms[size_t(engine)].push_back(posing + first);
    }
  }
  for (const VoxtraceEngine engine : kVoxtraceEngines) {
    rows.push_back({{"table", "voxtrace_first"},
                    {"engine", name_of(engine)},
                    {"pose_ms", median(pose_ms[size_t(engine)])},
                    {"first_ms", median(trace_ms[size_t(engine)])},
                    {"again_ms", median(again_ms[size_t(engine)])},
                    {"total_ms", median(total_ms[size_t(engine)])}});
  }
  return {};
}

// Of the octree, and of what rays need beside it in a pose when they have met everything.
Result<void> measure_bytes(const AsvoBody& body, json& rows) {
  const Svo& svo = body.svo();
  AsvoPose pose;
  pose_at(body, 0, 0.5, pose);
  SvoMotion motion = make_svo_motion(svo);
  PosedSvo posed;
  posed.set_pose(motion, pose.pose);
  SINEW_TRY(const SvoLeafLayout layout, make_leaf_layout(svo));
  SvoLeaves leaves;
  const auto add = [&](const char* part, size_t bytes) {
    rows.push_back({{"table", "voxtrace_bytes"},
                    {"part", part},
                    {"bytes", bytes},
                    {"bytes_per_voxel", double(bytes) / double(svo.voxel_count())}});
  };
  add("octree", svo.bytes());
  add("layout, the same in every pose", layout.bytes());
  add("moved corners and cofactors", svo.corner_places.size() * (sizeof(vec3) + sizeof(mat3)));
  leaves.set_pose(layout, posed);
  leaves.make_all(kCellLevel);
  add("boxes down to cells", leaves.bytes_made());
  leaves.set_pose(layout, posed);
  leaves.make_all(0);
  add("boxes down to voxels", leaves.bytes_made());
  return {};
}

// The geometric mean, over poses and kinds of rays, of how much faster `a` is than `b`.
double ratio(const json& rows, const char* a, const char* level, const char* b) {
  std::vector<double> ratios;
  for (const json& row : rows) {
    if (row["table"] != "voxtrace_speed" || row["engine"] != a || row["level"] != level) continue;
    for (const json& other : rows) {
      if (other["table"] != "voxtrace_speed" || other["engine"] != b ||
          other["rays"] != row["rays"] || other["pose"] != row["pose"]) {
        continue;
      }
      const char* const wanted = other["engine"] == "triangles" ? "finest" : level;
      if (other["level"] != wanted) continue;
      ratios.push_back(row["rays_per_s"].get<double>() / other["rays_per_s"].get<double>());
    }
  }
  return geometric_mean(ratios);
}

void add_figures(const AsvoBody& body, const VoxtraceOptions& options, json& rows, json& figures) {
  if (wants_part(options.only, "rays")) {
    const auto note = [&](const char* a, const char* b) {
      return fmt::format(
          "finest voxels; geometric mean over {} poses and primary, shadow and ambient rays, {} "
          "threads; with levels by the pixel's footprint {:.2f}",
          options.poses, options.threads, ratio(rows, a, "by pixel", b));
    };
    figures.push_back(figure("animated_over_static",
                             ratio(rows, "animated", "finest", "voxelised anew"),
                             note("animated", "voxelised anew")));
    figures.push_back(
        figure("octree_over_bvh", ratio(rows, "animated", "finest", "triangles"),
               fmt::format("{} voxels against {} triangles; {}", body.svo().voxel_count(),
                           body.faces.size(), note("animated", "triangles"))));
  }
  double least = 99.0;
  uint64_t far[2] = {};  // of the finest voxels, and of levels
  bool any = false;
  for (const json& row : rows) {
    if (row["table"] != "voxtrace_picture" || !row.contains("psnr")) continue;
    any = true;
    least = std::min(least, row["psnr"].get<double>());
    far[row["level"] == "finest" ? 0 : 1] += row["far"].get<uint64_t>();
  }
  if (!any) return;
  figures.push_back(
      figure("traced_far_pixels", double(far[0]),
             fmt::format("pixels of the traced or the rasterised body with none of the other "
                         "within a pixel: finest voxels, {} poses; with levels by pixel {}",
                         options.poses, far[1])));
  figures.push_back(figure("traced_psnr", least,
                           "traced against rasterised voxels lit from the eye, over the body; the "
                           "worst picture"));
}

}  // namespace

std::vector<std::string> voxtrace_parts() {
  return {"rays", "pictures", "first", "crowd"};
}

Result<json> bench_voxtrace(const VoxtraceOptions& options) {
  SINEW_CHECKED(check_parts(options.only, voxtrace_parts()));
  const ThreadLimit limit(options.threads);
  json rows = json::array(), figures = json::array();
  const auto wants = [&](const char* part) { return wants_part(options.only, part); };
  if (wants("rays") || wants("pictures") || wants("first")) {
    SINEW_TRY(const AsvoBody body,
              open_asvo_body({"body", options.body, false}, options.resolution));
    rows.push_back({{"table", "voxtrace_body"},
                    {"scene", options.body},
                    {"resolution", options.resolution},
                    {"triangles", body.faces.size()},
                    {"voxels", body.svo().voxel_count()},
                    {"cells", body.svo().cells.size()}});
    SINEW_TRY(VoxtraceWorlds worlds, VoxtraceWorlds::open(body));
    if (wants("rays") || wants("pictures")) {
      SINEW_CHECKED(measure_rays(body, worlds, options, rows));
    }
    if (wants("first")) {
      SINEW_CHECKED(measure_first(body, worlds, options, rows));
      SINEW_CHECKED(measure_bytes(body, rows));
    }
    add_figures(body, options, rows, figures);
  }
  if (wants("crowd")) {
    SINEW_TRY(const AsvoBody body,
              open_asvo_body({"crowd", options.crowd_body, false}, options.crowd_resolution));
    SINEW_CHECKED(measure_crowds(body, options, rows));
  }
  json report = report_head("voxtrace");
  report["figures"] = std::move(figures);
  report["rows"] = std::move(rows);
  report["skipped"] = json::array();
  return report;
}

}  // namespace sinew::bench
