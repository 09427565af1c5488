#include "io/round_trip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/io/load.h"
#include "sinew/io/save.h"
#include "sinew/scene/sample.h"

namespace sinew::test {
namespace {

// Objects depth first, which is how the nodes of a file are read.
std::vector<uint32_t> depth_first(const Scene& scene) {
  std::vector<std::vector<uint32_t>> children(scene.nodes.size());
  std::vector<uint32_t> stack, result;
  for (uint32_t i = static_cast<uint32_t>(scene.nodes.size()); i-- > 0;) {
    const int32_t parent = scene.nodes[i].parent;
    (parent < 0 ? stack : children[static_cast<size_t>(parent)]).push_back(i);
  }
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    const auto object = std::ranges::find(scene.objects, node, &SceneObject::node);
    if (object != scene.objects.end() && !scene.meshes[object->mesh].triangles.empty()) {
      result.push_back(static_cast<uint32_t>(object - scene.objects.begin()));
    }
    stack.insert(stack.end(), children[node].begin(), children[node].end());
  }
  return result;
}

// World positions of the corners of all triangles, part by part.
std::vector<vec3> corners(const Scene& scene, const ScenePose& pose, uint32_t object) {
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  std::vector<vec3> points(mesh.positions.size()), result;
  world_positions(scene, pose, object, points);
  for (uint32_t part = 0; part < mesh.parts.size(); ++part) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (mesh.triangle_part[t] != part) continue;
      for (int k = 0; k < 3; ++k) result.push_back(points[mesh.triangles[t][k]]);
    }
  }
  return result;
}

// For each triangle in the same order: what its part is.
std::vector<std::string> surfaces(const Scene& scene, uint32_t object) {
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  std::vector<size_t> triangles(mesh.parts.size(), 0);
  for (const uint32_t part : mesh.triangle_part) ++triangles[part];
  std::vector<std::string> result;
  for (size_t part = 0; part < mesh.parts.size(); ++part) {
    if (triangles[part] == 0) continue;
    result.push_back(std::to_string(mesh.parts[part].material) +
                     (mesh.parts[part].flat ? " flat " : " smooth ") +
                     std::to_string(triangles[part]));
  }
  return result;
}

struct Comparison {
  const Scene& before;
  const Scene& after;
  std::vector<uint32_t> order_before, order_after;

  // The largest distance over the size of what is seen.
  double error(int clip_before, double time_before, int clip_after, double time_after) const {
    ScenePose pose_before, pose_after;
    sample(before, clip_before, time_before, pose_before);
    sample(after, clip_after, time_after, pose_after);
    double error = 0.0, size = 1e-30;
    for (size_t i = 0; i < order_before.size(); ++i) {
      const bool present = pose_before.objects[order_before[i]].present;
      EXPECT_EQ(present, pose_after.objects[order_after[i]].present) << "object " << i;
      if (!present) continue;
      const std::vector<vec3> a = corners(before, pose_before, order_before[i]);
      const std::vector<vec3> b = corners(after, pose_after, order_after[i]);
      EXPECT_EQ(a.size(), b.size());
      for (size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
        error = std::max(error, double{length(a[k] - b[k])});
        size = std::max(size, double{length(a[k])});
      }
    }
    return error / size;
  }
};

// Times at which vertex programs are sampled too: whole frames.
std::vector<double> times_of(const Scene& scene, const Clip& clip) {
  const double fps = scene.default_fps > 0.0 ? scene.default_fps : 24.0;
  double first = clip.start;
  for (const Clip& other : scene.clips) first = std::min(first, other.start);
  std::vector<double> times;
  for (const double u : {0.0, 0.137, 0.5, 0.831, 1.0}) {
    double time = glm::mix(clip.start, clip.end, u);
    const bool programs = std::ranges::any_of(
        scene.meshes, [](const Mesh& mesh) { return static_cast<bool>(mesh.vertex_program); });
    if (programs) time = first + std::floor((time - first) * fps + 1e-6) / fps;
    times.push_back(std::max(time, clip.start));
  }
  return times;
}

}  // namespace

Scene save_and_load(const Scene& scene, const TemporaryFolder& folder, const std::string& name) {
  const std::string path = folder.path(name);
  const Result<SaveReport> report = save_gltf(scene, path);
  if (!report) {
    ADD_FAILURE() << report.error().message();
    return {};
  }
  for (const SavedFile& file : report->files) {
    EXPECT_EQ(std::filesystem::file_size(file.path), file.bytes) << file.path;
  }
  EXPECT_EQ(report->files.size(), folder.file_count());
  EXPECT_EQ(report->triangles, count(scene).triangles);
  Result<Scene> loaded = load(path);
  if (!loaded) {
    ADD_FAILURE() << loaded.error().message();
    return {};
  }
  EXPECT_EQ(report->clips, loaded->clips.size());
  return std::move(*loaded);
}

void expect_same_motion(const Scene& before, const Scene& after, double tolerance) {
  EXPECT_EQ(count(before).triangles, count(after).triangles);
  const Comparison compare{before, after, depth_first(before), depth_first(after)};
  ASSERT_EQ(compare.order_before.size(), compare.order_after.size());
  for (size_t i = 0; i < compare.order_before.size(); ++i) {
    EXPECT_EQ(surfaces(before, compare.order_before[i]), surfaces(after, compare.order_after[i]));
  }
  const bool cached = std::ranges::any_of(
      before.meshes, [](const Mesh& mesh) { return mesh.keys > 0 || mesh.vertex_program; });
  if (!cached) {  // those begin with their first sample
    EXPECT_LE(compare.error(kRestPose, 0.0, kRestPose, 0.0), tolerance) << "at rest";
  }
  for (size_t clip = 0; clip < before.clips.size(); ++clip) {
    const Clip& own = before.clips[clip];
    const auto same = std::ranges::find(after.clips, own.name, &Clip::name);
    if (same == after.clips.end()) {  // only what moves nothing may go
      EXPECT_TRUE(own.channels.empty() && own.start == own.end) << own.name;
      continue;
    }
    // Clips that begin before 0 are moved.
    EXPECT_NEAR(own.end - own.start, same->end - same->start, 1e-6 * (1.0 + own.end));
    const double shift = same->start - own.start;
    for (const double time : times_of(before, own)) {
      EXPECT_LE(compare.error(static_cast<int>(clip), time,
                              static_cast<int>(same - after.clips.begin()), time + shift),
                tolerance)
          << own.name << " at " << time << " s";
    }
  }
}

}  // namespace sinew::test
