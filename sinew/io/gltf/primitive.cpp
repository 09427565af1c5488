#include "sinew/io/gltf/primitive.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

namespace sinew::gltf {
namespace {

constexpr uint64_t kTriangles = 4;
constexpr uint64_t kTriangleFan = 6;

// Names the accessors of a primitive's vertices: equal texts mean equal vertices.
Result<std::string> source_key(const Json& primitive, const Json& attributes,
                               const std::vector<Json>& targets) {
  std::string key;
  SINEW_TRY(const std::vector<std::string> names, primitive.keys("attributes"));
  for (const std::string& name : names) {
    SINEW_TRY(const uint32_t accessor, attributes.required_index(name.c_str(), SIZE_MAX));
    key += fmt::format("{}={};", name, accessor);
  }
  for (const Json& target : targets) {
    key += '|';
    for (const char* name : {"POSITION", "NORMAL"}) {
      SINEW_TRY(const auto accessor, target.index(name, SIZE_MAX));
      if (accessor) key += fmt::format("{}={};", name, *accessor);
    }
  }
  return key;
}

// What the primitive holds compressed; null if nothing, or if its accessors hold it plain besides.
Result<std::unique_ptr<DracoMesh>> read_draco(const Reader& reader, const Json& primitive,
                                              const Json& attributes) {
  SINEW_TRY(const Json extensions, primitive.object("extensions"));
  SINEW_TRY(const Json extension, extensions.object("KHR_draco_mesh_compression"));
  SINEW_TRY(const Accessor positions,
            reader.accessors.describe(attributes, "POSITION", 3, Numbers::any_real));
  const bool is_plain = positions.json.has("bufferView") || positions.json.has("sparse");
  if (is_plain || !extensions.has("KHR_draco_mesh_compression")) return nullptr;
  auto mesh = std::make_unique<DracoMesh>();
  SINEW_TRY(const Json ids, extension.object("attributes"));
  SINEW_TRY(const std::vector<std::string> names, extension.keys("attributes"));
  for (const std::string& name : names) {
    if (!attributes.has(name.c_str())) continue;
    const bool joints = name.starts_with("JOINTS_");
    SINEW_TRY(const Accessor accessor,
              reader.accessors.describe(attributes, name.c_str(), kAnyComponents,
                                        joints ? Numbers::index : Numbers::any_real));
    SINEW_TRY(const uint64_t id, ids.unsigned_number(name.c_str(), 0, 0xffffffff));
    mesh->attributes.push_back(
        {name, static_cast<uint32_t>(id), accessor.components, accessor.type, {}});
  }
  SINEW_TRY(const std::span<const uint8_t> bytes,
            reader.accessors.view_bytes(extension, "bufferView"));
  SINEW_CHECKED(decode_draco(primitive, bytes, reader.budget, *mesh));
  return mesh;
}

// Equal compressed data with equal attributes mean equal vertices and triangles.
Result<std::string> draco_key(const Json& primitive) {
  SINEW_TRY(const Json extensions, primitive.object("extensions"));
  SINEW_TRY(const Json extension, extensions.object("KHR_draco_mesh_compression"));
  SINEW_TRY(const auto view, extension.index("bufferView", SIZE_MAX));
  return view ? fmt::format("|draco={}", *view) : std::string();
}

Result<uint32_t> count_vertices(const Reader& reader, const VertexSource& source) {
  if (source.draco) return source.draco->vertex_count;
  SINEW_TRY(const Accessor positions,
            reader.accessors.find(source.attributes, "POSITION", 3, Numbers::any_real));
  return positions.count;
}

Result<void> add_primitive(const Reader& reader, Primitive primitive,
                           std::map<std::string, uint32_t>& known, Primitives& out) {
  const Json& json = primitive.json;
  VertexSource source{json, {}, {}, nullptr, out.vertex_count, 0};
  SINEW_TRY(source.attributes, json.object("attributes"));
  SINEW_TRY(source.targets, json.objects("targets", "target", json.element() + " "));
  if (!source.attributes.has("POSITION")) {
    reader.warnings.add(json.element(), "has no positions; left out");
    return {};
  }
  SINEW_TRY(const std::string key, source_key(json, source.attributes, source.targets));
  SINEW_TRY(const std::string compressed, draco_key(json));
  const auto [place, is_new] =
      known.try_emplace(key + compressed, static_cast<uint32_t>(out.sources.size()));
  primitive.source = place->second;
  if (is_new) {
    SINEW_TRY(source.draco, read_draco(reader, json, source.attributes));
    SINEW_TRY(source.count, count_vertices(reader, source));
    if (source.count > std::numeric_limits<uint32_t>::max() - out.vertex_count) {
      return json.error("the mesh has more vertices than 32 bits can count");
    }
    out.vertex_count += source.count;
    out.sources.push_back(std::move(source));
  }
  out.items.push_back(std::move(primitive));
  return {};
}

Result<std::vector<uint32_t>> read_indices(const Reader& reader, const Primitive& primitive,
                                           const VertexSource& source) {
  const Json& json = primitive.json;
  if (source.draco) return source.draco->indices;
  std::vector<uint32_t> indices;
  if (!json.has("indices")) {
    SINEW_CHECKED(reader.budget.take(json, source.count, sizeof(uint32_t)));
    indices.resize(source.count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }
  SINEW_TRY(const Accessor accessor, reader.accessors.find(json, "indices", 1, Numbers::index));
  SINEW_TRY(indices, read_vector<uint32_t>(reader, accessor));
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= source.count) {
      return accessor.json.error(fmt::format("its element {} is vertex {}, but {} has only {}", i,
                                             indices[i], json.element(), source.count),
                                 "export the file again");
    }
  }
  return indices;
}

}  // namespace

