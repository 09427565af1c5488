#include "bench/bounds.h"

#include <algorithm>
#include <map>
#include <optional>

#include "bench/measure.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/wide.h"
#include "sinew/io/load.h"
#include "sinew/motion/clusters.h"
#include "sinew/scene/sample.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

// A mesh cut into treelets, with their bounds.
struct Body {
  Motion motion;
  uint32_t triangles = 0;
  std::vector<uint32_t> first, vertices;  // of each treelet; see ClusterVertices
  ClusterBounds bounds;
  Tree upper;  // over the treelets
  double make_ms = 0.0;

  uint32_t clusters() const { return bounds.clusters; }
  std::span<const uint32_t> cluster(uint32_t c) const {
    return std::span(vertices).subspan(first[c], first[c + 1] - first[c]);
  }
};

void exact_boxes(const Body& body, const Pose& pose, std::span<Box> out) {
  for (uint32_t c = 0; c < out.size(); ++c) out[c] = bounds(body.motion, pose, body.cluster(c));
}

Result<Body> make_body(const Mesh& mesh, bool skinned, const Pose& pose, uint32_t most_pieces) {
  Body body;
  body.motion = motion_of(mesh, skinned);
  body.triangles = static_cast<uint32_t>(mesh.triangles.size());
  std::vector<vec3> at(vertex_count(body.motion));
  positions(body.motion, pose, 0, at);
  SINEW_TRY(const Bvh8Layout layout, build_layout(at, mesh.triangles, {}));
  for (const Treelet& treelet : layout.treelets) body.first.push_back(treelet.first_vertex);
  body.first.push_back(static_cast<uint32_t>(layout.vertices.size()));
  body.vertices = layout.vertices;
  body.make_ms = milliseconds([&] {
    body.bounds =
        make_cluster_bounds(body.motion, {body.first, body.vertices}, {.most_pieces = most_pieces});
  });
  std::vector<Box> boxes(body.clusters());
  exact_boxes(body, pose, boxes);
  body.upper = build_binned(boxes, {.max_leaf = 1});
  return body;
}

double area_sum(std::span<const Box> boxes) {
  double sum = 0.0;
  for (const Box& box : boxes) sum += half_area(box);
  return sum;
}

// Sums over bodies and frames.
struct Totals {
  double derived_area = 0.0, exact_area = 0.0;
  double derived_upper = 0.0, exact_upper = 0.0;  // of all nodes of the trees over the clusters
  double derived_body = 0.0, exact_body = 0.0;
  double derive_ms = 0.0, exact_ms = 0.0, positions_ms = 0.0, body_ms = 0.0;
  uint64_t clusters = 0, bodies = 0, escaped = 0;
};

// Interleaved repeats, so that noise hits all.
void time_body(const Body& body, const Pose& pose, uint32_t repeats, std::span<Box> boxes,
               Totals& totals) {
  std::vector<vec3> moved(body.vertices.size());
  std::vector<double> derive, exact, move, whole;
  Box sink;
  for (uint32_t r = 0; r < repeats; ++r) {
    exact.push_back(milliseconds([&] { exact_boxes(body, pose, boxes); }));
    move.push_back(milliseconds([&] {
      for (uint32_t c = 0; c < body.clusters(); ++c) {
        const std::span<const uint32_t> list = body.cluster(c);
        positions(body.motion, pose, list, std::span(moved).first(list.size()));
      }
    }));
    derive.push_back(
        milliseconds([&] { derive_bounds(body.bounds, body.motion, pose, 0, boxes); }));
    whole.push_back(
        milliseconds([&] { sink.extend(derive_body_bounds(body.bounds, body.motion, pose)); }));
  }
  totals.derive_ms += median(derive);
  totals.exact_ms += median(exact);
  totals.positions_ms += median(move);
  totals.body_ms += median(whole) + (sink.empty() ? 1e-12 : 0.0);
}

void measure(const Body& body, const Pose& pose, uint32_t repeats, Totals& totals) {
  const uint32_t clusters = body.clusters();
  std::vector<Box> derived(clusters), exact(clusters);
  exact_boxes(body, pose, exact);
  time_body(body, pose, repeats, derived, totals);
  Box whole;
  for (uint32_t c = 0; c < clusters; ++c) {
    totals.escaped += !derived[c].contains(exact[c]);
    whole.extend(exact[c]);
  }
  const Box derived_whole = derive_body_bounds(body.bounds, body.motion, pose);
  totals.escaped += !derived_whole.contains(whole);
  totals.derived_body += half_area(derived_whole);
  totals.exact_body += half_area(whole);
  totals.derived_area += area_sum(derived);
  totals.exact_area += area_sum(exact);
  totals.derived_upper += area_sum(refit(body.upper, derived));
  totals.exact_upper += area_sum(refit(body.upper, exact));
  totals.clusters += clusters;
  ++totals.bodies;
}

