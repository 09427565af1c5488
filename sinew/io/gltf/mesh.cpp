#include "sinew/io/gltf/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "sinew/io/gltf/extras.h"
#include "sinew/io/gltf/material.h"
#include "sinew/io/gltf/normals.h"
#include "sinew/io/gltf/primitive.h"
#include "sinew/io/gltf/weights.h"

namespace sinew::gltf {
namespace {

constexpr uint32_t kColumnsPerSet = 4;  // influences in one JOINTS_n, WEIGHTS_n pair

// Reads the vertex attributes of one glTF mesh, source by source. Attributes that only some sources
// have are filled with a neutral value in the others.
class AttributeReader {
 public:
  AttributeReader(const Reader& reader, const Primitives& primitives)
      : reader_(reader), primitives_(primitives) {}

  Result<void> read_positions(Mesh& mesh) const {
    return fill("POSITION", Numbers::any_real, vec3(0.0f), mesh.positions);
  }
  // Sources without normals get zeros, which repair_normals replaces.
  Result<void> read_normals(Mesh& mesh) const {
    return fill("NORMAL", Numbers::any_real, vec3(0.0f), mesh.normals);
  }
  // Only if all sources have them: shading computes better ones than a neutral value.
  Result<void> read_tangents(Mesh& mesh) const {
    if (!everywhere("TANGENT") || !everywhere("NORMAL")) return {};
    return fill("TANGENT", Numbers::any_real, vec4(0.0f), mesh.tangents);
  }
  Result<void> read_texcoords(Mesh& mesh) const {
    SINEW_CHECKED(fill("TEXCOORD_0", Numbers::any_real, vec2(0.0f), mesh.texcoords[0]));
    return fill("TEXCOORD_1", Numbers::any_real, vec2(0.0f), mesh.texcoords[1]);
  }
  Result<void> read_colors(Mesh& mesh) const;
  Result<RawWeights> read_weights() const;
  Result<void> read_morphs(uint32_t targets, Mesh& mesh) const;

 private:
  bool somewhere(const char* name) const {
    return std::any_of(primitives_.sources.begin(), primitives_.sources.end(),
                       [&](const VertexSource& s) { return s.attributes.has(name); });
  }
  bool everywhere(const char* name) const {
    return std::all_of(primitives_.sources.begin(), primitives_.sources.end(),
                       [&](const VertexSource& s) { return s.attributes.has(name); });
  }

  // The accessor of one attribute, with as many elements as the source has vertices.
  Result<Accessor> find(const VertexSource& source, const char* name, uint32_t components,
                        Numbers numbers) const {
    const DracoAttribute* const decoded = source.draco ? source.draco->find(name) : nullptr;
    if (!decoded) return find(source, source.attributes, name, components, numbers);
    SINEW_TRY(Accessor accessor,
              reader_.accessors.describe(source.attributes, name, components, numbers));
    accessor.count = source.count;
    accessor.bytes = decoded->bytes.data();
    accessor.stride = static_cast<uint32_t>(decoded->bytes.size() / source.count);
    return accessor;
  }
  // The same of a morph target, or where nothing is compressed.
  Result<Accessor> find(const VertexSource& source, const Json& attributes, const char* name,
                        uint32_t components, Numbers numbers) const {
    SINEW_TRY(Accessor accessor, reader_.accessors.find(attributes, name, components, numbers));
    if (accessor.count != source.count) {
      return accessor.json.error(fmt::format("has {} elements as {} of {}, which has {} vertices",
                                             accessor.count, name, attributes.element(),
                                             source.count));
    }
    return accessor;
  }

