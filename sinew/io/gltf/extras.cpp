#include "sinew/io/gltf/extras.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "sinew/io/gltf/animation.h"
#include "sinew/io/gltf/uri.h"
#include "sinew/io/vertex_cache.h"

namespace sinew::gltf {
namespace {

// The point of each vertex of the mesh; empty if all are points of their own.
Result<std::vector<uint32_t>> read_points(const Reader& reader, const Primitives& primitives) {
  std::vector<uint32_t> points;
  for (const VertexSource& source : primitives.sources) {
    if (!source.attributes.has(kPointAttribute)) return std::vector<uint32_t>();
    SINEW_TRY(const Accessor accessor,
              reader.accessors.find(source.attributes, kPointAttribute, 2, Numbers::index));
    if (accessor.count != source.count) {
      return accessor.json.error(
          fmt::format("has {} elements for {} vertices", accessor.count, source.count));
    }
    SINEW_CHECKED(reader.budget.take(accessor.json, source.count, 3 * sizeof(uint32_t)));
    std::vector<uint32_t> halves(size_t{2} * source.count);
    SINEW_CHECKED(read(accessor, std::span<uint32_t>(halves)));
    for (size_t v = 0; v < source.count; ++v) {
      const uint64_t point = halves[2 * v] + (uint64_t{halves[2 * v + 1]} << 16);
      if (point >= primitives.vertex_count) {
        return accessor.json.error(
            fmt::format("its element {} is point {}, but there are only {} "
                        "vertices",
                        v, point, primitives.vertex_count));
      }
      points.push_back(static_cast<uint32_t>(point));
    }
  }
  return points;
}

// values[points[v]] = old[v], in each of the rows of points.size() values.
std::vector<vec3> gather(const std::vector<vec3>& old, const std::vector<uint32_t>& points,
                         size_t point_count) {
  std::vector<vec3> values(old.size() / points.size() * point_count, vec3(0.0f));
  for (size_t i = 0; i < old.size(); ++i) {
    values[i / points.size() * point_count + points[i % points.size()]] = old[i];
  }
  return values;
}

// Makes one vertex of those that are one point; their attributes become those of corners.
Result<void> join_points(const Reader& reader, const Json& json,
                         const std::vector<uint32_t>& points, Mesh& mesh) {
  const size_t point_count = size_t{*std::max_element(points.begin(), points.end())} + 1;
  SINEW_CHECKED(reader.budget.take(json, point_count, (1 + mesh.keys) * sizeof(vec3)));
  SINEW_CHECKED(reader.budget.take(json, mesh.triangles.size(), sizeof(uvec3)));
  mesh.positions = gather(mesh.positions, points, point_count);
  mesh.key_positions = gather(mesh.key_positions, points, point_count);
  mesh.corners = mesh.triangles;
  for (uvec3& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) triangle[k] = points[triangle[k]];
  }
  return {};
}

}  // namespace

Json extras_of(const Json& json) {
  const Result<Json> extras = json.object("extras");
  return extras ? *extras : Json();
}

bool has_flag(const Json& json, const char* extra) {
  return extras_of(json).boolean(extra, false).value_or(false);
}

Result<void> read_vertex_cache(const Reader& reader, const Json& json, const Primitives& primitives,
                               Mesh& mesh) {
  const Json extras = extras_of(json);
  if (!extras.has("sinew_vertex_cache")) return {};
  SINEW_TRY(const Json cache_json, extras.object("sinew_vertex_cache"));
  SINEW_TRY(const std::string uri, cache_json.text("uri"));
  const auto file = file_of_uri(reader.asset.folder, uri);
  if (!file) return json.error(file.error(), "put the vertex cache beside the asset");
  std::vector<std::string> warnings;
  // The file and the positions made from it are in memory together.
  Result<VertexCache> cache =
      read_file(file->string(), reader.budget.left() / 2).and_then([&](const std::string& bytes) {
        return parse_pc2(bytes, file->string(), warnings);
      });
  if (!cache) {
    return json.error("its vertex cache \"" + percent_decode(uri) + "\" " + cache.error().problem,
                      "put the vertex cache beside the asset");
  }
  for (const std::string& warning : warnings) reader.warnings.add(json.element(), warning);
  SINEW_CHECKED(reader.budget.take(json, cache->positions.size(), sizeof(vec3)));
  if (cache->points != mesh.positions.size()) {
    return json.error(fmt::format("has {} vertices, but its vertex cache {}", mesh.positions.size(),
                                  cache->points),
                      "export the file again");
  }
  mesh.keys = static_cast<uint32_t>(cache->times.size());
  mesh.key_positions = std::move(cache->positions);
  mesh.normals.clear();  // they fit the rest mesh only
  mesh.tangents.clear();
  SINEW_TRY(const std::vector<uint32_t> points, read_points(reader, primitives));
  if (!points.empty()) SINEW_CHECKED(join_points(reader, json, points, mesh));
  if (mesh.texcoords[0].empty() && mesh.texcoords[1].empty() && mesh.colors.empty()) {
    mesh.corners.clear();
  }
  return {};
}

