// From a hit to a surface: interpolated attributes, textures, normals.
// Based on: glTF 2.0, sections 3.7.2, 3.9 and appendix B (what the attributes and the material
// mean); J. Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4 (2021).
// Differs from Hanika in bounding the lift, so that boxes with rounded normals leak no light.
#include "sinew/render/gbuffer.h"

#include <algorithm>
#include <cmath>

#include "sinew/render/texture.h"

namespace sinew {
namespace {

constexpr float kLeastCosine = 1e-3f;  // of the shading normal to the viewer and to the triangle
constexpr float kLargestLift = 0.15f;  // of the triangle's longest edge
constexpr float kRounding = 4e-6f;     // relative: some 64 roundings of the largest coordinate

// The three corners of a triangle and the hit's weights for them.
struct Corners {
  uvec3 vertex;  // for positions
  uvec3 corner;  // for attributes
  vec3 weight;
  // Half axes of the ellipse that the ray covers, in units of the edges from the first corner.
  vec2 major{0.0f};
  vec2 minor{0.0f};
};

Corners corners_of(const Mesh& mesh, const Hit& hit) {
  return {mesh.triangles[hit.primitive], mesh.corner_of(hit.primitive),
          vec3(1.0f - hit.u - hit.v, hit.u, hit.v)};
}

template <class T>
T interpolate(std::span<const T> values, uvec3 index, vec3 weight) {
  return values[index.x] * weight.x + values[index.y] * weight.y + values[index.z] * weight.z;
}

// A texture that can be read on this mesh: its images and where.
struct Lookup {
  const MipMap* map = nullptr;
  TexturePoint point;
};

std::span<const vec2> texcoords_of(const Mesh& mesh, const TextureRef& texture) {
  if (texture.texcoord >= std::size(mesh.texcoords)) return {};
  return mesh.texcoords[texture.texcoord];
}

Lookup look_up(const MipMap* map, const Mesh& mesh, const TextureRef& texture, const Corners& c) {
  const std::span<const vec2> uv = texcoords_of(mesh, texture);
  if (map == nullptr || uv.empty()) return {};
  const vec2 e1 = uv[c.corner.y] - uv[c.corner.x], e2 = uv[c.corner.z] - uv[c.corner.x];
  return {map,
          {interpolate(uv, c.corner, c.weight), c.major.x * e1 + c.major.y * e2,
           c.minor.x * e1 + c.minor.y * e2}};
}

vec4 untextured_color(const Mesh& mesh, const Material& material, const Corners& c) {
  vec4 color = material.base_color;
  if (!mesh.colors.empty()) {
    color *= interpolate(std::span<const vec4>(mesh.colors), c.corner, c.weight);
  }
  return color;
}

// Object-space tangent and bitangent for the normal map, before orthogonalisation.
struct Tangents {
  vec3 tangent{0.0f};
  vec3 bitangent{0.0f};
};

// Along growing u and, up in the image, shrinking v of the triangle; zero if the coordinates are
// degenerate.
Tangents tangents_of_triangle(std::span<const vec2> uv, const TextureRef& texture, const Corners& c,
                              vec3 e1, vec3 e2) {
  const vec2 uv0 = transform_texcoord(texture, uv[c.corner.x]);
  const vec2 d1 = transform_texcoord(texture, uv[c.corner.y]) - uv0;
  const vec2 d2 = transform_texcoord(texture, uv[c.corner.z]) - uv0;
  const float det = d1.x * d2.y - d1.y * d2.x;
  if (!(std::abs(det) > 0.0f)) return {};
  const float sign = det > 0.0f ? 1.0f : -1.0f;
  return {sign * (e1 * d2.y - e2 * d1.y), sign * (e1 * d2.x - e2 * d1.x)};
}

// The normal map's normal in object space; `normal` is the unit interpolated one.
vec3 map_normal(const TextureTable& textures, const ObjectAttributes& object,
                const Material& material, const Corners& c, vec3 normal, vec3 e1, vec3 e2) {
  const TextureRef& texture = material.normal_texture;
  const Lookup at = look_up(textures.data(texture), *object.mesh, texture, c);
  if (!at.map) return normal;
  vec3 n = vec3(sample_linear(*at.map, texture, at.point)) * 2.0f - 1.0f;
  n.x *= material.normal_scale;
  n.y *= material.normal_scale;

  Tangents t;
  if (object.has_tangents) {
    const vec4 tangent = tangent_at(object, c.corner.x) * c.weight.x +
                         tangent_at(object, c.corner.y) * c.weight.y +
                         tangent_at(object, c.corner.z) * c.weight.z;
    t.tangent = vec3(tangent);
    t.bitangent = cross(normal, t.tangent) * (tangent.w < 0.0f ? -1.0f : 1.0f);
  } else {
    t = tangents_of_triangle(texcoords_of(*object.mesh, material.normal_texture),
                             material.normal_texture, c, e1, e2);
  }
  const vec3 tangent = t.tangent - normal * dot(normal, t.tangent);
  const float length2 = dot(tangent, tangent);
  if (!(length2 > 0.0f)) return normal;
  const vec3 x = tangent / std::sqrt(length2);
  vec3 y = cross(normal, x);
  if (dot(y, t.bitangent) < 0.0f) y = -y;
  const vec3 mapped = x * n.x + y * n.y + normal * n.z;
  const float l = length(mapped);
  return l > 0.0f ? mapped / l : normal;
}

// Turns a unit normal the least that gives it a positive cosine to the unit vector `axis`.
vec3 bend_towards(vec3 normal, vec3 axis) {
  const float cosine = dot(normal, axis);
  return cosine >= kLeastCosine ? normal : normalize(normal + (kLeastCosine - cosine) * axis);
}

// The object-space point moved onto the mean of the tangent planes at the vertices, where it lies
// below them. `side` turns the normals to the viewer.
vec3 lift(vec3 point, const vec3 (&vertex)[3], const vec3 (&normal)[3], vec3 weight, float side) {
  vec3 shift(0.0f);
  float longest2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const vec3 n = normal[k] * side;
    shift -= weight[k] * std::min(0.0f, dot(point - vertex[k], n)) * n;
    const vec3 edge = vertex[(k + 1) % 3] - vertex[k];
    longest2 = std::max(longest2, dot(edge, edge));
  }
  const float limit = kLargestLift * std::sqrt(longest2), size = length(shift);
  return point + (size > limit ? shift * (limit / size) : shift);
}

// Sets the ellipse in which a cone of this width cuts the plane of the triangle with world-space
// edges e1 and e2, seen along the unit vector `direction`.
void cover(float width, vec3 direction, vec3 e1, vec3 e2, Corners& c) {
  const vec3 normal = cross(e1, e2);
  const float area2 = dot(normal, normal);
  if (!(area2 > 0.0f)) return;
  const vec3 n = normal / std::sqrt(area2);
  const vec3 along = direction - dot(direction, n) * n;  // as long as the angle's sine
  const float sine = length(along), cosine = std::max(std::abs(dot(direction, n)), kLeastCosine);
  const vec3 x = sine > kLeastCosine ? along / sine : normalize(e1), y = cross(n, x);
  const auto in_edges = [&](vec3 a) {
    return vec2(dot(cross(a, e2), normal), dot(cross(e1, a), normal)) / area2;
  };
  c.major = in_edges(x * (0.5f * width / cosine));
  c.minor = in_edges(y * (0.5f * width));
}

// Fills positions and normals, and says what the ray covers.
void resolve_geometry(const TextureTable& textures, const ObjectAttributes& object, const Ray& ray,
                      const RayCone& cone, const Hit& hit, const Material& material, Corners& c,
                      Surface& out) {
  const Mesh& mesh = *object.mesh;
  const vec3 vertex[3] = {position_at(object, c.vertex.x), position_at(object, c.vertex.y),
                          position_at(object, c.vertex.z)};
  const vec3 e1 = vertex[1] - vertex[0], e2 = vertex[2] - vertex[0];
  const vec3 point = vertex[0] * c.weight.x + vertex[1] * c.weight.y + vertex[2] * c.weight.z;
  const vec3 view = -normalize(ray.direction);
  out.width = cone.width + cone.spread * hit.t * length(ray.direction);
  cover(out.width, -view, mat3(object.placement) * e1, mat3(object.placement) * e2, c);

  const vec3 face = cross(e1, e2);
  vec3 geometric = object.normal_map * face;
  const float area = length(geometric);
  geometric = area > 0.0f ? geometric / area : view;  // a sliver: any normal that is seen
  const float side = dot(geometric, view) < 0.0f ? -1.0f : 1.0f;

  out.position = out.lifted = transform_point(object.placement, point);
  out.geometric_normal = geometric * side;
  out.from_behind = (side < 0.0f) != object.mirrored;
  const vec3 reach = abs(object.placement[0] * point.x) + abs(object.placement[1] * point.y) +
                     abs(object.placement[2] * point.z) + abs(object.placement[3]);
  out.footprint =
      kRounding * (std::max({reach.x, reach.y, reach.z}) + hit.t * length(ray.direction));

  const bool flat =
      object.source == NormalSource::none || mesh.parts[mesh.triangle_part[hit.primitive]].flat;
  const float face_length = length(face);
  vec3 normal = face_length > 0.0f ? face / face_length : vec3(0.0f);
  if (!flat) {
    const uvec3 index = object.normals_by_vertex() ? c.vertex : c.corner;
    const vec3 corner_normal[3] = {normal_at(object, index.x), normal_at(object, index.y),
                                   normal_at(object, index.z)};
    const vec3 mean = corner_normal[0] * c.weight.x + corner_normal[1] * c.weight.y +
                      corner_normal[2] * c.weight.z;
    const float mean_length = length(mean);
    if (mean_length > 1e-3f) {
      // Files whose vertex normals contradict their winding mean the normal, not the side.
      const float agree = dot(mean, normal) < 0.0f ? -1.0f : 1.0f;
      normal = mean * (agree / mean_length);
      out.lifted = transform_point(object.placement,
                                   lift(point, vertex, corner_normal, c.weight, side * agree));
    }
  }
  if (material.normal_texture.image >= 0) {
    normal = map_normal(textures, object, material, c, normal, e1, e2);
  }
  normal = object.normal_map * normal;
  const float normal_length = length(normal);
  normal = normal_length > 0.0f ? normal * (side / normal_length) : out.geometric_normal;
  out.normal = bend_towards(bend_towards(normal, out.geometric_normal), view);
}

// What refraction needs: the bend at the surface, and what the inside of a solid has absorbed of a
// ray that leaves it.
void resolve_medium(const Material& material, const Ray& ray, Surface& out) {
  out.bend = 1.0f;
  out.medium = vec3(1.0f);
  if (material.thin || material.transmission == 0.0f) return;
  out.bend = out.from_behind ? material.ior : 1.0f / material.ior;
  if (out.from_behind && material.attenuation_distance > 0.0f) {
    const float distance = out.hit.t * length(ray.direction);
    out.medium = pow(clamp(material.attenuation_color, 0.0f, 1.0f),
                     vec3(distance / material.attenuation_distance));
  }
}

// Fills colours and everything else that the material says of the point.
void resolve_material(const TextureTable& textures, const Mesh& mesh, const Material& material,
                      const Corners& c, Surface& out) {
  const auto color_at = [&](const TextureRef& texture) {
    const Lookup at = look_up(textures.colors(texture), mesh, texture, c);
    return at.map ? sample_srgb(*at.map, texture, at.point) : vec4(1.0f);
  };
  const auto data_at = [&](const TextureRef& texture) {
    const Lookup at = look_up(textures.data(texture), mesh, texture, c);
    return at.map ? sample_linear(*at.map, texture, at.point) : vec4(1.0f);
  };
  const vec4 base =
      max(untextured_color(mesh, material, c) * color_at(material.base_color_texture), vec4(0.0f));
  out.alpha = material.alpha_mode == AlphaMode::blend ? std::min(base.w, 1.0f) : 1.0f;
  out.unlit = material.unlit;
  if (material.unlit) {
    out.emission = vec3(base);
    out.albedo = out.specular = out.transmitted = vec3(0.0f);
    out.roughness = out.occlusion = 1.0f;
    return;
  }
  const vec4 surface = data_at(material.metallic_roughness_texture);
  const float metallic = std::clamp(material.metallic * surface.z, 0.0f, 1.0f);
  out.roughness = std::clamp(material.roughness * surface.y, 0.0f, 1.0f);
  out.specular = mix(dielectric_reflectance(material), vec3(base), metallic);
  out.grazing = 1.0f - (1.0f - material.specular) * (1.0f - metallic);
  out.albedo = vec3(base) * (1.0f - metallic);
  out.transmitted = vec3(0.0f);
  if (material.transmission > 0.0f) {
    const float share = material.transmission * data_at(material.transmission_texture).x;
    out.transmitted = min(out.albedo * share, vec3(1.0f));
    out.albedo *= 1.0f - share;
  }
  out.emission = material.emissive * vec3(color_at(material.emissive_texture));
  const float occlusion = data_at(material.occlusion_texture).x;
  out.occlusion = 1.0f + material.occlusion_strength * (occlusion - 1.0f);
}

}  // namespace