  // One entry a vertex of the mesh, if any source has the attribute; else leaves `out` empty.
  template <class T>
  Result<void> fill(const char* name, Numbers numbers, T neutral, std::vector<T>& out) const {
    if (!somewhere(name)) return {};
    SINEW_CHECKED(take(sizeof(T)));
    out.assign(primitives_.vertex_count, neutral);
    for (const VertexSource& source : primitives_.sources) {
      if (!source.attributes.has(name)) continue;
      SINEW_TRY(const Accessor accessor,
                find(source, name, static_cast<uint32_t>(T::length()), numbers));
      SINEW_CHECKED(read_into(accessor, source.first, out));
    }
    return {};
  }
  template <class T>
  static Result<void> read_into(const Accessor& accessor, size_t first, std::vector<T>& out) {
    return read(accessor, std::span<float>(glm::value_ptr(out[first]),
                                           size_t{accessor.count} * accessor.components));
  }
  Result<void> take(uint64_t bytes_per_vertex) const {
    return reader_.budget.take(primitives_.sources[0].primitive, primitives_.vertex_count,
                               bytes_per_vertex);
  }
  Result<void> read_weight_set(const VertexSource& source, uint32_t set, RawWeights& out) const;

  const Reader& reader_;
  const Primitives& primitives_;
};

Result<void> AttributeReader::read_colors(Mesh& mesh) const {
  if (!somewhere("COLOR_0")) return {};
  SINEW_CHECKED(take(sizeof(vec4)));
  mesh.colors.assign(primitives_.vertex_count, vec4(1.0f));
  for (const VertexSource& source : primitives_.sources) {
    if (!source.attributes.has("COLOR_0")) continue;
    SINEW_TRY(const Accessor accessor,
              find(source, "COLOR_0", kAnyComponents, Numbers::real_or_normalized));
    if (accessor.components == 4) {
      SINEW_CHECKED(read_into(accessor, source.first, mesh.colors));
    } else if (accessor.components == 3) {
      SINEW_TRY(const std::vector<vec3> rgb, read_vector<vec3>(reader_, accessor));
      std::transform(rgb.begin(), rgb.end(), mesh.colors.begin() + source.first,
                     [](vec3 c) { return vec4(c, 1.0f); });
    } else {
      return accessor.json.error("is a colour, but neither VEC3 nor VEC4");
    }
  }
  return {};
}

Result<void> AttributeReader::read_weight_set(const VertexSource& source, uint32_t set,
                                              RawWeights& out) const {
  const std::string joints_name = fmt::format("JOINTS_{}", set);
  const std::string weights_name = fmt::format("WEIGHTS_{}", set);
  SINEW_TRY(const Accessor joints,
            find(source, joints_name.c_str(), kColumnsPerSet, Numbers::index));
  SINEW_TRY(const Accessor weights,
            find(source, weights_name.c_str(), kColumnsPerSet, Numbers::real_or_normalized));
  const size_t size = size_t{source.count} * kColumnsPerSet;
  SINEW_CHECKED(reader_.budget.take(joints.json, size, sizeof(uint32_t) + sizeof(float)));
  std::vector<uint32_t> joint_values(size);
  std::vector<float> weight_values(size);
  SINEW_CHECKED(read(joints, std::span<uint32_t>(joint_values)));
  SINEW_CHECKED(read(weights, std::span<float>(weight_values)));
  for (size_t i = 0; i < size; ++i) {
    if (weight_values[i] > 0.0f && joint_values[i] > 0xffff) {
      return joints.json.error(fmt::format("its element {} is not a joint", i / kColumnsPerSet));
    }
    const size_t row = (source.first + i / kColumnsPerSet) * out.columns;
    const size_t column = set * kColumnsPerSet + i % kColumnsPerSet;
    out.joints[row + column] = joint_values[i];
    out.weights[row + column] = weight_values[i];
  }
  return {};
}

Result<RawWeights> AttributeReader::read_weights() const {
  uint32_t sets = 0;
  while (somewhere(fmt::format("JOINTS_{}", sets).c_str())) ++sets;
  RawWeights result;
  result.columns = sets * kColumnsPerSet;
  SINEW_CHECKED(take(2 * uint64_t{result.columns} * (sizeof(uint32_t) + sizeof(float))));
  result.joints.assign(size_t{primitives_.vertex_count} * result.columns, 0);
  result.weights.assign(size_t{primitives_.vertex_count} * result.columns, 0.0f);
  for (const VertexSource& source : primitives_.sources) {
    for (uint32_t set = 0; set < sets; ++set) {
      if (!source.attributes.has(fmt::format("JOINTS_{}", set).c_str())) continue;
      SINEW_CHECKED(read_weight_set(source, set, result));
    }
  }
  return result;
}

Result<void> AttributeReader::read_morphs(uint32_t targets, Mesh& mesh) const {
  const size_t vertices = primitives_.vertex_count;
  bool has_normals = false;
  for (const VertexSource& source : primitives_.sources) {
    for (const Json& target : source.targets) {
      has_normals |= target.has("NORMAL") && !mesh.normals.empty();
    }
  }
  SINEW_CHECKED(take(uint64_t{targets} * sizeof(vec3) * (has_normals ? 2 : 1)));
  mesh.morph_targets = targets;
  mesh.morph_positions.assign(vertices * targets, vec3(0.0f));
  if (has_normals) mesh.morph_normals.assign(vertices * targets, vec3(0.0f));
  for (const VertexSource& source : primitives_.sources) {
    for (size_t t = 0; t < source.targets.size(); ++t) {
      const Json& target = source.targets[t];
      const size_t first = t * vertices + source.first;
      if (target.has("POSITION")) {
        SINEW_TRY(const Accessor deltas, find(source, target, "POSITION", 3, Numbers::any_real));
        SINEW_CHECKED(read_into(deltas, first, mesh.morph_positions));
      }
      if (has_normals && target.has("NORMAL")) {
        SINEW_TRY(const Accessor deltas, find(source, target, "NORMAL", 3, Numbers::any_real));
        SINEW_CHECKED(read_into(deltas, first, mesh.morph_normals));
      }
    }
  }
  return {};
}

class MeshReader {
 public:
  MeshReader(const Reader& reader, Scene& scene)
      : reader_(reader), scene_(scene), material_count_(scene.materials.size()) {}

