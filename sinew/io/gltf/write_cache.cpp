#include "sinew/io/gltf/write_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/io/vertex_cache.h"

namespace sinew::gltf {
namespace {

// The times that vertex programs are sampled for.
struct Timeline {
  double start = 0.0;
  double end = 0.0;
  double fps = kCacheFps;
};

Timeline timeline_of(const Scene& scene, const SaveOptions& options) {
  Timeline result;
  if (scene.default_fps > 0.0) result.fps = scene.default_fps;
  if (options.fps > 0.0) result.fps = options.fps;
  if (scene.clips.empty()) {
    result.end = std::max(0, scene.default_frames - 1) / result.fps;
    return result;
  }
  result.start = std::numeric_limits<double>::max();
  result.end = std::numeric_limits<double>::lowest();
  for (const Clip& clip : scene.clips) {
    result.start = std::min(result.start, clip.start);
    result.end = std::max(result.end, clip.end);
  }
  return result;
}

// How fast the first clip that plays the mesh's keys does, in keys a second.
double rate_of_keys(const Scene& scene, uint32_t mesh) {
  for (const Clip& clip : scene.clips) {
    for (const Channel& channel : clip.channels) {
      const bool plays = channel.path == ChannelPath::cache_key &&
                         scene.nodes[channel.node].mesh == static_cast<int32_t>(mesh) &&
                         channel.interpolation == Interpolation::linear;
      if (!plays || channel.times.size() < 2) continue;
      const double rate = (double{channel.values.back()} - double{channel.values.front()}) /
                          (double{channel.times.back()} - double{channel.times.front()});
      if (rate > 0.0) return rate;
    }
  }
  return scene.default_fps > 0.0 ? scene.default_fps : kCacheFps;
}

Result<uint32_t> program_keys(const Scene& scene, const Timeline& timeline) {
  // A thousandth of a frame forgives lengths that floating point made a little too long.
  const double last = std::ceil((timeline.end - timeline.start) * timeline.fps - 1e-3);
  if (!(last < std::numeric_limits<int32_t>::max())) {
    return fail({ErrorKind::usage, scene.name, "",
                 fmt::format("its vertex programs would need {:.0f} samples", last),
                 "choose fewer frames a second"});
  }
  return static_cast<uint32_t>(std::max(last, 0.0)) + 1;
}

// Plays the program's samples from the clip's start to its end.
Channel program_channel(uint32_t node, const Clip& clip, const MeshCache& cache) {
  Channel channel;
  channel.node = node;
  channel.path = ChannelPath::cache_key;
  channel.width = 1;
  for (const double time : {clip.start, clip.end}) {
    const float rounded = static_cast<float>(time);
    if (!channel.times.empty() && rounded <= channel.times.back()) continue;
    channel.times.push_back(rounded);
    channel.values.push_back(static_cast<float>((double{rounded} - cache.start) * cache.fps));
  }
  return channel;
}

}  // namespace

Result<std::vector<MeshCache>> plan_caches(const Scene& scene, const std::string& stem,
                                           const SaveOptions& options) {
  const Timeline timeline = timeline_of(scene, options);
  std::vector<MeshCache> result(scene.meshes.size());
  uint32_t files = 0;
  for (const SceneObject& object : scene.objects) {
    const Mesh& mesh = scene.meshes[object.mesh];
    MeshCache& cache = result[object.mesh];
    if (cache.keys > 0 || mesh.triangles.empty()) continue;
    if (mesh.vertex_program) {
      SINEW_TRY(cache.keys, program_keys(scene, timeline));
      cache.program = true;
      cache.start = timeline.start;
      cache.fps = timeline.fps;
    } else if (mesh.keys > 0) {
      cache.keys = mesh.keys;
      cache.fps = rate_of_keys(scene, object.mesh);
    } else {
      continue;
    }
    ++files;
    cache.file_name =
        files == 1 ? stem + "_cache.pc2" : fmt::format("{}_cache_{}.pc2", stem, files);
  }
  return result;
}

std::vector<Clip> clips_with_caches(const Scene& scene, const std::vector<MeshCache>& caches) {
  std::vector<Clip> clips = scene.clips;
  const auto program = std::find_if(caches.begin(), caches.end(),
                                    [](const MeshCache& cache) { return cache.program; });
  if (program == caches.end()) return clips;
  if (clips.empty()) {
    clips.push_back({"cache", 0.0, (program->keys - 1) / program->fps, {}});
  }
  for (Clip& clip : clips) {
    for (const SceneObject& object : scene.objects) {
      const MeshCache& cache = caches[object.mesh];
      if (cache.program) clip.channels.push_back(program_channel(object.node, clip, cache));
    }
  }
  return clips;
}

Result<void> write_cache(const Mesh& mesh, const MeshCache& cache, const MeshVertices& vertices,
                         OutputFile& out) {
  SINEW_CHECKED(write_pc2_header(vertices.count(), cache.keys, out));
  std::vector<vec3> positions(mesh.positions.size()), ordered(vertices.count());
  for (uint32_t key = 0; key < cache.keys; ++key) {
    std::span<const vec3> sample = positions;
    if (cache.program) {
      mesh.vertex_program(cache.start + key / cache.fps, positions);
    } else {
      sample = std::span(mesh.key_positions).subspan(key * positions.size(), positions.size());
    }
    size_t next = 0;
    for (const VertexSet& set : vertices.sets) {
      for (uint32_t v = 0; v < set.count; ++v) ordered[next++] = sample[set.point(v)];
    }
    SINEW_CHECKED(out.write(
        {reinterpret_cast<const uint8_t*>(ordered.data()), ordered.size() * sizeof(vec3)}));
  }
  return {};
}

}  // namespace sinew::gltf
