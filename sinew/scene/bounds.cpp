// World positions of objects, and the box of a whole animation.
#include <algorithm>
#include <array>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/voxel_bounds.h"

namespace sinew {
namespace {

constexpr size_t kChunk = 1024;  // vertices moved at a time

void world_positions(const Motion& motion, const Pose& pose, size_t first, std::span<vec3> out) {
  positions(motion, pose, static_cast<uint32_t>(first), out);
  for (vec3& p : out) p = transform_point(pose.placement, p);
}

// A chunk of an object's vertices.
struct Chunk {
  uint32_t object;
  size_t first;
  size_t count;
};

std::vector<Chunk> chunks_of(std::span<const Motion> motions) {
  std::vector<Chunk> chunks;
  for (uint32_t object = 0; object < motions.size(); ++object) {
    const size_t vertices = vertex_count(motions[object]);
    for (size_t first = 0; first < vertices; first += kChunk) {
      chunks.push_back({object, first, std::min(kChunk, vertices - first)});
    }
  }
  return chunks;
}

Box box_of(const Motion& motion, const Pose& pose, const Chunk& chunk) {
  std::array<vec3, kChunk> storage;
  const std::span<vec3> points = std::span(storage).first(chunk.count);
  world_positions(motion, pose, chunk.first, points);
  Box box;
  for (const vec3 p : points) box.extend(p);
  return box;
}

}  // namespace

void world_positions(const Scene& scene, const ScenePose& pose, uint32_t object,
                     std::span<vec3> out) {
  const SceneObject& what = scene.objects[object];
  const Motion motion = motion_of(scene.meshes[what.mesh], what.skin >= 0);
  SINEW_CHECK(out.size() == vertex_count(motion));
  parallel_for(out.size(), kChunk, [&](size_t begin, size_t end) {
    world_positions(motion, pose.objects[object], begin, out.subspan(begin, end - begin));
  });
}

Box animation_bounds(const Scene& scene, int clip, int samples) {
  SINEW_CHECK(samples >= 1);
  std::vector<Motion> motions;
  for (const SceneObject& object : scene.objects) {
    motions.push_back(motion_of(scene.meshes[object.mesh], object.skin >= 0));
  }
  const std::vector<Chunk> chunks = chunks_of(motions);
  std::vector<Box> boxes(chunks.size());
  VoxelBounds voxels(scene);
  ScenePose pose;
  Box all;
  for (int i = 0; i < samples; ++i) {
    double time = 0.0;
    if (clip != kRestPose) {
      const double u = samples == 1 ? 0.0 : double(i) / (samples - 1);
      time = (1.0 - u) * scene.clips[clip].start + u * scene.clips[clip].end;
    }
    sample(scene, clip, time, pose);
    parallel_for(chunks.size(), 1, [&](size_t begin, size_t end) {
      for (size_t c = begin; c < end; ++c) {
        const Pose& object = pose.objects[chunks[c].object];
        boxes[c] = object.present ? box_of(motions[chunks[c].object], object, chunks[c]) : Box{};
      }
    });
    for (const Box& box : boxes) all.extend(box);
    all.extend(voxels.at(pose));
    if (clip == kRestPose) break;
  }
  return all;
}

}  // namespace sinew