  Result<Mesh> read(const Json& json);

 private:
  Result<void> read_skin(const Json& json, const Primitives& primitives,
                         const AttributeReader& attributes, Mesh& mesh);
  Result<void> read_parts(const Primitives& primitives, Mesh& mesh);
  Result<void> read_morphs(const Json& json, const Primitives& primitives,
                           const AttributeReader& attributes, Mesh& mesh);
  void repair_directions(const Json& json, const Primitives& primitives, Mesh& mesh);
  uint32_t material_of(const Primitive& primitive);

  const Reader& reader_;
  Scene& scene_;
  size_t material_count_;  // of the file
  std::optional<uint32_t> default_material_;
};

uint32_t MeshReader::material_of(const Primitive& primitive) {
  if (primitive.material) return *primitive.material;
  if (!default_material_) {
    default_material_ = static_cast<uint32_t>(scene_.materials.size());
    scene_.materials.push_back(default_material());
  }
  return *default_material_;
}

Result<void> MeshReader::read_parts(const Primitives& primitives, Mesh& mesh) {
  for (const Primitive& primitive : primitives.items) {
    const VertexSource& source = primitives.sources[primitive.source];
    SINEW_TRY(const std::vector<uvec3> triangles, read_triangles(reader_, primitive, source));
    SINEW_CHECKED(reader_.budget.take(primitive.json, triangles.size(), 16));
    mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
    mesh.triangle_part.resize(mesh.triangles.size(), static_cast<uint32_t>(mesh.parts.size()));
    mesh.parts.push_back({material_of(primitive), !source.attributes.has("NORMAL")});
  }
  return {};
}

Result<void> MeshReader::read_skin(const Json& json, const Primitives& primitives,
                                   const AttributeReader& attributes, Mesh& mesh) {
  SINEW_TRY(const RawWeights raw, attributes.read_weights());
  if (raw.columns == 0) return {};
  const WeightChanges changes = compact_weights(raw, primitives.vertex_count, mesh);
  if (changes.normalized > 0) {
    reader_.warnings.add(json.element(), fmt::format("skin weights of {} vertices were normalised",
                                                     changes.normalized));
  }
  if (changes.unweighted > 0) {
    reader_.warnings.add(
        json.element(),
        fmt::format("{} vertices without skin weights were bound to joint 0", changes.unweighted));
  }
  return {};
}

Result<void> MeshReader::read_morphs(const Json& json, const Primitives& primitives,
                                     const AttributeReader& attributes, Mesh& mesh) {
  const size_t targets = primitives.sources[0].targets.size();
  for (const VertexSource& source : primitives.sources) {
    if (source.targets.size() != targets) {
      return source.primitive.error(
          "has another number of morph targets than the primitive before");
    }
  }
  if (targets == 0) return {};
  SINEW_CHECKED(attributes.read_morphs(static_cast<uint32_t>(targets), mesh));
  SINEW_TRY(mesh.morph_weights, json.number_list("weights"));
  if (!mesh.morph_weights.empty() && mesh.morph_weights.size() != targets) {
    return json.error(
        fmt::format("has {} weights for {} morph targets", mesh.morph_weights.size(), targets));
  }
  mesh.morph_weights.resize(targets, 0.0f);
  if (const Result<Json> extras = json.object("extras")) {  // may be anything: names only decorate
    mesh.morph_names = extras->texts("targetNames").value_or(std::vector<std::string>());
  }
  for (size_t t = mesh.morph_names.size(); t < targets; ++t) {
    mesh.morph_names.push_back(fmt::format("target {}", t));
  }
  mesh.morph_names.resize(targets);
  return {};
}

// Gives every direction unit length; what had none counts as a fault only where the file gave it.
void MeshReader::repair_directions(const Json& json, const Primitives& primitives, Mesh& mesh) {
  uint64_t given = 0;  // normals that the file holds
  for (const VertexSource& source : primitives.sources) {
    if (source.attributes.has("NORMAL")) given += source.count;
  }
  const uint64_t without_length = repair_normals(mesh);
  const uint64_t not_given = mesh.normals.size() - given;
  if (without_length > not_given) {
    reader_.warnings.add(json.element(),
                         fmt::format("{} normals have no length; computed from the triangles",
                                     without_length - not_given));
  }
  repair_tangents(mesh);
}

Result<Mesh> MeshReader::read(const Json& json) {
  Mesh mesh;
  SINEW_TRY(mesh.name, json.text("name"));
  SINEW_TRY(const Primitives primitives, read_primitives(reader_, json, material_count_));
  if (primitives.items.empty()) return mesh;
  const AttributeReader attributes(reader_, primitives);
  SINEW_CHECKED(attributes.read_positions(mesh));
  SINEW_CHECKED(attributes.read_normals(mesh));
  SINEW_CHECKED(attributes.read_tangents(mesh));
  SINEW_CHECKED(attributes.read_texcoords(mesh));
  SINEW_CHECKED(attributes.read_colors(mesh));
  SINEW_CHECKED(read_skin(json, primitives, attributes, mesh));
  SINEW_CHECKED(read_morphs(json, primitives, attributes, mesh));
  SINEW_CHECKED(read_parts(primitives, mesh));
  repair_directions(json, primitives, mesh);
  SINEW_CHECKED(read_vertex_cache(reader_, json, primitives, mesh));
  return mesh;
}

}  // namespace

Result<std::vector<int32_t>> read_meshes(const Reader& reader, const NodeGraph& graph,
                                         Scene& scene) {
  SINEW_TRY(const std::vector<Json> meshes, reader.asset.root().objects("meshes", "mesh"));
  std::vector<bool> used(meshes.size(), false);
  for (const uint32_t node : graph.order) {
    SINEW_TRY(const auto mesh, graph.nodes[node].index("mesh", meshes.size()));
    if (mesh) used[*mesh] = true;
  }
  std::vector<int32_t> result(meshes.size(), -1);
  MeshReader mesh_reader(reader, scene);
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!used[i]) continue;
    SINEW_TRY(Mesh mesh, mesh_reader.read(meshes[i]));
    if (mesh.triangles.empty()) {
      reader.warnings.add(meshes[i].element(), "has no triangles; left out");
      continue;
    }
    result[i] = static_cast<int32_t>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
  }
  return result;
}

}  // namespace sinew::gltf
