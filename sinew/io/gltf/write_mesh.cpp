#include "sinew/io/gltf/write_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/io/gltf/extras.h"
#include "sinew/io/gltf/uri.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew::gltf {
namespace {

using Short2 = glm::vec<2, uint16_t>;
using Short4 = glm::vec<4, uint16_t>;
using Byte4 = glm::vec<4, uint8_t>;

constexpr uint32_t kColumnsPerSet = 4;  // influences in one JOINTS_n, WEIGHTS_n pair

vec3 unit(vec3 v, vec3 otherwise) {
  const glm::dvec3 wide(v);
  const double size = length(wide);
  return size > 0.0 ? vec3(wide / size) : otherwise;
}

// Fills columns, joints and weights: each joint once a position, used ones first, sums of 1.
void merge_influences(const Mesh& mesh, MeshOutput& out) {
  const size_t count = mesh.positions.size();
  out.columns = (mesh.influences + kColumnsPerSet - 1) / kColumnsPerSet * kColumnsPerSet;
  out.joints.assign(count * out.columns, 0);
  out.weights.assign(count * out.columns, 0.0f);
  std::vector<double> sums(out.columns);
  for (size_t v = 0; v < count; ++v) {
    uint16_t* const joints = &out.joints[v * out.columns];
    size_t used = 0;
    double total = 0.0;
    for (size_t i = v * mesh.influences; i < (v + 1) * mesh.influences; ++i) {
      if (!(mesh.weights[i] > 0.0f)) continue;
      const auto slot =
          static_cast<size_t>(std::find(joints, joints + used, mesh.joints[i]) - joints);
      if (slot == used) {
        joints[used] = mesh.joints[i];
        sums[used++] = 0.0;
      }
      sums[slot] += double{mesh.weights[i]};
      total += double{mesh.weights[i]};
    }
    for (size_t k = 0; k < used; ++k) {
      out.weights[v * out.columns + k] = static_cast<float>(sums[k] / total);
    }
  }
}

// How many texture coordinate sets a primitive with this material must have.
uint32_t texcoord_sets(const Material& material) {
  uint32_t sets = 0;
  for (const TextureRef* texture :
       {&material.base_color_texture, &material.metallic_roughness_texture,
        &material.normal_texture, &material.occlusion_texture, &material.emissive_texture,
        &material.transmission_texture}) {
    if (texture->image >= 0) sets = std::max(sets, texture->texcoord + 1);
  }
  return sets;
}

// Writes one mesh.
class MeshWriter {
 public:
  MeshWriter(const WriteContext& context, const Mesh& mesh, const MeshCache& cache, MeshOutput& out)
      : context_(context), asset_(context.asset), mesh_(mesh), cache_(cache), out_(out) {}

  JsonOut write();

 private:
  bool cached() const { return cache_.keys > 0; }
  void prepare();
  JsonOut attributes(uint32_t set);
  void add_directions(const VertexSet& set, JsonOut& out);
  void add_texcoords(uint32_t set, JsonOut& out);
  void add_influences(const VertexSet& set, JsonOut& out);
  void add_points(uint32_t set, JsonOut& out);
  JsonOut targets(const VertexSet& set);
  uint32_t indices(const PartTriangles& part);
  JsonOut extras() const;

  // An accessor with one element a vertex of the set.
  template <class T, class At>
  uint32_t add(const VertexSet& set, Limits limits, const At& at) {
    return asset_.add_elements<T>(set.count, ViewUse::vertices, limits, at);
  }

