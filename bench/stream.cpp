#include "bench/stream.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>

#include "bench/asvo_body.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/io/image_file.h"
#include "sinew/io/load.h"
#include "sinew/io/svo/svo.h"
#include "sinew/render/frame.h"
#include "sinew/scene/sample.h"
#include "sinew/svo/file/stream.h"
#include "sinew/svo/posed.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kWarmups = 3;
constexpr uint32_t kCompared = 6;       // every so many frames of the flight
constexpr uint32_t kMostFrames = 2000;  // until a picture is settled
constexpr uint64_t kMemory = uint64_t{32} << 30;

// A file that is gone when this is.
class Temporary {
 public:
  Temporary()
      : path_((std::filesystem::temp_directory_path() /
               fmt::format("sinew-bench-stream-{}.svo", static_cast<int>(getpid())))
                  .string()) {}
  ~Temporary() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

Result<void> make_file(const StreamOptions& options, const std::string& path) {
  const bool pigman = options.body == "pigman";
  if (!pigman && options.body != "creature") {
    return fail(
        {ErrorKind::usage, "", "", "there is no body " + options.body, "give pigman or creature"});
  }
  const std::string input = pigman ? options.data + "/skinned/pigman/pigman.glb" : options.creature;
  SINEW_TRY(const AsvoBody body, open_asvo_body({options.body, input, false}, options.resolution));
  SINEW_TRY(const SavedSvo saved, save_svo(body.voxels, path));
  return {};
}

// Where the camera is and what it sees at `u`, 0..1: around the body, from afar to near and back.
CameraView flight_camera(const Box& box, double u) {
  const float turn = 4.0f * static_cast<float>(u);
  const float share = 0.7f + 5.0f * std::pow(std::sin(3.14159265f * static_cast<float>(u)), 2.0f);
  CameraView camera = body_camera(box, share);
  const vec3 center = box.center();
  const mat3 around(vec3(std::cos(turn), 0, -std::sin(turn)), vec3(0, 1, 0),
                    vec3(std::sin(turn), 0, std::cos(turn)));
  for (int axis = 0; axis < 3; ++axis) camera.to_world[axis] = around * camera.to_world[axis];
  camera.to_world[3] = center + around * (camera.to_world[3] - center);
  return camera;
}

// A scene that is drawn frame by frame.
class Stage {
 public:
  // `keeps`: pictures are drawn until they are settled.
  static Result<Stage> open(const std::string& path, uint64_t voxel_memory,
                            const StreamOptions& options, bool keeps = false) {
    LoadOptions load_options;
    load_options.memory_limit = kMemory;
    load_options.voxel_memory = voxel_memory;
    load_options.settle = keeps;
    SINEW_TRY(Scene scene, load(path, load_options));
    auto kept = std::make_unique<Scene>(std::move(scene));
    SINEW_TRY(World world, prepare(*kept));
    Stage stage(std::move(kept), std::move(world));
    stage.settings_.width = stage.settings_.height = options.size;
    stage.settings_.reflections = 0;
    return stage;
  }

  // Milliseconds from the pose to the picture.
  double draw(const CameraView& camera, double u) {
    return milliseconds([&] {
      const double end = scene_->clips.empty() ? 0.0 : scene_->clips[0].end;
      const Result<void> set = world_.set_time(u * end);
      SINEW_CHECK(set.has_value());
      render_frame(world_, *scene_, world_.pose(), camera, settings_, *scratch_, radiance_);
      tonemap(radiance_, 0.0f, picture_);
    });
  }
  // Camera rays find voxels from now on, or the rasteriser does.
  void trace(bool traced) {
    settings_.voxels.primary = traced ? VoxelPrimary::trace : VoxelPrimary::automatic;
  }
  const Image8& picture() const { return picture_; }
  PagingStats paging() const { return paging_stats(scene_->octrees); }
  const Scene& scene() const { return *scene_; }