// Bodies by mesh and whether it is skinned.
using Bodies = std::map<std::pair<uint32_t, bool>, Body>;

Result<Bodies> make_bodies(const Scene& scene, const ScenePose& pose,
                           const BoundsOptions& options) {
  Bodies bodies;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const std::pair key(object.mesh, object.skin >= 0);
    const Mesh& mesh = scene.meshes[object.mesh];
    const Motion motion = motion_of(mesh, key.second);
    if (!deforms(motion) || !derivable(motion) || bodies.count(key) || !pose.objects[i].present ||
        std::ranges::count(options.skip, scene.nodes[object.node].name) > 0) {
      continue;
    }
    SINEW_TRY(Body body, make_body(mesh, key.second, pose.objects[i], options.most_pieces));
    bodies.emplace(key, std::move(body));
  }
  return bodies;
}

nlohmann::json row_of(const std::string& name, const Bodies& bodies, const Totals& t) {
  double triangles = 0.0, bytes = 0.0, clusters = 0.0, vertices = 0.0, pieces = 0.0, make_ms = 0.0;
  for (const auto& [key, body] : bodies) {
    triangles += body.triangles;
    bytes += double(body.bounds.bytes());
    clusters += body.clusters();
    vertices += double(body.vertices.size());
    const std::vector<uint32_t>& first_piece = body.bounds.first_piece;  // none: a box a cluster
    pieces += first_piece.empty() ? body.clusters() : first_piece[body.clusters()];
    make_ms += body.make_ms;
  }
  const double to_ns = 1e6 / double(t.clusters);
  return {{"scene", name},
          {"triangles", triangles},
          {"clusters", clusters},
          {"triangles_per_cluster", triangles / clusters},
          {"vertices_per_cluster", vertices / clusters},
          {"pieces_per_cluster", pieces / clusters},
          {"area_ratio", t.derived_area / t.exact_area},
          {"upper_sah_ratio", t.derived_upper / t.exact_upper},
          {"body_area_ratio", t.derived_body / t.exact_body},
          {"escaped", t.escaped},
          {"derive_ns", t.derive_ms * to_ns},
          {"exact_ns", t.exact_ms * to_ns},
          {"positions_ns", t.positions_ms * to_ns},
          {"body_us", t.body_ms * 1e3 / double(t.bodies)},
          {"bytes_per_triangle", bytes / triangles},
          {"make_ms", make_ms}};
}

Result<nlohmann::json> bench_scene(const std::string& name, const BoundsOptions& options) {
  SINEW_TRY(const Scene scene, load(name));
  SINEW_TRY(const int clip, find_clip(scene, options.clip));
  const double start = clip == kRestPose ? 0.0 : scene.clips[clip].start;
  const double end = clip == kRestPose ? 0.0 : scene.clips[clip].end;
  ScenePose pose;
  sample(scene, clip, 0.5 * (start + end), pose);
  SINEW_TRY(const Bodies bodies, make_bodies(scene, pose, options));
  Totals totals;
  for (uint32_t f = 0; f < options.frames; ++f) {
    sample(scene, clip, start + (end - start) * (f + 0.5) / options.frames, pose);
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      const auto found = bodies.find({scene.objects[i].mesh, scene.objects[i].skin >= 0});
      if (found == bodies.end() || !pose.objects[i].present) continue;
      measure(found->second, pose.objects[i], options.repeats, totals);
    }
  }
  if (totals.clusters == 0) {
    return fail({ErrorKind::bad_input, name, "", "nothing in it deforms by a pose",
                 "choose a scene with skins, morph targets or a vertex cache"});
  }
  return row_of(name, bodies, totals);
}

}  // namespace

Result<nlohmann::json> bench_bounds(const BoundsOptions& options) {
  const ThreadLimit limit(1);
  nlohmann::json rows = nlohmann::json::array();
  std::vector<double> area, upper, cost;
  for (const std::string& scene : options.scenes) {
    SINEW_TRY(nlohmann::json row, bench_scene(scene, options));
    area.push_back(row["area_ratio"]);
    upper.push_back(row["upper_sah_ratio"]);
    cost.push_back(double(row["derive_ns"]) / double(row["positions_ns"]));
    rows.push_back(std::move(row));
  }
  return nlohmann::json{
      {"bench", "bounds"},
      {"version", SINEW_VERSION},
      {"machine", {{"threads", thread_count()}}},
      {"opponents", {"exact boxes from moved vertices"}},
      {"figures",
       {figure("bounds_area_ratio", geometric_mean(area), "1", "less",
               "surface area of derived boxes of clusters over that of exact ones"),
        figure("bounds_upper_sah_ratio", geometric_mean(upper), "1", "less",
               "area of all nodes above the clusters, from derived boxes over from exact ones"),
        figure("bounds_cost_ratio", geometric_mean(cost), "1", "less",
               "time to derive a cluster's box over that to move its vertices")}},
      {"rows", std::move(rows)}};
}

}  // namespace sinew::bench
