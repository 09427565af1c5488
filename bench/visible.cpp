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
constexpr float kWidestView = 0.8f;        // radians, full vertical angle: sees everything
constexpr float kNarrowest = 1.0f / 256;   // of it
constexpr vec3 kSun{0.75f, 0.62f, 0.55f};  // where study:herd has it
constexpr double kTolerance = 0.03;        // of the fraction that is looked for

// A camera that travels with what moves and can be zoomed.
class Zoom {
 public:
  Zoom(Arena& arena, const UpdateOptions& options)
      : arena_(arena), width_(options.width), height_(options.height) {
    const Box box = moving_box(0);
    const float aspect = float(width_) / float(height_);
    offset_ = frame_box(box, kDirection, kWidestView, aspect).to_world[3] - box.center();
  }

  // What the camera sees at a zoom of 0 to 1, 1 being everything that moves. The light stands
  // behind it, so that shadow rays go through it.
  Picture picture(float zoom, uint32_t frame) const {
    const vec3 center = moving_box(frame).center();
    const CameraView camera = look_at(center + offset_, center, vec3(0, 1, 0), kWidestView * zoom);
    return {primary_rays(camera, width_, height_),
            normalize(vec3(-kDirection.x, kDirection.y, -kDirection.z))};
  }

 private:
  static constexpr vec3 kDirection{0.5f, 0.7f, 1.0f};  // from what moves to the eye

  Box moving_box(uint32_t frame) const {
    Box all;
    const ScenePose& pose = arena_.pose_at(arena_.time_of(frame));
    for (const Box& box : object_boxes(arena_.scene(), pose)) all.extend(box);
    return all;
  }

  Arena& arena_;
  uint32_t width_, height_;
  vec3 offset_{0.0f};
};

// The fraction of the deforming treelets that the rays reach in the next frames, on average. Every
// frame is another one, for treelets of an unchanged pose stay made.
double fraction_of(const Arena& arena, const Zoom& zoom, float at, uint32_t frames,
                   uint32_t& frame) {
  const Engine& lazy = *arena.find("sinew lazy");
  double sum = 0.0;
  for (uint32_t i = 0; i < frames; ++i, ++frame) {
    lazy.pose(arena.time_of(frame));
    trace_picture(lazy, zoom.picture(at, frame));
    const UpdateStats stats = arena.world("sinew lazy")->stats();
    sum += double(stats.treelets_made) / double(std::max<uint64_t>(stats.treelets, 1));
  }
  return sum / frames;
}

// A zoom at which about this fraction is reached, by bisection in its logarithm.
float zoom_for(const Arena& arena, const Zoom& zoom, double fraction, uint32_t& frame) {
  float low = kNarrowest, high = 1.0f;
  if (fraction_of(arena, zoom, high, 1, frame) <= fraction) return high;
  for (int step = 0; step < 10; ++step) {
    const float middle = std::sqrt(low * high);
    const double reached = fraction_of(arena, zoom, middle, 1, frame);
    if (std::abs(reached / fraction - 1.0) < kTolerance) return middle;
    (reached > fraction ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

// What all engines say about a picture, frame after frame.
struct Drawing {
  std::vector<Rival> rivals;          // in the order of the arena's engines
  std::vector<PictureCounts> counts;  // of the last frame
  std::string embree_calls;
};

template <class PictureOf>
Drawing draw(Arena& arena, const PictureOf& picture_of, uint32_t repeats, uint32_t& frame) {
  Drawing out;
  Picture picture = picture_of(frame);
  const Engine& refit = *arena.find("embree refit");
  refit.pose(arena.time_of(frame));
  out.embree_calls = choose_embree_calls(arena, refit, picture);
  const size_t count = arena.engines().size();
  out.counts.resize(count);
  out.rivals.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const Engine& engine = arena.engines()[i];
    out.rivals[i].name = engine.name;
    out.rivals[i].run = [&, i](uint32_t f) {
      out.rivals[i].pose_ms.push_back(milliseconds([&] { engine.pose(arena.time_of(f)); }));
      out.counts[i] = trace_picture(engine, picture);
    };
  }
  frame = compete(out.rivals, {3, repeats}, frame, [&](uint32_t f) { picture = picture_of(f); });
  return out;
}

std::span<json> rows_from(UpdateReport& report, size_t first) {
  return std::span(report.rows.get_ref<json::array_t&>()).subspan(first);
}

void describe(const Drawing& drawing, std::span<json> rows) {
  for (size_t i = 0; i < rows.size(); ++i) {
    const Rival& rival = drawing.rivals[i];
    rows[i]["pose_ms"] = median(rival.pose_ms);
    rows[i]["hits"] = drawing.counts[i].hits;
    rows[i]["lit"] = drawing.counts[i].lit;
    if (rival.name.starts_with("embree")) rows[i]["calls"] = drawing.embree_calls;
  }
}

Result<void> add_engines(Arena& arena, std::initializer_list<UpdateMode> modes) {
  for (const UpdateMode mode : modes) SINEW_CHECKED(arena.add_ours(mode));
  arena.add_embree(EmbreeMode::refit);
  arena.add_embree(EmbreeMode::low);
  return {};
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
    const float at = zoom_for(arena, zoom, wanted, frame);
    const double fraction = fraction_of(arena, zoom, at, 3, frame);
    if (fraction < last * 1.1) continue;  // no more can be seen
    last = fraction;
    const Drawing drawing = draw(
        arena, [&](uint32_t f) { return zoom.picture(at, f); }, options.repeats, frame);
    const size_t first = report.rows.size();
    add_sweep_point(report, "visible_fraction", name, fraction, drawing.rivals);
    describe(drawing, rows_from(report, first));
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
  const auto picture_of = [&](uint32_t frame) {
    const ScenePose& pose = arena.pose_at(arena.time_of(frame));
    const Scene& s = arena.scene();
    const CameraView camera = s.cameras.empty()
                                  ? look_at(vec3(20.0f), vec3(0.0f), vec3(0, 1, 0), 0.8f)
                                  : scene_camera(s, pose, 0);
    return Picture{primary_rays(camera, options.width, options.height), normalize(kSun)};
  };
  uint32_t frame = 0;
  const Drawing drawing = draw(arena, picture_of, options.repeats, frame);
  const size_t first = report.rows.size();
  for (const Rival& rival : drawing.rivals) {
    report.rows.push_back({{"table", "herd_frame"},
                           {"scene", options.herd},
                           {"triangles", arena.triangles()},
                           {"method", rival.name},
                           {"ms", rival.median_ms()}});
  }
  describe(drawing, rows_from(report, first));
  const Rival &ours = drawing.rivals[0], &theirs = *best_of(drawing.rivals, "embree");
  report.figures.push_back(figure(
      "herd_frame", theirs.median_ms() / ours.median_ms(),
      fmt::format("{} triangles, {} hits: {:.1f} ms (pose {:.1f}), {} {:.1f} ms (pose {:.1f})",
                  arena.triangles(), drawing.counts[0].hits, ours.median_ms(), median(ours.pose_ms),
                  theirs.name, theirs.median_ms(), median(theirs.pose_ms))));
  return {};
}

}  // namespace sinew::bench
