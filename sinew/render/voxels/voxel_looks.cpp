#include "sinew/render/voxels/voxel_looks.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr float kLeastBlend = 0.5f / 255.0f;  // blended surfaces: what is clearer is not there

vec3 unit_or_zero(vec3 v) {
  const float l2 = dot(v, v);
  return l2 > 0.0f ? v / std::sqrt(l2) : vec3(0.0f);
}

template <class T>
Linear<T> linear(std::span<const T> values, uvec3 index) {
  const T first = values[index.x];
  return {first, values[index.y] - first, values[index.z] - first};
}

std::span<const vec2> texcoords_of(const Mesh& mesh, const TextureRef& texture) {
  if (texture.texcoord >= std::size(mesh.texcoords)) return {};
  return mesh.texcoords[texture.texcoord];
}

Linear<vec2> texcoords_on(const Mesh& mesh, const TextureRef& texture, uint32_t triangle) {
  Linear<vec2> uv = linear(texcoords_of(mesh, texture), mesh.corner_of(triangle));
  const vec2 first = transform_texcoord(texture, uv.first);
  return {first, transform_texcoord(texture, uv.first + uv.to_second) - first,
          transform_texcoord(texture, uv.first + uv.to_third) - first};
}

vec3 face_of(const Mesh& mesh, uint32_t triangle) {
  const uvec3 t = mesh.triangles[triangle];
  const vec3 a = mesh.positions[t.x];
  return cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
}

bool is_smooth(const Mesh& mesh) {
  return std::any_of(mesh.parts.begin(), mesh.parts.end(),
                     [](const MeshPart& part) { return !part.flat; });
}

// Means of the triangles around each vertex by area, as render/attributes.h computes them.
std::vector<vec3> compute_normals(const Mesh& mesh) {
  std::vector<vec3> normals(mesh.positions.size(), vec3(0.0f));
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const vec3 face = face_of(mesh, i);
    for (int k = 0; k < 3; ++k) normals[mesh.triangles[i][k]] += face;
  }
  for (vec3& normal : normals) normal = unit_or_zero(normal);
  return normals;
}

}  // namespace

uint32_t texture_level(const Scene& scene, const Mesh& mesh, const TextureRef& texture,
                       uint32_t triangle, float voxel) {
  const Image8& image = scene.images[static_cast<size_t>(texture.image)];
  const Linear<vec2> uv = texcoords_on(mesh, texture, triangle);
  const float texels = std::abs(uv.to_second.x * uv.to_third.y - uv.to_second.y * uv.to_third.x) *
                       static_cast<float>(image.width) * static_cast<float>(image.height);
  const float voxels = length(face_of(mesh, triangle) / voxel / voxel);
  const float ratio = texels / voxels;  // in area
  if (!(ratio > 2.0f)) return 0;
  return static_cast<uint32_t>(std::lround(std::min(0.5f * std::log2(ratio), 30.0f)));
}

void LookTextures::use(std::vector<MipMap>& maps, const TextureRef& texture, bool srgb,
                       bool smaller) {
  const Image8* image = texture_image(scene_->images, texture);
  if (image == nullptr) return;
  MipMap& map = maps[static_cast<size_t>(texture.image)];
  if (map.image == nullptr) map.image = image;
  if (smaller && map.smaller.empty()) map = make_mip_map(*image, srgb);
}

void LookTextures::prepare(const Mesh& mesh, float voxel) {
  // The highest level of each texture of each material.
  struct Use {
    const TextureRef* texture;
    bool color;
    uint32_t level = 0;
  };
  std::vector<std::vector<Use>> uses(scene_->materials.size());
  for (const MeshPart& part : mesh.parts) {
    const Material& m = scene_->materials[part.material];
    std::vector<Use>& list = uses[part.material];
    if (!list.empty()) continue;
    const auto add = [&](const TextureRef& texture, bool color) {
      const bool is_there = texture_image(scene_->images, texture) != nullptr;
      if (is_there && !texcoords_of(mesh, texture).empty()) list.push_back({&texture, color});
    };
    add(m.base_color_texture, true);
    add(m.normal_texture, false);
  }
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (Use& use : uses[mesh.material_of(i)]) {
      use.level = std::max(use.level, texture_level(*scene_, mesh, *use.texture, i, voxel));
    }
  }
  for (const std::vector<Use>& list : uses) {
    for (const Use& u : list) {
      use(u.color ? colors_ : data_, *u.texture, u.color, u.level > 0);
    }
  }
}

