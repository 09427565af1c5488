#include "bench/asvo_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/asvo_methods.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/frame.h"
#include "sinew/render/raster_view.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kWarmups = 3;

// What each repeat of a frame took, by stage.
struct StageTimes {
  std::vector<double> sample, pose, shadow, draw, shade, rest, total;
  RasterStats camera, shadows;  // of the last frame
};

// The nodes of all lights but the brightest.
std::vector<size_t> other_lights(const Scene& scene) {
  std::vector<size_t> nodes;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].light >= 0) nodes.push_back(i);
  }
  const auto intensity = [&](size_t node) {
    return scene.lights[static_cast<size_t>(scene.nodes[node].light)].intensity;
  };
  const auto brightest = std::ranges::max_element(nodes, {}, intensity);
  if (brightest != nodes.end()) nodes.erase(brightest);
  return nodes;
}

class FrameTimer {
 public:
  // With the body's brightest light alone, and so one shadow map, or with all of its scene.
  static Result<FrameTimer> open(const AsvoBody& body, const AsvoOptions& options,
                                 bool all_lights = false) {
    SINEW_TRY(World world, prepare(body.voxels));
    return FrameTimer(body, options, std::move(world), all_lights);
  }

  // Consecutive frames of the body's first clip (or of its turn), seen so that it takes `share`.
  StageTimes run(float share) {
    StageTimes out;
    AsvoPose pose;
    pose_at(body_, 0, 0.0, pose);
    camera_ = body_camera(body_box(body_, pose), share);
    for (uint32_t i = 0; i < kWarmups + options_.repeats; ++i) {
      frame(double(i) / 30.0, i >= kWarmups ? &out : nullptr);
    }
    out.camera = stats_.voxels.camera;
    out.shadows = stats_.voxels.shadows;
    return out;
  }
  const Image8& picture() const { return picture_; }

 private:
  FrameTimer(const AsvoBody& body, const AsvoOptions& options, World world, bool all_lights)
      : body_(body), options_(options), world_(std::move(world)) {
    if (!all_lights) hidden_lights_ = other_lights(body.voxels);
    settings_.width = settings_.height = options.size;
    settings_.reflections = 0;
  }

  void frame(double u, StageTimes* out) {
    double sample_ms = 0.0, tonemap_ms = 0.0;
    const double total = milliseconds([&] {
      sample_ms = milliseconds([&] { pose_at(body_, 0, u - std::floor(u), pose_); });
      place(pose_);
      for (const size_t node : hidden_lights_) pose_.drawn.visible[node] = 0;
      show(pose_);
      stats_ =
          render_frame(world_, body_.voxels, pose_.drawn, camera_, settings_, *scratch_, radiance_);
      tonemap_ms = milliseconds([&] { tonemap(radiance_, 0.0f, picture_); });
    });
    if (out == nullptr) return;
    const VoxelStats& v = stats_.voxels;
    out->sample.push_back(sample_ms);
    out->pose.push_back(v.pose_ms);
    out->shadow.push_back(v.shadow_ms);
    out->draw.push_back(v.draw_ms);
    out->shade.push_back(v.shade_ms);
    out->rest.push_back(total - sample_ms - v.pose_ms - v.shadow_ms - v.draw_ms - v.shade_ms);
    out->total.push_back(total);
  }
  // Brings the world to the pose: the time of posing is the world's.
  void show(const AsvoPose& pose) {
    const size_t first = body_.voxels.objects.size();
    for (size_t i = 0; i < pose.drawn.voxels.size(); ++i) {
      const Result<void> set =
          world_.set_pose(static_cast<ObjectId>(first + i), pose.drawn.voxels[i]);
      SINEW_CHECK(set.has_value());
    }
    world_.commit();
  }
  // A static body turns.
  void place(AsvoPose& pose) const {
    if (body_.turns) pose.drawn.voxels[0].placement = pose.pose.placement;
  }

  const AsvoBody& body_;
  const AsvoOptions& options_;
  World world_;
  std::vector<size_t> hidden_lights_;  // nodes
  RenderSettings settings_;
  RenderScratchPtr scratch_ = make_render_scratch();
  CameraView camera_;
  AsvoPose pose_;
  FrameStats stats_;
  Image radiance_;
  Image8 picture_;
};

json row_of(const char* table, const AsvoBody& body, const StageTimes& times) {
  return {{"table", table},
          {"scene", body.name},
          {"resolution", std::max({body.surface.grid.resolution.x, body.surface.grid.resolution.y,
                                   body.surface.grid.resolution.z})},
          {"leaf_voxels", body.svo().voxel_count()},
          {"total_ms", median(times.total)},
          {"frames_per_s", 1e3 / median(times.total)},
          {"sample_ms", median(times.sample)},
          {"pose_ms", median(times.pose)},
          {"shadow_ms", median(times.shadow)},
          {"draw_ms", median(times.draw)},
          {"shade_ms", median(times.shade)},
          {"rest_ms", median(times.rest)},
          {"voxels_drawn", times.camera.voxels_drawn},
          {"leaves_drawn", times.camera.leaves_drawn},
          {"cells", times.camera.cells},
          {"cells_hidden", times.camera.cells_hidden},
          {"shadow_voxels_drawn", times.shadows.voxels_drawn}};
}

}  // namespace

Result<void> measure_frames(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  const size_t lights = 1 + other_lights(body.voxels).size();
  for (const bool all : {false, true}) {
    if (all && lights == 1) continue;
    SINEW_TRY(FrameTimer timer, FrameTimer::open(body, options, all));
    json row = row_of("asvo_frame", body, timer.run(0.9f));
    row["lights"] = all ? lights : 1;
    row["size"] = options.size;
    row["threads"] = options.threads;
    rows.push_back(std::move(row));
  }
  return {};
}

