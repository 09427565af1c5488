#include "bench/trace.h"

#include <array>
#include <optional>
#include <span>

#include "bench/calls.h"
#include "bench/contest.h"
#include "bench/embree_scene.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "bench/workload.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/bvh.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

// What the figures are made of: ratios to Embree, one a scene, frame and kind of ray.
struct Ratios {
  std::vector<double> single_robust, single_fast;    // rays a second, one ray a call
  std::vector<double> packets_robust, packets_fast;  // primary rays, best call of each
  std::vector<double> refit;                         // time of an update
};

// Embree's hierarchies of one kind, watertight and not.
struct EmbreePair {
  EmbreeScene robust, fast;
  EmbreePair(const FlatScene& scene, EmbreeMode mode) : robust({mode, true}), fast({mode, false}) {
    for (EmbreeScene* const embree : {&robust, &fast}) {
      embree->add_mesh(scene.positions, scene.triangles, EmbreeMotion::deforms);
      embree->commit();
    }
  }
  void move(std::span<const vec3> positions) {
    for (EmbreeScene* const embree : {&robust, &fast}) {
      std::ranges::copy(positions, embree->vertices().begin());
    }
  }
  const EmbreeScene& with(TriangleTest test) const {
    return test == TriangleTest::robust ? robust : fast;
  }
};

// One frame of one scene: where we are, for the rows.
struct Place {
  std::string scene;
  double time = 0.0;
  const char* tree = "static";  // or "refit"
  TriangleTest test = TriangleTest::robust;
};

struct Kind {
  const char* name;
  std::span<const Ray> rays;
  bool closest;  // closest hits, or any hit
};

// Millions of rays a second by every call, into `rows`. The rivals are in the order of `calls`.
std::vector<Rival> time_kind(const Place& place, const Kind& kind, std::span<const Call> calls,
                             uint32_t repeats, json& rows) {
  std::vector<Hit> hits(kind.closest ? kind.rays.size() : 0);
  std::vector<uint8_t> hit(kind.closest ? 0 : kind.rays.size());
  std::vector<Rival> rivals;
  for (const Call& call : calls) {
    rivals.push_back({call.name, [&](uint32_t) {
                        kind.closest ? trace_closest(call, kind.rays, hits)
                                     : trace_any(call, kind.rays, hit);
                      }});
  }
  compete(rivals, {1, repeats}, 0);
  for (const Rival& rival : rivals) {
    rows.push_back({{"table", "trace"},
                    {"scene", place.scene},
                    {"time_s", place.time},
                    {"tree", place.tree},
                    {"test", name_of(place.test)},
                    {"kind", kind.name},
                    {"call", rival.name},
                    {"rays", kind.rays.size()},
                    {"mrays_per_s", double(kind.rays.size()) / rival.median_ms() * 1e-3}});
  }
  return rivals;
}

void time_kinds(const Place& place, const Workload& work, std::span<const Call> calls,
                uint32_t repeats, json& rows, Ratios& ratios) {
  const bool robust = place.test == TriangleTest::robust;
  const bool counts = std::string_view(place.tree) == "static";
  for (const Kind& kind : {Kind{"primary", work.primary, true}, Kind{"shadow", work.shadow, false},
                           Kind{"ambient", work.ambient, false}}) {
    if (kind.rays.empty()) continue;
    const std::vector<Rival> rivals = time_kind(place, kind, calls, repeats, rows);
    const Rival* const ours = find(rivals, kOurSingle);
    if (!counts || ours == nullptr) continue;
    const double single = find(rivals, kEmbreeSingle)->median_ms() / ours->median_ms();
    (robust ? ratios.single_robust : ratios.single_fast).push_back(single);
    if (!kind.closest) continue;
    const double best =
        best_of(rivals, "embree")->median_ms() / best_of(rivals, "sinew")->median_ms();
    (robust ? ratios.packets_robust : ratios.packets_fast).push_back(best);
  }
}

// All calls on one kind of tree, ours and Embree's.
void time_tree(Place place, const Bvh& ours, const EmbreePair& embree, const Workload& work,
               uint32_t repeats, json& rows, Ratios& ratios) {
  for (const TriangleTest test : {TriangleTest::robust, TriangleTest::fast}) {
    place.test = test;
    std::vector<Call> calls = our_calls(ours, test);
    for (Call& call : embree_calls(embree.with(test))) calls.push_back(std::move(call));
    time_kinds(place, work, calls, repeats, rows, ratios);
  }
}

double differing(std::span<const Hit> a, std::span<const Hit> b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    count += static_cast<bool>(a[i]) != static_cast<bool>(b[i]) ||
             (a[i] && a[i].primitive != b[i].primitive);
  }
  return a.empty() ? 0.0 : double(count) / double(a.size());
}

Workload workload_of(const FlatScene& scene, const CameraView& camera, const Bvh& bvh,
                     const TraceOptions& options) {
  std::vector<Ray> primary = primary_rays(camera, options.width, options.height);
  std::vector<Hit> hits(primary.size());
  trace_closest(our_calls(bvh, TriangleTest::robust)[0], primary, hits);
  Workload work = make_workload(scene, std::move(primary), hits);
  for (std::vector<Ray>* const rays : {&work.primary, &work.shadow, &work.ambient}) {
    thin_out(*rays, options.most_rays);
  }
  return work;
}

// The hierarchies that follow the clip from its beginning.
struct Followers {
  Bvh ours;
  EmbreePair embree;
};