const Image8* LookTextures::find(std::span<const MipMap> maps, const TextureRef& texture,
                                 uint32_t level) {
  if (texture.image < 0 || static_cast<size_t>(texture.image) >= maps.size()) return nullptr;
  const MipMap& map = maps[static_cast<size_t>(texture.image)];
  if (map.image == nullptr) return nullptr;
  return &map.level(std::min<size_t>(level, map.smaller.size()));
}

MeshLooks::MeshLooks(const Scene& scene, const Mesh& mesh, const LookTextures& textures)
    : scene_(&scene), mesh_(&mesh), textures_(&textures) {
  if (mesh.normals.empty() && is_smooth(mesh)) computed_normals_ = compute_normals(mesh);
}

LookTexture MeshLooks::texture_of(const TextureRef& texture, bool color, uint32_t triangle,
                                  float voxel) const {
  const bool is_there = texture_image(scene_->images, texture) != nullptr;
  if (!is_there || texcoords_of(*mesh_, texture).empty()) return {};
  const uint32_t level = texture_level(*scene_, *mesh_, texture, triangle, voxel);
  const Image8* image = color ? textures_->color(texture, level) : textures_->data(texture, level);
  return {image, texture.wrap_s, texture.wrap_t, texture.nearest,
          texcoords_on(*mesh_, texture, triangle)};
}

void MeshLooks::set_normals(uint32_t triangle, float voxel, LookTriangle& out) const {
  const MeshPart& part = mesh_->parts[mesh_->triangle_part[triangle]];
  const Material& material = scene_->materials[part.material];
  const uvec3 corner = mesh_->corner_of(triangle), vertex = mesh_->triangles[triangle];
  out.face = unit_or_zero(face_of(*mesh_, triangle));
  if (!part.flat) {
    const bool computed = mesh_->normals.empty();
    out.smooth = true;
    out.normal = computed ? linear(std::span<const vec3>(computed_normals_), vertex)
                          : linear(std::span<const vec3>(mesh_->normals), corner);
  }
  out.normal_texture = texture_of(material.normal_texture, false, triangle, voxel);
  if (out.normal_texture.image == nullptr) return;
  out.normal_scale = material.normal_scale;
  if (!mesh_->tangents.empty() && !mesh_->normals.empty()) {
    out.has_tangents = true;
    out.tangent = linear(std::span<const vec4>(mesh_->tangents), corner);
    return;
  }
  const Linear<vec2>& uv = out.normal_texture.uv;
  const vec2 d1 = uv.to_second, d2 = uv.to_third;
  const vec3 a = mesh_->positions[vertex.x];
  const vec3 e1 = mesh_->positions[vertex.y] - a, e2 = mesh_->positions[vertex.z] - a;
  const float det = d1.x * d2.y - d1.y * d2.x;
  if (!(std::abs(det) > 0.0f)) return;
  const float sign = det > 0.0f ? 1.0f : -1.0f;
  out.side_u = unit_or_zero(sign * (e1 * d2.y - e2 * d1.y));
  out.side_v = unit_or_zero(sign * (e1 * d2.x - e2 * d1.x));
}

LookTriangle MeshLooks::triangle_of(uint32_t triangle, float voxel) const {
  const Material& material = scene_->materials[mesh_->material_of(triangle)];
  LookTriangle out;
  out.base = {material.base_color, vec4(0.0f), vec4(0.0f)};
  if (!mesh_->colors.empty()) {
    const Linear<vec4> color =
        linear(std::span<const vec4>(mesh_->colors), mesh_->corner_of(triangle));
    out.base = {material.base_color * color.first, material.base_color * color.to_second,
                material.base_color * color.to_third};
  }
  out.base_texture = texture_of(material.base_color_texture, true, triangle, voxel);
  if (material.alpha_mode == AlphaMode::mask) out.least_alpha = material.alpha_cutoff;
  if (material.alpha_mode == AlphaMode::blend) out.least_alpha = kLeastBlend;
  set_normals(triangle, voxel, out);
  return out;
}

uint16_t MeshLooks::mean_color() const {
  vec3 sum(0.0f);
  for (uint32_t i = 0; i < mesh_->triangles.size(); ++i) {
    sum += vec3(scene_->materials[mesh_->material_of(i)].base_color);
  }
  return pack_color(sum / static_cast<float>(std::max<size_t>(mesh_->triangles.size(), 1)));
}

void MeshLooks::operator()(const SurfaceBatch& batch) const {
  look_at_points(triangle_of(batch.triangle, batch.voxel),
                 {batch.u.data(), batch.v.data(), batch.u.size(), batch.normals.data(),
                  batch.colors.data(), batch.present.data()});
}

}  // namespace sinew