  // Of the voxel bodies at rest, in the world.
  Box box() const {
    ScenePose pose;
    sample(*scene_, kRestPose, 0.0, pose);
    Box box;
    for (size_t i = 0; i < scene_->voxels.size(); ++i) {
      const Svo& svo = scene_->octrees[scene_->voxels[i].octree];
      const SvoMotion motion = make_svo_motion(svo);
      PosedSvo posed;
      posed.set_pose(motion, pose.voxels[i]);
      box.extend(transform_box(pose.voxels[i].placement, posed.bounds(0)));
    }
    return box;
  }

 private:
  Stage(std::unique_ptr<Scene> scene, World world)
      : scene_(std::move(scene)), world_(std::move(world)) {}

  std::unique_ptr<Scene> scene_;
  World world_;
  RenderSettings settings_;
  RenderScratchPtr scratch_ = make_render_scratch();
  Image radiance_;
  Image8 picture_;
};

double mib(uint64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

// Draws until nothing is missing that fits, or nothing comes any more.
double settle(Stage& stage, const CameraView& camera) {
  double ms = 0.0;
  uint32_t quiet = 0;
  PagingStats before = stage.paging();
  for (uint32_t i = 0; i < kMostFrames && quiet < 3; ++i) {
    ms += stage.draw(camera, 0.0);
    const PagingStats now = stage.paging();
    const bool moved = now.loaded != before.loaded || now.damaged != before.damaged;
    // `missing` is what the frame before asked for.
    quiet = !moved && (now.missing == 0 || now.bytes_read == before.bytes_read) ? quiet + 1 : 0;
    before = now;
  }
  return ms;
}

constexpr double kViews[] = {0.0, 0.5};  // of the flight: the whole body, and near

// How long pictures to keep take under the budget, in how many parts they are drawn (if they are
// not traced), and whether they are the whole octree's.
Result<void> measure_keeping(const std::string& path, uint64_t budget, const StreamOptions& options,
                             bool traced, Stage& whole, const Box& box, std::span<json> rows) {
  std::optional<Result<Stage>> opened;
  const double open_ms = milliseconds([&] { opened = Stage::open(path, budget, options, true); });
  if (!*opened) return fail((*opened).error());
  Stage& stage = **opened;
  stage.trace(traced);
  PagingStats before = stage.paging();
  for (size_t i = 0; i < rows.size(); ++i) {
    const CameraView camera = flight_camera(box, kViews[i]);
    const double whole_ms = whole.draw(camera, 0.0);
    const double ms = stage.draw(camera, 0.0);
    SINEW_TRY(const ImageDifference kept, compare_images(stage.picture(), whole.picture()));
    const PagingStats now = stage.paging();
    rows[i]["whole_ms"] = whole_ms;
    rows[i]["kept_ms"] = ms + (i == 0 ? open_ms : 0.0);
    rows[i]["kept_identical"] = kept.largest == 0.0;
    rows[i]["kept_fits"] = now.unsettled == before.unsettled;
    rows[i]["kept_psnr"] = std::min(kept.psnr, 99.0);
    rows[i]["kept_parts"] = now.parts - before.parts;
    rows[i]["kept_loaded"] = now.loaded - before.loaded;
    rows[i]["kept_most_mib"] = mib(now.most);
    before = now;
  }
  return {};
}

// Time from opening to the first picture, and to one that is settled; and whether that is the
// whole octree's, from afar and from near. Then the same of pictures to keep.
Result<void> measure_settling(const std::string& path, uint64_t budget, const char* name,
                              const StreamOptions& options, bool traced, Stage& whole,
                              const Box& box, json& rows, json& skipped) {
  std::optional<Result<Stage>> opened;
  const double open_ms = milliseconds([&] { opened = Stage::open(path, budget, options); });
  if (!*opened) {
    skipped.push_back({{"what", name}, {"why", opened->error().message()}});
    return {};
  }
  Stage& stage = **opened;
  stage.trace(traced);
  whole.trace(traced);
  std::vector<json> views;
  for (const double u : kViews) {
    const CameraView camera = flight_camera(box, u);
    whole.draw(camera, 0.0);
    const double first_ms = stage.draw(camera, 0.0);
    SINEW_TRY(const ImageDifference first, compare_images(stage.picture(), whole.picture()));
    const double settle_ms = settle(stage, camera);
    SINEW_TRY(const ImageDifference settled, compare_images(stage.picture(), whole.picture()));
    const PagingStats stats = stage.paging();
    views.push_back({{"table", "stream_settle"},
                     {"budget", name},
                     {"budget_mib", mib(budget)},
                     {"view", u == 0.0 ? traced ? "traced" : "whole body"
                              : traced ? "traced near"
                                       : "near"},
                     {"traced", traced},
                     {"open_ms", u == 0.0 ? open_ms : 0.0},
                     {"first_ms", first_ms + (u == 0.0 ? open_ms : 0.0)},
                     {"first_psnr", std::min(first.psnr, 99.0)},
                     {"settled_ms", first_ms + settle_ms + (u == 0.0 ? open_ms : 0.0)},
                     {"identical", settled.largest == 0.0},
                     {"fits", stats.missing == 0},
                     {"loaded", stats.loaded},
                     {"evicted", stats.evicted},
                     {"read_mib", mib(stats.bytes_read)},
                     {"most_mib", mib(stats.most)}});
  }
  SINEW_CHECKED(measure_keeping(path, budget, options, traced, whole, box, views));
  for (json& row : views) rows.push_back(std::move(row));
  return {};
}

struct Flight {
  std::vector<double> ms;
  std::vector<Image8> pictures;  // every kCompared-th
  uint32_t coarse = 0;           // frames that showed something coarser than wanted
};

Flight fly(Stage& stage, const Box& box, uint32_t frames) {
  Flight flight;
  for (uint32_t i = 0; i < kWarmups; ++i) stage.draw(flight_camera(box, 0.0), 0.0);
  for (uint32_t i = 0; i < frames; ++i) {
    const double u = double(i) / double(frames);
    flight.ms.push_back(stage.draw(flight_camera(box, u), u));
    if (stage.paging().missing > 0) ++flight.coarse;
    if (i % kCompared == 0) flight.pictures.push_back(stage.picture());
  }
  return flight;
}

double p99(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, values.size() * 99 / 100)];
}