// Brings the followers to the frame, and says how long that and a new build take.
Result<Bvh> time_trees(const Place& place, const FlatScene& scene, Followers& followers,
                       std::optional<EmbreePair>& built, const TraceOptions& options, json& rows,
                       Ratios& ratios) {
  std::vector<Rival> rivals = {
      {"sinew", [&](uint32_t) { (void)followers.ours.update_borrowed(scene.positions); }},
      {"embree", [&](uint32_t) { followers.embree.robust.commit(); }}};
  compete(rivals, {1, options.repeats}, 0,
          [&](uint32_t) { followers.embree.move(scene.positions); });
  followers.embree.fast.commit();
  std::optional<Result<Bvh>> ours;
  const double our_build = milliseconds([&] { ours = build(scene.positions, scene.triangles); });
  EmbreeScene timed({EmbreeMode::medium, true});
  timed.add_mesh(scene.positions, scene.triangles, EmbreeMotion::deforms);
  const double embree_build = milliseconds([&] { timed.commit(); });
  built.emplace(scene, EmbreeMode::medium);
  const double ratio = rivals[0].median_ms() / rivals[1].median_ms();
  ratios.refit.push_back(ratio);
  rows.push_back(
      {{"table", "trees"},
       {"scene", place.scene},
       {"time_s", place.time},
       {"triangles", scene.triangles.size()},
       {"build_ms", {{"sinew", our_build}, {"embree", embree_build}}},
       {"update_ms", {{"sinew", rivals[0].median_ms()}, {"embree", rivals[1].median_ms()}}},
       {"refit_ratio", ratio}});
  return std::move(*ours);
}

Result<void> measure_frame(const Place& place, const FlatScene& scene, const CameraView& camera,
                           const TraceOptions& options, Followers& followers, json& rows,
                           Ratios& ratios) {
  std::optional<EmbreePair> embree;
  SINEW_TRY(const Bvh ours, time_trees(place, scene, followers, embree, options, rows, ratios));
  const Workload work = workload_of(scene, camera, ours, options);
  std::vector<Hit> hits(work.primary.size()), embree_hits(hits.size());
  trace_closest(our_calls(ours, TriangleTest::robust)[0], work.primary, hits);
  trace_closest(embree_calls(embree->robust)[0], work.primary, embree_hits);
  rows.back()["primary_hits_differ"] = differing(hits, embree_hits);
  time_tree(place, ours, *embree, work, options.repeats, rows, ratios);
  Place refit = place;
  refit.tree = "refit";
  time_tree(refit, followers.ours, followers.embree, work, options.repeats, rows, ratios);
  return {};
}

CameraView choose_camera(const Scene& scene, const ScenePose& pose, int clip,
                         const TraceOptions& options) {
  if (!scene.cameras.empty()) return scene_camera(scene, pose, 0);
  const float aspect = float(options.width) / float(options.height);
  return frame_box(animation_bounds(scene, clip, 8), vec3(0.5f, 0.35f, 1.0f), 0.8f, aspect);
}

Result<void> measure_scene(const std::string& name, const TraceOptions& options, json& rows,
                           Ratios& ratios) {
  SINEW_TRY(const Scene scene, load(name));
  SINEW_TRY(const int clip, find_clip(scene, options.clip));
  const double start = clip == kRestPose ? 0.0 : scene.clips[clip].start;
  const double end = clip == kRestPose ? 0.0 : scene.clips[clip].end;
  ScenePose pose;
  FlatScene flat;
  sample(scene, clip, start, pose);
  flatten(scene, pose, flat);
  SINEW_TRY(Bvh ours, build(flat.positions, flat.triangles));
  ours.set_update_mode(UpdateMode::full);
  Followers followers{std::move(ours), EmbreePair(flat, EmbreeMode::refit)};
  for (uint32_t f = 0; f < options.frames; ++f) {
    const double time = start + (end - start) * (f + 0.5) / options.frames;
    sample(scene, clip, time, pose);
    flatten(scene, pose, flat);
    SINEW_CHECKED(measure_frame({.scene = name, .time = time}, flat,
                                choose_camera(scene, pose, clip, options), options, followers, rows,
                                ratios));
  }
  return {};
}

void add_ratio(json& figures, const char* name, const std::vector<double>& ratios,
               const std::string& note) {
  if (ratios.empty()) return;
  figures.push_back(figure(name, geometric_mean(ratios),
                           note + "; geometric mean of " + std::to_string(ratios.size())));
}

}  // namespace

Result<json> bench_trace(const TraceOptions& options) {
  const ThreadLimit limit(options.threads);
  json rows = json::array(), figures = json::array();
  Ratios ratios;
  for (const std::string& scene : options.scenes) {
    SINEW_CHECKED(measure_scene(scene, options, rows, ratios));
  }
  add_ratio(figures, "single_ray_robust", ratios.single_robust,
            "rays a second over Embree's with ROBUST, one ray a call, same static scene");
  add_ratio(figures, "single_ray_fast", ratios.single_fast,
            "the same without watertightness, over Embree's without ROBUST");
  add_ratio(figures, "packet_speed", ratios.packets_robust,
            "primary rays, watertight, best call of each");
  add_ratio(figures, "packet_speed_fast", ratios.packets_fast,
            "the same without watertightness for both");
  add_ratio(figures, "refit_ratio", ratios.refit, "time of a full update over Embree's refit");
  json report = report_head("trace");
  report["scenes"] = options.scenes;
  report["figures"] = std::move(figures);
  report["rows"] = std::move(rows);
  return report;
}

}  // namespace sinew::bench
