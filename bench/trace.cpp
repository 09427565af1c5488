#include "bench/trace.h"

#include <array>
#include <optional>
#include <span>

#include "bench/embree_scene.h"
#include "bench/measure.h"
#include "bench/workload.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/bvh.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

constexpr size_t kRaysPerTask = 1024;

// Both opponents are asked in the same way: chunks of rays from the same threads.
template <class Engine>
void trace_closest(const Engine& engine, std::span<const Ray> rays, std::span<Hit> hits) {
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    engine.closest_hits(rays.subspan(begin, end - begin), hits.subspan(begin, end - begin));
  });
}
template <class Engine>
void trace_any(const Engine& engine, std::span<const Ray> rays, std::span<uint8_t> hit) {
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    engine.any_hits(rays.subspan(begin, end - begin), hit.subspan(begin, end - begin));
  });
}

constexpr std::array kKinds = {"primary", "shadow", "ambient"};

// Milliseconds of every repeat, by kind of ray.
struct Times {
  std::array<std::vector<double>, 3> kind;
  std::vector<double> total;
};

template <class Engine>
void time_once(const Engine& engine, const Workload& work, std::span<Hit> hits,
               std::span<uint8_t> any, Times& out) {
  const double primary = milliseconds([&] { trace_closest(engine, work.primary, hits); });
  const double shadow =
      milliseconds([&] { trace_any(engine, work.shadow, any.first(work.shadow.size())); });
  const double ambient =
      milliseconds([&] { trace_any(engine, work.ambient, any.first(work.ambient.size())); });
  out.kind[0].push_back(primary);
  out.kind[1].push_back(shadow);
  out.kind[2].push_back(ambient);
  out.total.push_back(primary + shadow + ambient);
}

double mega_per_second(size_t rays, const std::vector<double>& ms) {
  const double time = median(ms);
  return time > 0 ? double(rays) / time * 1e-3 : 0.0;
}

struct FrameResult {
  nlohmann::json row;
  double trace_ratio = 0.0;  // our rays a second over Embree's
  double refit_ratio = 0.0;  // our update time over Embree's refit
};

double differing(std::span<const Hit> a, std::span<const Hit> b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    count += static_cast<bool>(a[i]) != static_cast<bool>(b[i]) ||
             (a[i] && a[i].primitive != b[i].primitive);
  }
  return a.empty() ? 0.0 : double(count) / double(a.size());
}

// Refits: both bring the tree of the first frame to this one. Alternating, so that noise hits both.
void time_updates(const FlatScene& scene, Bvh& ours, EmbreeScene& embree, uint32_t repeats,
                  std::vector<double>& our_ms, std::vector<double>& embree_ms) {
  for (uint32_t r = 0; r < repeats; ++r) {
    our_ms.push_back(milliseconds([&] { (void)ours.update(scene.positions); }));
    std::copy(scene.positions.begin(), scene.positions.end(), embree.vertices().begin());
    embree_ms.push_back(milliseconds([&] { embree.commit(); }));
  }
}

