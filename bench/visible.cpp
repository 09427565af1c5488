#include "bench/visible.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "bench/frame_work.h"
#include "bench/measure.h"
#include "bench/workload.h"
#include "sinew/io/load.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr std::array kFractions = {0.02, 0.05, 0.10, 0.20, 0.30, 0.45, 0.65, 1.0};
constexpr float kWidestView = 0.8f;       // radians, full vertical angle: sees everything
constexpr float kNarrowest = 1.0f / 256;  // of it
constexpr double kTolerance = 0.03;       // of the fraction that is looked for

// A camera before everything that moves, which can be zoomed.
class Zoom {
 public:
  Zoom(Arena& arena, const UpdateOptions& options)
      : width_(options.width), height_(options.height) {
    const ScenePose& pose = arena.pose_at(arena.time_of(0));
    Box moving;
    for (const Box& box : object_boxes(arena.scene(), pose)) moving.extend(box);
    const float aspect = float(width_) / float(height_);
    eye_ = frame_box(moving, direction_, kWidestView, aspect).to_world[3];
    target_ = moving.center();
  }

  // What the camera sees at a zoom of 0 to 1, 1 being everything that moves. The light stands
  // behind the scene, so that shadow rays go through it.
  Picture picture(float zoom) const {
    const CameraView camera = look_at(eye_, target_, vec3(0, 1, 0), kWidestView * zoom);
    return {primary_rays(camera, width_, height_),
            normalize(vec3(-direction_.x, direction_.y, -direction_.z))};
  }

 private:
  uint32_t width_, height_;
  vec3 direction_{0.5f, 0.7f, 1.0f};
  vec3 eye_{0.0f}, target_{0.0f};
};

// The fraction of the deforming treelets that the picture's rays reach.
// The pose must differ from the last one, for treelets of an unchanged pose stay made.
double fraction_of(const Arena& arena, const Picture& picture, uint32_t& frame) {
  const Engine& lazy = *arena.find("sinew lazy");
  lazy.pose(arena.time_of(frame++));
  trace_picture(lazy, picture);
  const UpdateStats stats = arena.world("sinew lazy")->stats();
  return double(stats.treelets_made) / double(std::max<uint64_t>(stats.treelets, 1));
}

// A zoom at which about this fraction is reached, by bisection in its logarithm.
Picture picture_of(const Arena& arena, const Zoom& zoom, double fraction, double& reached,
                   uint32_t& frame) {
  float low = kNarrowest, high = 1.0f;
  Picture picture = zoom.picture(high);
  reached = fraction_of(arena, picture, frame);
  if (reached <= fraction) return picture;
  for (int step = 0; step < 10 && std::abs(reached / fraction - 1.0) > kTolerance; ++step) {
    const float middle = std::sqrt(low * high);
    picture = zoom.picture(middle);
    reached = fraction_of(arena, picture, frame);
    (reached > fraction ? high : low) = middle;
  }
  return picture;
}

// All engines draw the picture, frame after frame.
std::vector<Rival> draw(const Arena& arena, const Picture& picture, uint32_t repeats,
                        std::vector<PictureCounts>& counts, uint32_t& frame) {
  counts.assign(arena.engines().size(), {});
  std::vector<Rival> rivals;
  for (size_t i = 0; i < arena.engines().size(); ++i) {
    const Engine& engine = arena.engines()[i];
    rivals.push_back({engine.name, [&, i](uint32_t f) {
                        engine.pose(arena.time_of(f));
                        counts[i] = trace_picture(engine, picture);
                      }});
  }
  frame = compete(rivals, {3, repeats}, frame);
  return rivals;
}

Result<void> add_engines(Arena& arena, std::initializer_list<UpdateMode> modes) {
  for (const UpdateMode mode : modes) SINEW_CHECKED(arena.add_ours(mode));
  arena.add_embree(EmbreeMode::refit);
  arena.add_embree(EmbreeMode::low);
  return {};
}

