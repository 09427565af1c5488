#include "bench/picks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "bench/frame_work.h"
#include "bench/workload.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/bvh.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr std::array<uint32_t, 6> kCounts = {10, 100, 1000, 10000, 100000, 1000000};
constexpr uint32_t kFewPicks = 10000, kManyPicks = 1000000;
constexpr uint32_t kPoses = 4;  // of free motion, kept ready

// The figure that a number of picks gives; nullptr if it gives none.
const char* figure_of(uint32_t picks) {
  return picks == 100 ? "picks_100" : picks == 10000 ? "picks_10000" : nullptr;
}

bool wants_count(const UpdateOptions& options, uint32_t picks) {
  const char* const name = figure_of(picks);
  const bool sweeps = wants(options, "ray_count_sweep") || wants(options, "auto_regret");
  return (sweeps && picks <= options.most_rays) || (name != nullptr && wants(options, name));
}

// Warming up lets `auto` see what rays reach. Frames of a few milliseconds are noisy: they get more
// rounds. A million rays take a second: fewer are enough.
Rounds rounds_of(uint32_t picks, uint32_t repeats) {
  if (picks >= kManyPicks) return {2, std::min(repeats, 3u)};
  return {4, picks <= kFewPicks ? 5 * repeats : repeats};
}

std::vector<Rival> rivals_of(const Arena& arena, std::span<const Ray> rays, std::span<Hit> hits) {
  std::vector<Rival> rivals;
  for (const Engine& engine : arena.engines()) {
    rivals.push_back({engine.name, [&arena, &engine, rays, hits](uint32_t frame) {
                        engine.pose(arena.time_of(frame));
                        engine.closest(rays, hits);
                      }});
  }
  return rivals;
}

// The same picks where the vertices of every frame are ready: nobody skins.
Result<void> measure_free(const Arena& arena, std::span<const Box> boxes, uint32_t picks,
                          const UpdateOptions& options, UpdateReport& report) {
  const Scene& scene = arena.scene();
  FlatScene flat;
  std::array<std::vector<vec3>, kPoses> poses;
  ScenePose pose;
  for (uint32_t i = 0; i < kPoses; ++i) {
    sample(scene, arena.clip(), arena.time_of(i), pose);
    flatten(scene, pose, flat);
    poses[i] = flat.positions;
  }
  SINEW_TRY(Bvh ours, build(flat.positions, flat.triangles));
  EmbreeScene embree(flat.positions, flat.triangles, EmbreeMode::refit);
  std::vector<Ray> rays(picks);
  std::vector<Hit> hits(picks);
  const auto pick = [&](const auto& engine) {
    parallel_for(rays.size(), 1024, [&](size_t begin, size_t end) {
      engine.closest_hits(std::span(rays).subspan(begin, end - begin),
                          std::span(hits).subspan(begin, end - begin));
    });
  };
  std::vector<Rival> rivals = {{"sinew",
                                [&](uint32_t frame) {
                                  (void)ours.update_borrowed(poses[frame % kPoses]);
                                  pick(ours);
                                }},
                               {"embree", [&](uint32_t) {
                                  embree.commit();
                                  pick(embree);
                                }}};
  compete(rivals, {2, options.repeats}, 0, [&](uint32_t frame) {
    pick_rays(boxes, frame, rays);
    std::ranges::copy(poses[frame % kPoses], embree.vertices().begin());
  });
  report.rows.push_back({{"table", "free_motion"},
                         {"scene", arena.name()},
                         {"rays", picks},
                         {"sinew_ms", rivals[0].median_ms()},
                         {"embree_ms", rivals[1].median_ms()},
                         {"ratio", rivals[1].median_ms() / rivals[0].median_ms()}});
  return {};
}

void add_figure(uint32_t picks, std::span<const Rival> rivals, const UpdateOptions& options,
                UpdateReport& report) {
  const char* const name = figure_of(picks);
  if (name == nullptr || !wants(options, name)) return;
  const Rival* const ours = find(rivals, "sinew auto");
  const Rival* const theirs = best_of(rivals, "embree");
  report.figures.push_back(
      figure(name, theirs->median_ms() / ours->median_ms(),
             fmt::format("{} picks, pose in, hits out: {:.2f} ms, {} {:.2f} ms", picks,
                         ours->median_ms(), theirs->name, theirs->median_ms())));
}

}  // namespace

Result<void> measure_picks(const Scene& scene, const UpdateOptions& options, UpdateReport& report) {
  Arena arena;
  SINEW_CHECKED(arena.open(scene, options.bodies));
  for (const UpdateMode mode :
       {UpdateMode::automatic, UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
    SINEW_CHECKED(arena.add_ours(mode));
  }
  arena.add_embree(EmbreeMode::refit);
  arena.add_embree(EmbreeMode::low);
  const std::vector<Box> boxes = object_boxes(arena.scene(), arena.pose_at(arena.time_of(0)));
  uint32_t frame = 0;
  for (const uint32_t count : kCounts) {
    if (!wants_count(options, count)) continue;
    std::vector<Ray> rays(count);
    std::vector<Hit> hits(count);
    std::vector<Rival> rivals = rivals_of(arena, rays, hits);
    frame = compete(rivals, rounds_of(count, options.repeats), frame,
                    [&](uint32_t f) { pick_rays(boxes, f, rays); });
    add_sweep_point(report, "ray_count", arena.name(), count, rivals);
    add_figure(count, rivals, options, report);
    if (figure_of(count) != nullptr) {
      SINEW_CHECKED(measure_free(arena, boxes, count, options, report));
    }
  }
  return {};
}

}  // namespace sinew::bench
