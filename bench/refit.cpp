// A full update alone, positions ready in everybody's buffers, and the bytes that it keeps.
#include <fmt/format.h>

#include <array>

#include "bench/picks.h"
#include "bench/workload.h"
#include "sinew/bvh/bvh.h"
#include "sinew/bvh/update/update.h"
#include "sinew/motion/clusters.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kPoses = 4;

// Embree's scene with one geometry an object, the objects' vertices in a row.
void add_parts(const Scene& scene, std::span<const vec3> positions, EmbreeScene& out) {
  size_t first = 0;
  for (const SceneObject& object : scene.objects) {
    const Mesh& mesh = scene.meshes[object.mesh];
    out.add_mesh(positions.subspan(first, mesh.positions.size()), mesh.triangles,
                 EmbreeMotion::deforms);
    first += mesh.positions.size();
  }
  out.commit();
}

void move_parts(const Scene& scene, std::span<const vec3> positions, EmbreeScene& out) {
  size_t first = 0;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const std::span<vec3> part = out.vertices(i);
    std::ranges::copy(positions.subspan(first, part.size()), part.begin());
    first += part.size();
  }
}

// What a World keeps of a body so that boxes follow from its poses.
size_t cluster_bytes(const Motion& motion, const Bvh8Layout& layout) {
  if (!derivable(motion)) return 0;
  std::vector<uint32_t> first;
  for (const Treelet& treelet : layout.treelets) first.push_back(treelet.first_vertex);
  first.push_back(static_cast<uint32_t>(layout.vertices.size()));
  return make_cluster_bounds(motion, {first, layout.vertices}).bytes();
}

}  // namespace

Result<void> measure_refit(const Scene& scene, const UpdateOptions& options, UpdateReport& report) {
  Arena arena;
  SINEW_CHECKED(arena.open(scene, options.bodies));
  FlatScene flat;
  std::array<std::vector<vec3>, kPoses> poses;
  for (uint32_t i = 0; i < kPoses; ++i) {
    flatten(scene, arena.pose_at(arena.time_of(8 * i)), flat);
    poses[i] = flat.positions;
  }
  SINEW_TRY(Bvh ours, build(flat.positions, flat.triangles));
  ours.set_update_mode(UpdateMode::full);
  EmbreeScene one(flat.positions, flat.triangles, EmbreeMode::refit);
  EmbreeScene parts({.mode = EmbreeMode::refit});
  add_parts(scene, flat.positions, parts);
  std::vector<Rival> rivals = {
      {"sinew full", [&](uint32_t frame) { (void)ours.update_borrowed(poses[frame % kPoses]); }},
      {"embree refit, one mesh", [&](uint32_t) { one.commit(); }},
      {"embree refit, a mesh an object", [&](uint32_t) { parts.commit(); }}};
  compete(rivals, {2, 2 * options.repeats}, 0, [&](uint32_t frame) {
    std::ranges::copy(poses[frame % kPoses], one.vertices().begin());
    move_parts(scene, poses[frame % kPoses], parts);
  });
  const Rival* const theirs = best_of(rivals, "embree");
  for (const Rival& rival : rivals) {
    report.rows.push_back({{"table", "refit"},
                           {"scene", options.bodies},
                           {"triangles", flat.triangles.size()},
                           {"method", rival.name},
                           {"ms", rival.median_ms()}});
  }
  report.figures.push_back(
      figure("refit_bodies", rivals[0].median_ms() / theirs->median_ms(),
             fmt::format("full update, {:.2f} ms, over {}, {:.2f} ms", rivals[0].median_ms(),
                         theirs->name, theirs->median_ms())));
  return {};
}

Result<void> measure_bytes(const Scene& scene, UpdateReport& report) {
  size_t layouts = 0, poses = 0, clusters = 0, triangles = 0;
  ScenePose pose;
  sample(scene, scene.clips.empty() ? kRestPose : 0, 0.0, pose);
  EmbreeScene refit({.mode = EmbreeMode::refit}), medium({.mode = EmbreeMode::medium});
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const Mesh& mesh = scene.meshes[object.mesh];
    std::vector<vec3> at(mesh.positions.size());
    world_positions(scene, pose, i, at);
    SINEW_TRY(const Bvh8Layout layout, build_layout(at, mesh.triangles, {}));
    Bvh8 bvh;
    update_full(layout, at, bvh);
    layouts += bytes_of(layout);
    poses += bytes_of(bvh);
    clusters += cluster_bytes(motion_of(mesh, object.skin >= 0), layout);
    triangles += mesh.triangles.size();
    for (EmbreeScene* const embree : {&refit, &medium}) {
      embree->add_mesh(at, mesh.triangles, EmbreeMotion::deforms);
    }
  }
  refit.commit();
  medium.commit();
  const auto a_triangle = [&](size_t bytes) { return double(bytes) / double(triangles); };
  report.rows.push_back({{"table", "bytes"},
                         {"scene", scene.name},
                         {"layout", a_triangle(layouts)},
                         {"pose", a_triangle(poses)},
                         {"derived_bounds", a_triangle(clusters)},
                         {"embree_refit", a_triangle(refit.bytes())},
                         {"embree_medium", a_triangle(medium.bytes())}});
  report.figures.push_back(figure(
      "bytes_per_triangle", a_triangle(layouts + poses + clusters),
      fmt::format("boxes and triangles {:.1f}, layout {:.1f}, derived bounds {:.1f}; Embree refit "
                  "{:.1f}, medium {:.1f}",
                  a_triangle(poses), a_triangle(layouts), a_triangle(clusters),
                  a_triangle(refit.bytes()), a_triangle(medium.bytes()))));
  return {};
}

}  // namespace sinew::bench