void prepare_embree(Arena& arena, const Picture& picture) {
  const Engine& refit = *arena.find("embree refit");
  refit.pose(arena.time_of(0));
  choose_embree_calls(arena, refit, picture);
}

}  // namespace

Result<void> sweep_visible(Scene scene, const std::string& name, const UpdateOptions& options,
                           UpdateReport& report) {
  Arena arena;
  SINEW_CHECKED(arena.open(std::move(scene), name));
  SINEW_CHECKED(add_engines(
      arena, {UpdateMode::automatic, UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}));
  const Zoom zoom(arena, options);
  uint32_t frame = 0;
  double last = 0.0;
  for (const double wanted : kFractions) {
    double fraction = 0.0;
    const Picture picture = picture_of(arena, zoom, wanted, fraction, frame);
    if (fraction < last * 1.1) continue;  // no more can be seen
    last = fraction;
    prepare_embree(arena, picture);
    std::vector<PictureCounts> counts;
    const std::vector<Rival> rivals = draw(arena, picture, options.repeats, counts, frame);
    const size_t first_row = report.rows.size();
    add_sweep_point(report, "visible_fraction", name, fraction, rivals);
    for (size_t i = first_row; i < report.rows.size(); ++i) {
      report.rows[i]["hits"] = counts[i - first_row].hits;
      report.rows[i]["lit"] = counts[i - first_row].lit;
    }
  }
  return {};
}

void add_visible_30(UpdateReport& report) {
  constexpr double kAt = 0.30;
  std::vector<double> ratios;
  std::string note;
  for (const std::string& scene : sweep_scenes(report.rows, "visible_fraction")) {
    const std::vector<SweepLine> lines = sweep_lines(report.rows, "visible_fraction", scene);
    const SweepLine ours = fastest_line(lines, "sinew auto");
    const SweepLine theirs = fastest_line(lines, "embree");
    if (ours.x.empty() || theirs.x.empty()) continue;
    const double at = std::clamp(kAt, ours.x.front(), ours.x.back());
    ratios.push_back(interpolate(theirs, at) / interpolate(ours, at));
    note += fmt::format("{}{} {:.2f} at {:.0f}%", note.empty() ? "" : ", ", scene, ratios.back(),
                        100.0 * at);
  }
  if (ratios.empty()) return;
  report.figures.push_back(
      figure("visible_30", geometric_mean(ratios), "Embree's best over auto: " + note));
}

Result<void> measure_herd(const UpdateOptions& options, UpdateReport& report) {
  SINEW_TRY(Scene scene, load(options.herd));
  Arena arena;
  SINEW_CHECKED(arena.open(std::move(scene), options.herd));
  SINEW_CHECKED(add_engines(arena, {UpdateMode::automatic}));
  const ScenePose& pose = arena.pose_at(arena.time_of(0));
  Picture picture{{}, normalize(vec3(0.75f, 0.62f, 0.55f))};
  picture.primary =
      primary_rays(scene_camera(arena.scene(), pose, 0), options.width, options.height);
  prepare_embree(arena, picture);
  std::vector<PictureCounts> counts;
  uint32_t frame = 0;
  const std::vector<Rival> rivals = draw(arena, picture, options.repeats, counts, frame);
  for (size_t i = 0; i < rivals.size(); ++i) {
    report.rows.push_back({{"table", "herd_frame"},
                           {"scene", options.herd},
                           {"triangles", arena.triangles()},
                           {"method", rivals[i].name},
                           {"ms", rivals[i].median_ms()},
                           {"hits", counts[i].hits},
                           {"lit", counts[i].lit}});
  }
  const Rival* const theirs = best_of(rivals, "embree");
  report.figures.push_back(figure(
      "herd_frame", theirs->median_ms() / rivals[0].median_ms(),
      fmt::format("{} triangles, {} hits: {:.1f} ms, {} {:.1f} ms", arena.triangles(),
                  counts[0].hits, rivals[0].median_ms(), theirs->name, theirs->median_ms())));
  return {};
}

}  // namespace sinew::bench
