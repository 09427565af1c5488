#include "sinew/io/vertex_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/io/obj/obj.h"

namespace sinew {
namespace {

static_assert(std::endian::native == std::endian::little, "PC2 is read as it lies in memory");

constexpr char kMagic[12] = "POINTCACHE2";
constexpr size_t kHeaderBytes = 32;
constexpr float kLongest = 1e7f;  // seconds

template <class T>
T value_at(const std::string& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

tl::unexpected<Error> cache_error(const std::string& path, std::string element, std::string problem,
                                  std::string remedy = "export the cache again") {
  return fail(
      {ErrorKind::bad_input, path, std::move(element), std::move(problem), std::move(remedy)});
}

Result<VertexCache> read_header(const std::string& path, const std::string& bytes) {
  if (bytes.size() < kHeaderBytes || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    return cache_error(path, "header", "is no PC2 vertex cache", "give a PC2 file");
  }
  const auto version = value_at<int32_t>(bytes, 12);
  const auto points = value_at<int32_t>(bytes, 16);
  const auto samples = value_at<int32_t>(bytes, 28);
  VertexCache cache;
  cache.start_frame = value_at<float>(bytes, 20);
  cache.sample_rate = value_at<float>(bytes, 24);
  if (version != 1) {
    return cache_error(path, "header", fmt::format("version {} is not supported, 1 is", version));
  }
  if (points <= 0 || samples <= 0) {
    return cache_error(path, "header",
                       fmt::format("claims {} points and {} samples", points, samples));
  }
  if (!std::isfinite(cache.start_frame) || !std::isfinite(cache.sample_rate) ||
      cache.sample_rate <= 0.0f) {
    return cache_error(path, "header", "the frame range makes no sense");
  }
  cache.points = static_cast<uint32_t>(points);
  cache.samples = static_cast<uint32_t>(samples);
  return cache;
}

}  // namespace

Result<VertexCache> read_pc2(const std::string& path, uint64_t memory_limit,
                             std::vector<std::string>& warnings) {
  // The file and the positions made from it are in memory together.
  SINEW_TRY(const std::string bytes, read_file(path, memory_limit / 2));
  SINEW_TRY(VertexCache cache, read_header(path, bytes));
  const uint64_t count = uint64_t{cache.points} * cache.samples;  // below 2^62
  const uint64_t held = (bytes.size() - kHeaderBytes) / sizeof(vec3);
  if (count > held) {
    return cache_error(
        path, "",
        fmt::format("is cut off: it should hold {} samples of {} points, but ends in sample {}",
                    cache.samples, cache.points, held / cache.points));
  }
  const size_t end = kHeaderBytes + count * sizeof(vec3);
  if (end < bytes.size()) {
    warnings.push_back(fmt::format("{} bytes after the last sample: ignored", bytes.size() - end));
  }
  cache.positions.resize(count);
  std::memcpy(cache.positions.data(), bytes.data() + kHeaderBytes, count * sizeof(vec3));
  const auto bad = std::find_if(cache.positions.begin(), cache.positions.end(), [](const vec3& p) {
    return !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  });
  if (bad != cache.positions.end()) {
    const auto index = static_cast<uint64_t>(bad - cache.positions.begin());
    return cache_error(path, fmt::format("sample {}", index / cache.points),
                       fmt::format("point {} is not finite", index % cache.points));
  }
  return cache;
}

Result<void> write_pc2_header(uint32_t points, uint32_t samples, OutputFile& out) {
  if (points > INT32_MAX || samples > INT32_MAX) {
    return fail({ErrorKind::usage, out.path(), "",
                 fmt::format("{} points and {} samples are too many for PC2", points, samples),
                 "split the mesh"});
  }
  const int32_t version = 1;
  const float start_frame = 0.0f, sample_rate = 1.0f;
  std::array<uint8_t, kHeaderBytes> header{};
  const auto put = [&](size_t offset, const auto& value) {
    std::memcpy(&header[offset], &value, sizeof value);
  };
  put(0, kMagic);
  put(12, version);
  put(16, points);
  put(20, start_frame);
  put(24, sample_rate);
  put(28, samples);
  return out.write(header);
}

Result<Scene> load_vertex_cache(const std::string& base, const std::string& cache_path,
                                const LoadOptions& options) {
  SINEW_TRY(Scene scene, load_obj(base, options));
  SINEW_TRY(VertexCache cache, read_pc2(cache_path, options.memory_limit, scene.warnings));
  const size_t vertices = scene.meshes[0].positions.size();
  if (cache.points != vertices) {
    return cache_error(
        cache_path, "",
        fmt::format("has {} points, but {} has {} vertices", cache.points, base, vertices),
        "give the base mesh that the cache was made from");
  }
  std::vector<float> times(cache.samples);
  for (uint32_t i = 0; i < cache.samples; ++i) {
    times[i] = static_cast<float>(i * static_cast<double>(cache.sample_rate) / kCacheFps);
    if (times[i] > kLongest || (i > 0 && times[i] <= times[i - 1])) {
      return cache_error(cache_path, "header", "its sample rate is absurd");
    }
  }
  set_keys(scene, std::move(cache.positions), std::move(times), "cache");
  return scene;
}

void set_keys(Scene& scene, std::vector<vec3> key_positions, std::vector<float> times,
              const std::string& clip_name) {
  Mesh& mesh = scene.meshes[0];
  SINEW_CHECK(scene.meshes.size() == 1 && scene.nodes.size() == 1 && !times.empty());
  SINEW_CHECK(key_positions.size() == times.size() * mesh.positions.size());
  mesh.keys = static_cast<uint32_t>(times.size());
  mesh.key_positions = std::move(key_positions);
  mesh.normals.clear();
  if (mesh.texcoords[0].empty() && mesh.colors.empty()) mesh.corners.clear();

  Clip& clip = scene.clips.emplace_back();
  clip.name = clip_name;
  clip.end = times.back();
  Channel& channel = clip.channels.emplace_back();
  channel.path = ChannelPath::cache_key;
  channel.width = 1;
  channel.times = std::move(times);
  for (uint32_t key = 0; key < mesh.keys; ++key) channel.values.push_back(static_cast<float>(key));
  scene.default_fps = kCacheFps;
  scene.default_frames = static_cast<int32_t>(std::min(1e9, std::round(clip.end * kCacheFps) + 1));
}

}  // namespace sinew