vec3 dielectric_reflectance(const Material& material) {
  const float ratio = (material.ior - 1.0f) / (material.ior + 1.0f);
  return min(ratio * ratio * material.specular_color, vec3(1.0f)) * material.specular;
}

vec4 base_color(const Scene& scene, const Mesh& mesh, const Hit& hit) {
  const Material& material = scene.materials[mesh.material_of(hit.primitive)];
  const TextureRef& texture = material.base_color_texture;
  const Corners c = corners_of(mesh, hit);
  vec4 color = untextured_color(mesh, material, c);
  const Image8* image = texture_image(scene.images, texture);
  const std::span<const vec2> uv = texcoords_of(mesh, texture);
  if (image && !uv.empty()) {
    color *= sample_srgb(*image, texture, interpolate(uv, c.corner, c.weight));
  }
  return max(color, vec4(0.0f));
}

vec3 transparency(const Scene& scene, const TextureTable& textures, const Mesh& mesh,
                  const Hit& hit) {
  Surface surface;
  resolve_material(textures, mesh, scene.materials[mesh.material_of(hit.primitive)],
                   corners_of(mesh, hit), surface);
  return 1.0f - surface.alpha + surface.alpha * surface.transmitted * (1.0f - surface.specular);
}

void resolve_surface(const Scene& scene, const TextureTable& textures,
                     const ObjectAttributes& object, const Ray& ray, const RayCone& cone,
                     const Hit& hit, Surface& out) {
  const Material& material = scene.materials[object.mesh->material_of(hit.primitive)];
  Corners corners = corners_of(*object.mesh, hit);
  out.hit = hit;
  out.voxel = 0.0f;
  resolve_geometry(textures, object, ray, cone, hit, material, corners, out);
  resolve_material(textures, *object.mesh, material, corners, out);
  resolve_medium(material, ray, out);
}

}  // namespace sinew