Result<void> read_cache_keys(const Reader& reader, const Json& json,
                             std::span<const NodePlace> places, const Scene& scene, Clip& clip) {
  SINEW_TRY(const std::vector<Json> items,
            extras_of(json).objects("sinew_cache_keys", "cache keys", json.element() + " "));
  for (const Json& item : items) {
    SINEW_TRY(const uint32_t node, item.required_index("node", places.size()));
    Channel channel;
    channel.path = ChannelPath::cache_key;
    channel.width = 1;
    channel.node = places[node].first_mesh;
    const int32_t mesh = places[node].node < 0 ? -1 : scene.nodes[channel.node].mesh;
    if (mesh < 0 || scene.meshes[static_cast<size_t>(mesh)].keys == 0) {
      reader.warnings.add(json.element(), "plays a vertex cache of a node that has none; ignored");
      continue;
    }
    SINEW_TRY(channel.interpolation, interpolation_of(item));
    SINEW_TRY(channel.times, item.number_list("times"));
    SINEW_TRY(channel.values, item.number_list("values"));
    const size_t parts = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
    const bool rising = std::ranges::adjacent_find(channel.times, std::ranges::greater_equal{}) ==
                        channel.times.end();
    if (channel.times.empty() || channel.values.size() != parts * channel.times.size() || !rising) {
      return item.error("needs rising times and as many values", "export the file again");
    }
    clip.channels.push_back(std::move(channel));
  }
  return {};
}

Result<void> read_extent(const Json& json, Clip& clip) {
  const Json extras = extras_of(json);
  SINEW_TRY(const float start, extras.number("sinew_start", static_cast<float>(clip.start)));
  SINEW_TRY(const float end, extras.number("sinew_end", static_cast<float>(clip.end)));
  if (!(start <= end)) return json.error(fmt::format("runs from {} to {} s", start, end));
  clip.start = double{start};
  clip.end = double{end};
  return {};
}

Result<void> read_scene_extras(const Json& json, Scene& scene) {
  constexpr uint64_t kMostFrames = std::numeric_limits<int32_t>::max();
  const Json extras = extras_of(json);
  SINEW_TRY(const float fps, extras.number("sinew_fps", 0.0f));
  SINEW_TRY(const uint64_t frames, extras.unsigned_number("sinew_frames", 0, kMostFrames));
  if (!(fps >= 0.0f && fps <= kHighestFps)) return json.error("its frame rate makes no sense");
  scene.default_fps = double{fps};
  scene.default_frames = static_cast<int32_t>(frames);
  SINEW_TRY(const Json environment, extras.object("sinew_environment"));
  SINEW_CHECKED(environment.numbers("zenith", {&scene.environment.zenith.x, 3}));
  SINEW_CHECKED(environment.numbers("horizon", {&scene.environment.horizon.x, 3}));
  SINEW_CHECKED(environment.numbers("nadir", {&scene.environment.nadir.x, 3}));
  vec3 ambient(0.0f);
  SINEW_TRY(const bool has_ambient, environment.numbers("ambient", {&ambient.x, 3}));
  if (has_ambient) scene.environment.ambient = ambient;
  return {};
}

}  // namespace sinew::gltf