Result<void> measure_flight(const std::string& path, uint64_t budget, const char* name,
                            const StreamOptions& options, const Box& box, const Flight& whole,
                            json& rows, json& skipped) {
  Result<Stage> stage = Stage::open(path, budget, options);
  if (!stage) {
    skipped.push_back({{"what", std::string("flight, ") + name}, {"why", stage.error().message()}});
    return {};
  }
  const Flight flight = fly(*stage, box, options.frames);
  std::vector<double> psnr;
  for (size_t i = 0; i < flight.pictures.size(); ++i) {
    SINEW_TRY(const ImageDifference d, compare_images(flight.pictures[i], whole.pictures[i]));
    psnr.push_back(std::min(d.psnr, 99.0));
  }
  const PagingStats stats = stage->paging();
  const double middle = median(flight.ms);
  const auto stalled = std::ranges::count_if(flight.ms, [&](double ms) { return ms > 2 * middle; });
  rows.push_back({{"table", "stream_flight"},
                  {"budget", name},
                  {"budget_mib", mib(budget)},
                  {"frames", options.frames},
                  {"median_ms", middle},
                  {"p99_ms", p99(flight.ms)},
                  {"largest_ms", *std::ranges::max_element(flight.ms)},
                  {"stutter", p99(flight.ms) / middle},
                  {"whole_median_ms", median(whole.ms)},
                  {"whole_p99_ms", p99(whole.ms)},
                  {"stalled", stalled},
                  {"coarse_frames", flight.coarse},
                  {"psnr_median", median(psnr)},
                  {"psnr_least", *std::ranges::min_element(psnr)},
                  {"loaded", stats.loaded},
                  {"evicted", stats.evicted},
                  {"damaged", stats.damaged},
                  {"read_mib", mib(stats.bytes_read)},
                  {"most_mib", mib(stats.most)},
                  {"frame_ms", flight.ms}});
  return {};
}