Result<void> measure_sizes(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  SINEW_TRY(FrameTimer timer, FrameTimer::open(body, options));
  for (const float share : {0.05f, 0.1f, 0.2f, 0.4f, 0.6f, 0.9f, 1.5f, 3.0f}) {
    json row = row_of("asvo_size", body, timer.run(share));
    row["share"] = share;
    rows.push_back(std::move(row));
  }
  return {};
}

Result<void> measure_resolutions(AsvoBody& body, const AsvoOptions& options, json& rows) {
  for (const uint32_t resolution : {256u, 512u, 1024u, 2048u}) {
    SINEW_CHECKED(voxelise(body, resolution));
    SINEW_TRY(FrameTimer timer, FrameTimer::open(body, options));
    rows.push_back(row_of("asvo_resolution", body, timer.run(0.9f)));
  }
  return {};
}

void measure_grades(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  AsvoPainter painter(body);
  AsvoPose rest, moving;
  pose_at(body, 0, 0.0, rest);
  const CameraView camera = body_camera(body_box(body, rest), 0.3f);
  const RasterView view = camera_raster_view(camera, options.size, options.size);
  Visibility picture;
  for (const float grade : {0.0f, 0.25f, 0.5f, 1.0f, 1.5f, 2.0f}) {
    std::vector<double> ms[2];
    json row = {{"table", "asvo_grade"}, {"scene", body.name}, {"grade", grade}};
    for (uint32_t i = 0; i < options.repeats; ++i) {
      pose_at(body, 0, 0.37, moving);
      for (size_t j = 0; j < moving.joints.size(); ++j) {
        moving.joints[j] = rest.joints[j] + grade * (moving.joints[j] - rest.joints[j]);
      }
      painter.set_pose(moving);
      ms[0].push_back(milliseconds([&] { painter.draw(AsvoMethod::lattice, view, picture); }));
      ms[1].push_back(milliseconds([&] { painter.draw(AsvoMethod::thesis, view, picture); }));
      row["thesis_drawn"] = painter.thesis_stats.drawn;
      painter.draw(AsvoMethod::thesis_plain, view, picture);
      row["thesis_without_s_drawn"] = painter.thesis_stats.drawn;
    }
    row["lattice_drawn"] = painter.lattice_stats.voxels_drawn;
    row["lattice_ms"] = median(ms[0]);
    row["thesis_ms"] = median(ms[1]);
    rows.push_back(std::move(row));
  }
}

void measure_splats(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  const ThreadLimit one(1);
  AsvoPose pose;
  pose_at(body, 0, 0.0, pose);
  const CameraView camera = body_camera(body_box(body, pose), 0.9f);
  const RasterView view = camera_raster_view(camera, options.size, options.size);
  SvoMotion motion = make_svo_motion(body.svo());
  PosedSvo posed;
  RasterScratchPtr scratch = make_raster_scratch();
  Visibility picture;
  std::vector<double> total, draw, pose_ms, view_ms;
  RasterStats stats;
  for (uint32_t i = 0; i < kWarmups + options.repeats; ++i) {
    pose_at(body, 0, double(i) / 30.0, pose);
    const double ms = milliseconds([&] {
      posed.set_pose(motion, pose.pose);
      const VoxelInstance instance{&posed, pose.pose.placement, 0};
      stats =
          rasterize({&instance, 1}, view, {.lod = false, .occlusion = false}, *scratch, picture);
    });
    if (i < kWarmups) continue;
    total.push_back(ms);
    draw.push_back(stats.draw_ms);
    pose_ms.push_back(stats.pose_ms);
    view_ms.push_back(stats.view_ms);
  }
  const double voxels = double(body.svo().voxel_count());
  rows.push_back({{"table", "asvo_splats"},
                  {"scene", body.name},
                  {"voxels", body.svo().voxel_count()},
                  {"placed", stats.voxels_drawn},
                  {"total_ms", median(total)},
                  {"pose_ms", median(pose_ms)},
                  {"view_ms", median(view_ms)},
                  {"draw_ms", median(draw)},
                  {"splats_per_s", 1e3 * double(stats.voxels_drawn) / median(draw)},
                  {"voxels_per_s", 1e3 * voxels / median(total)}});
}

void add_drawing_figures(const json& rows, json& figures) {
  for (const json& row : rows) {
    if (row["table"] == "asvo_frame" && row["scene"] == "creature" && row["lights"] == 1) {
      figures.push_back(figure(
          "fps_800", row["frames_per_s"],
          fmt::format("{} frames of {} x {}: {} leaf voxels, {} drawn for the picture, {} for the "
                      "shadow map of its sun; {} threads",
                      row["scene"].get<std::string>(), row["size"].get<uint32_t>(),
                      row["size"].get<uint32_t>(), row["leaf_voxels"].get<uint64_t>(),
                      row["voxels_drawn"].get<uint64_t>(),
                      row["shadow_voxels_drawn"].get<uint64_t>(), row["threads"].get<int>())));
    }
    if (row["table"] == "asvo_splats") {
      figures.push_back(figure(
          "splats_per_core", row["splats_per_s"],
          fmt::format("every voxel of the creature placed and covered, nothing left out: {} "
                      "splats in {:.1f} ms of one thread; with posing and cells {:.1f} ms, "
                      "{:.0f} million voxels a second",
                      row["placed"].get<uint64_t>(), row["draw_ms"].get<double>(),
                      row["total_ms"].get<double>(), 1e-6 * row["voxels_per_s"].get<double>())));
    }
  }
}

}  // namespace sinew::bench