Result<FrameResult> measure_frame(const FlatScene& scene, const CameraView& camera,
                                  const TraceOptions& options, Bvh& refitted,
                                  EmbreeScene& embree_refitted) {
  FrameResult out;
  std::vector<double> our_update, embree_update;
  time_updates(scene, refitted, embree_refitted, options.repeats, our_update, embree_update);

  std::optional<Result<Bvh>> built;
  const double our_build = milliseconds([&] { built = build(scene.positions, scene.triangles); });
  if (!*built) return fail(built->error());
  const Bvh& ours = **built;
  std::optional<EmbreeScene> embree;
  const double embree_build =
      milliseconds([&] { embree.emplace(scene.positions, scene.triangles, EmbreeMode::medium); });

  std::vector<Ray> primary = primary_rays(camera, options.width, options.height);
  std::vector<Hit> hits(primary.size()), embree_hits(primary.size());
  trace_closest(ours, primary, hits);
  const Workload work = make_workload(scene, std::move(primary), hits);
  std::vector<uint8_t> any(std::max(work.shadow.size(), work.ambient.size()));
  Times our_times, embree_times;
  for (uint32_t r = 0; r < options.repeats; ++r) {
    time_once(ours, work, hits, any, our_times);
    time_once(*embree, work, embree_hits, any, embree_times);
  }

  const std::array<size_t, 3> counts = {work.primary.size(), work.shadow.size(),
                                        work.ambient.size()};
  nlohmann::json& row = out.row;
  for (size_t k = 0; k < kKinds.size(); ++k) {
    if (counts[k] == 0) continue;
    const double our_rate = mega_per_second(counts[k], our_times.kind[k]);
    const double embree_rate = mega_per_second(counts[k], embree_times.kind[k]);
    row["mrays_per_s"][kKinds[k]] = {
        {"sinew", our_rate}, {"embree", embree_rate}, {"ratio", our_rate / embree_rate}};
    row["rays"][kKinds[k]] = counts[k];
  }
  out.trace_ratio = median(embree_times.total) / median(our_times.total);
  out.refit_ratio = median(our_update) / median(embree_update);
  row["trace_ratio"] = out.trace_ratio;
  row["refit_ratio"] = out.refit_ratio;
  row["build_ms"] = {{"sinew", our_build}, {"embree", embree_build}};
  row["update_ms"] = {{"sinew", median(our_update)}, {"embree", median(embree_update)}};
  row["primary_hits_differ"] = differing(hits, embree_hits);
  return out;
}

CameraView choose_camera(const Scene& scene, const ScenePose& pose, int clip,
                         const TraceOptions& options) {
  if (!scene.cameras.empty()) return scene_camera(scene, pose, 0);
  const float aspect = float(options.width) / float(options.height);
  return frame_box(animation_bounds(scene, clip, 8), vec3(0.5f, 0.35f, 1.0f), 0.8f, aspect);
}

}  // namespace

Result<nlohmann::json> bench_trace(const TraceOptions& options) {
  const ThreadLimit limit(options.threads);
  SINEW_TRY(const Scene scene, load(options.scene));
  SINEW_TRY(const int clip, find_clip(scene, options.clip));
  const double start = clip == kRestPose ? 0.0 : scene.clips[clip].start;
  const double end = clip == kRestPose ? 0.0 : scene.clips[clip].end;

  ScenePose pose;
  FlatScene flat;
  sample(scene, clip, start, pose);
  flatten(scene, pose, flat);
  SINEW_TRY(Bvh refitted, build(flat.positions, flat.triangles));
  EmbreeScene embree_refitted(flat.positions, flat.triangles, EmbreeMode::refit);

  nlohmann::json rows = nlohmann::json::array();
  std::vector<double> trace_ratios, refit_ratios;
  for (uint32_t f = 0; f < options.frames; ++f) {
    const double time = start + (end - start) * (f + 0.5) / options.frames;
    sample(scene, clip, time, pose);
    flatten(scene, pose, flat);
    const CameraView camera = choose_camera(scene, pose, clip, options);
    SINEW_TRY(FrameResult frame, measure_frame(flat, camera, options, refitted, embree_refitted));
    frame.row["scene"] = options.scene;
    frame.row["time_s"] = time;
    trace_ratios.push_back(frame.trace_ratio);
    refit_ratios.push_back(frame.refit_ratio);
    rows.push_back(std::move(frame.row));
  }
  const std::string size = std::to_string(flat.triangles.size()) + " triangles";
  return nlohmann::json{
      {"bench", "trace"},
      {"version", SINEW_VERSION},
      {"machine", {{"threads", thread_count()}, {"kernels", kernel_target()}}},
      {"opponents", {"Embree " RTC_VERSION_STRING}},
      {"scene", options.scene},
      {"triangles", flat.triangles.size()},
      {"figures",
       {figure(
            "trace_ratio", geometric_mean(trace_ratios), "1", "more",
            "rays a second of the binned-SAH tree, watertight, over Embree medium ROBUST; " + size),
        figure("refit_ratio", geometric_mean(refit_ratios), "1", "less",
               "time of a full update over Embree's refit; " + size)}},
      {"rows", std::move(rows)}};
}

}  // namespace sinew::bench