  const WriteContext& context_;
  AssetWriter& asset_;
  const Mesh& mesh_;
  const MeshCache& cache_;
  MeshOutput& out_;
};

void MeshWriter::prepare() {
  out_.vertices = split_vertices(mesh_);
  const bool smooth = std::any_of(out_.vertices.sets.begin(), out_.vertices.sets.end(),
                                  [](const VertexSet& set) { return !set.flat; });
  if (smooth && mesh_.normals.empty()) {
    out_.normals = vertex_normals(mesh_.positions, mesh_.triangles);
  }
  if (out_.skinned) merge_influences(mesh_, out_);
  const bool in_range = std::all_of(mesh_.colors.begin(), mesh_.colors.end(),
                                    [](const vec4& c) { return c == glm::clamp(c, 0.0f, 1.0f); });
  if (!in_range) {
    context_.warnings.add(element("mesh", mesh_.name), "has vertex colours beyond 0..1; clamped");
  }
  if (cached() && !out_.vertices.unchanged()) {
    out_.points = out_.vertices.dense_points(mesh_.positions.size());
  }
}

void MeshWriter::add_directions(const VertexSet& set, JsonOut& out) {
  if (set.flat) return;
  const Mesh& mesh = mesh_;
  const std::vector<vec3>& computed = out_.normals;
  const vec3 up(0, 1, 0);
  if (mesh.normals.empty()) {
    out["NORMAL"] = add<vec3>(set, Limits::omitted, [&set, &computed, up](size_t v) {
      return unit(computed[set.point(v)], up);
    });
    return;
  }
  out["NORMAL"] = add<vec3>(set, Limits::omitted, [&set, &mesh, up](size_t v) {
    return unit(mesh.normals[set.corner(v)], up);
  });
  if (mesh.tangents.empty()) return;
  out["TANGENT"] = add<vec4>(set, Limits::omitted, [&set, &mesh](size_t v) {
    const vec4 tangent = mesh.tangents[set.corner(v)];
    return vec4(unit(vec3(tangent), vec3(1, 0, 0)), tangent.w);
  });
}

void MeshWriter::add_texcoords(uint32_t set_index, JsonOut& out) {
  const VertexSet& set = out_.vertices.sets[set_index];
  uint32_t count = mesh_.texcoords[1].empty() ? (mesh_.texcoords[0].empty() ? 0 : 1) : 2;
  for (const PartTriangles& part : out_.vertices.parts) {
    if (part.set != set_index) continue;
    const uint32_t material = mesh_.parts[part.part].material;
    count = std::max(count, texcoord_sets(context_.scene.materials[material]));
  }
  for (uint32_t k = 0; k < count; ++k) {
    const std::vector<vec2>& texcoords = mesh_.texcoords[k];
    out[fmt::format("TEXCOORD_{}", k)] =
        add<vec2>(set, Limits::omitted, [&set, &texcoords](size_t v) {
          return texcoords.empty() ? vec2(0.0f) : texcoords[set.corner(v)];
        });
  }
}

void MeshWriter::add_influences(const VertexSet& set, JsonOut& out) {
  const MeshOutput& data = out_;
  const bool narrow = std::all_of(data.joints.begin(), data.joints.end(),
                                  [](uint16_t joint) { return joint < 256; });
  for (uint32_t column = 0; column < data.columns; column += kColumnsPerSet) {
    const auto joints_of = [&set, &data, column](size_t v) {
      const uint16_t* j = &data.joints[size_t{set.point(v)} * data.columns + column];
      return Short4(j[0], j[1], j[2], j[3]);
    };
    const uint32_t number = column / kColumnsPerSet;
    out[fmt::format("JOINTS_{}", number)] =
        narrow ? add<Byte4>(set, Limits::omitted,
                            [joints_of](size_t v) { return Byte4(joints_of(v)); })
               : add<Short4>(set, Limits::omitted, joints_of);
    out[fmt::format("WEIGHTS_{}", number)] =
        add<vec4>(set, Limits::omitted, [&set, &data, column](size_t v) {
          const float* w = &data.weights[size_t{set.point(v)} * data.columns + column];
          return vec4(w[0], w[1], w[2], w[3]);
        });
  }
}

void MeshWriter::add_points(uint32_t set_index, JsonOut& out) {
  size_t first = 0;
  for (uint32_t i = 0; i < set_index; ++i) first += out_.vertices.sets[i].count;
  const std::vector<uint32_t>& points = out_.points;
  out[kPointAttribute] =
      add<Short2>(out_.vertices.sets[set_index], Limits::omitted, [&points, first](size_t v) {
        return Short2(points[first + v] & 0xffff, points[first + v] >> 16);
      });
}

JsonOut MeshWriter::attributes(uint32_t set_index) {
  const VertexSet& set = out_.vertices.sets[set_index];
  const Mesh& mesh = mesh_;
  JsonOut out;
  out["POSITION"] = add<vec3>(set, Limits::stated,
                              [&set, &mesh](size_t v) { return mesh.positions[set.point(v)]; });
  add_directions(set, out);
  add_texcoords(set_index, out);
  if (!mesh.colors.empty()) {
    out["COLOR_0"] = add<vec4>(set, Limits::omitted, [&set, &mesh](size_t v) {
      return glm::clamp(mesh.colors[set.corner(v)], 0.0f, 1.0f);
    });
  }
  if (out_.skinned) add_influences(set, out);
  if (!out_.points.empty()) add_points(set_index, out);
  return out;
}

// Morph targets.
JsonOut MeshWriter::targets(const VertexSet& set) {
  const Mesh& mesh = mesh_;
  JsonOut out = JsonOut::array();
  for (size_t t = 0; t < mesh.morph_targets; ++t) {
    JsonOut target;
    const size_t first = t * mesh.positions.size();
    target["POSITION"] = add<vec3>(set, Limits::stated, [&set, &mesh, first](size_t v) {
      return mesh.morph_positions[first + set.point(v)];
    });
    if (!set.flat && !mesh.morph_normals.empty()) {
      const size_t first_normal = t * mesh.normals.size();
      target["NORMAL"] = add<vec3>(set, Limits::omitted, [&set, &mesh, first_normal](size_t v) {
        return mesh.morph_normals[first_normal + set.corner(v)];
      });
    }
    out.push_back(std::move(target));
  }
  return out;
}

uint32_t MeshWriter::indices(const PartTriangles& part) {
  constexpr uint32_t kMostShort = 0xffff;  // which itself restarts a primitive
  const uvec3* const triangles = &out_.vertices.triangles[part.first];
  const uint32_t count = 3 * part.count;
  const auto index_of = [triangles](size_t i) { return triangles[i / 3][static_cast<int>(i % 3)]; };
  if (out_.vertices.sets[part.set].count <= kMostShort) {
    return asset_.add_elements<uint16_t>(
        count, ViewUse::indices, Limits::omitted,
        [index_of](size_t i) { return static_cast<uint16_t>(index_of(i)); });
  }
  return asset_.add_elements<uint32_t>(count, ViewUse::indices, Limits::omitted, index_of);
}

JsonOut MeshWriter::extras() const {
  JsonOut out = JsonOut::object();
  if (cached()) {
    out["sinew_vertex_cache"] = {{"uri", percent_encode(cache_.file_name)}, {"fps", cache_.fps}};
  } else if (mesh_.morph_targets > 0 && !mesh_.morph_names.empty()) {
    out["targetNames"] = mesh_.morph_names;
  }
  return out;
}

JsonOut MeshWriter::write() {
  prepare();
  const bool morphs = mesh_.morph_targets > 0 && !cached();
  if (cached() && (mesh_.morph_targets > 0 || mesh_.influences > 0)) {
    context_.warnings.add(element("mesh", mesh_.name),
                          "a vertex cache moves it; its skin and morphs are left out");
  }
  JsonOut json = named(mesh_.name);
  std::vector<JsonOut> set_attributes, set_targets;
  for (uint32_t set = 0; set < out_.vertices.sets.size(); ++set) {
    set_attributes.push_back(attributes(set));
    if (morphs) set_targets.push_back(targets(out_.vertices.sets[set]));
  }
  for (const PartTriangles& part : out_.vertices.parts) {
    JsonOut primitive = {{"attributes", set_attributes[part.set]}, {"indices", indices(part)}};
    primitive["material"] = mesh_.parts[part.part].material;
    if (morphs) primitive["targets"] = set_targets[part.set];
    json["primitives"].push_back(std::move(primitive));
  }
  for (const float weight : mesh_.morph_weights) {
    if (morphs) json["weights"].push_back(double{weight});
  }
  if (JsonOut found = extras(); !found.empty()) json["extras"] = std::move(found);
  return json;
}

}  // namespace

std::vector<MeshOutput> write_meshes(const WriteContext& context,
                                     const std::vector<MeshCache>& caches) {
  const Scene& scene = context.scene;
  std::vector<MeshOutput> result(scene.meshes.size());
  std::vector<bool> shown(scene.meshes.size(), false);
  for (const SceneObject& object : scene.objects) {
    shown[object.mesh] = true;
    result[object.mesh].skinned |= object.skin >= 0;
  }
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    if (!shown[i]) continue;
    if (scene.meshes[i].triangles.empty()) {
      context.warnings.add(element("mesh", scene.meshes[i].name), "has no triangles; left out");
      continue;
    }
    JsonOut json = MeshWriter(context, scene.meshes[i], caches[i], result[i]).write();
    result[i].json_mesh = static_cast<int32_t>(context.asset.add("meshes", std::move(json)));
  }
  return result;
}

}  // namespace sinew::gltf