void add_figures(const json& rows, const json& file, const StreamOptions& options, json& figures) {
  size_t kept = 0, identical = 0, coarse = 0;
  for (const json& row : rows) {
    if (row["table"] == "stream_settle") {
      const bool no_parts = row["traced"] == true && row["kept_fits"] == false;
      coarse += no_parts ? 1 : 0;
      kept += no_parts ? 0 : 1;
      identical += !no_parts && row["kept_identical"] == true ? 1 : 0;
    }
    if (row["table"] == "stream_flight" && row["budget_mib"] == double(options.flight_budget)) {
      const std::string where =
          fmt::format("{} MiB, {} x {} pixels, {} frames; median {:.1f} ms", options.flight_budget,
                      options.size, options.size, options.frames, row["median_ms"].get<double>());
      figures.push_back(figure("flight_stutter", row["stutter"], where));
      figures.push_back(figure("flight_psnr", row["psnr_median"], where));
    }
  }
  if (kept > 0) {
    figures.push_back(
        figure("settled", identical == kept ? 1.0 : 0.0,
               fmt::format("{} of {} pictures to keep are the whole octree's; {} more, traced, do "
                           "not fit at once and show cells",
                           identical, kept, coarse)));
  }
  const uint32_t longest = file["resolution"];
  figures.push_back(figure(longest == kHighestResolution ? "bytes_4096" : "bytes_smaller",
                           file["bytes_per_voxel"],
                           fmt::format("{} voxels along the longest side", longest)));
}

json file_row(const std::string& path, const Stage& whole, const PagingStats& paged) {
  uint64_t voxels = 0, bytes = 0;
  uint32_t longest = 0;
  for (const Svo& svo : whole.scene().octrees) {
    voxels += svo.voxel_count();
    bytes += svo.bytes();
    const uvec3 r = svo.grid.resolution;
    longest = std::max({longest, r.x, r.y, r.z});
  }
  const uint64_t size = std::filesystem::file_size(path);
  return {{"table", "stream_file"},
          {"resolution", longest},
          {"voxels", voxels},
          {"blocks", paged.blocks},
          {"file_mib", mib(size)},
          {"bytes_per_voxel", double(size) / double(std::max<uint64_t>(voxels, 1))},
          {"memory_mib", mib(bytes)},
          {"skeleton_mib", mib(paged.skeleton)},
          {"detail_mib", mib(paged.detail)},
          {"least_mib", mib(paged.least)}};
}

}  // namespace

Result<json> bench_stream(const StreamOptions& options) {
  const ThreadLimit limit(options.threads);
  const Temporary made;
  const std::string path = options.file.empty() ? made.path() : options.file;
  if (options.file.empty()) SINEW_CHECKED(make_file(options, path));
  SINEW_TRY(Stage whole, Stage::open(path, 0, options));
  const Box box = whole.box();
  PagingStats paged;
  {
    SINEW_TRY(const Stage stage, Stage::open(path, kMemory, options));
    paged = stage.paging();
  }
  json rows = json::array(), skipped = json::array(), figures = json::array();
  const json file = file_row(path, whole, paged);
  rows.push_back(file);
  // One that is too small for what is seen: a quarter of the details.
  const uint64_t tight = paged.least + paged.detail / 4;
  for (const bool traced : {false, true}) {
    for (const uint32_t budget : options.budgets) {
      SINEW_CHECKED(measure_settling(path, uint64_t{budget} << 20,
                                     fmt::format("{} MiB", budget).c_str(), options, traced, whole,
                                     box, rows, skipped));
    }
    SINEW_CHECKED(
        measure_settling(path, tight, "a quarter", options, traced, whole, box, rows, skipped));
  }
  whole.trace(false);
  const Flight flight = fly(whole, box, options.frames);
  SINEW_CHECKED(measure_flight(path, uint64_t{options.flight_budget} << 20,
                               fmt::format("{} MiB", options.flight_budget).c_str(), options, box,
                               flight, rows, skipped));
  SINEW_CHECKED(measure_flight(path, tight, "a quarter", options, box, flight, rows, skipped));
  add_figures(rows, file, options, figures);
  json report = report_head("stream");
  report["figures"] = std::move(figures);
  report["rows"] = std::move(rows);
  report["skipped"] = std::move(skipped);
  return report;
}

}  // namespace sinew::bench