Result<Primitives> read_primitives(const Reader& reader, const Json& mesh, size_t material_count) {
  SINEW_TRY(const std::vector<Json> primitives,
            mesh.objects("primitives", "primitive", mesh.element() + " "));
  Primitives result;
  std::map<std::string, uint32_t> known;
  for (const Json& json : primitives) {
    SINEW_TRY(const uint64_t mode, json.unsigned_number("mode", kTriangles, kTriangleFan));
    if (mode < kTriangles) {
      reader.warnings.add(json.element(), "points and lines are not supported; left out");
      continue;
    }
    Primitive primitive{json, static_cast<Topology>(mode), 0, std::nullopt};
    SINEW_TRY(primitive.material, json.index("material", material_count));
    SINEW_CHECKED(add_primitive(reader, std::move(primitive), known, result));
  }
  return result;
}

Result<std::vector<uvec3>> read_triangles(const Reader& reader, const Primitive& primitive,
                                          const VertexSource& source) {
  SINEW_TRY(const std::vector<uint32_t> indices, read_indices(reader, primitive, source));
  const Topology topology = source.draco ? Topology::list : primitive.topology;
  const bool list = topology == Topology::list;
  if (indices.size() < 3 || (list && indices.size() % 3 != 0)) {
    reader.warnings.add(primitive.json.element(), "has an incomplete triangle; left out");
  }
  const size_t count = list ? indices.size() / 3 : std::max<size_t>(indices.size(), 2) - 2;
  SINEW_CHECKED(reader.budget.take(primitive.json, count, sizeof(uvec3)));
  std::vector<uvec3> triangles(count);
  for (size_t i = 0; i < count; ++i) {
    uvec3 corners(static_cast<uint32_t>(i));  // positions in `indices`
    switch (topology) {
      case Topology::list:
        corners = corners * 3u + uvec3(0, 1, 2);
        break;
      case Topology::strip:  // every second triangle turns round
        corners += i % 2 == 0 ? uvec3(0, 1, 2) : uvec3(0, 2, 1);
        break;
      case Topology::fan:
        corners = uvec3(corners.x + 1, corners.x + 2, 0);
        break;
    }
    for (int k = 0; k < 3; ++k) triangles[i][k] = source.first + indices[corners[k]];
  }
  return triangles;
}

}  // namespace sinew::gltf
