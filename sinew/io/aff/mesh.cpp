#include "sinew/io/aff/mesh.h"

#include <cmath>
#include <utility>

namespace sinew::aff {
namespace {

constexpr float kPi = 3.14159265f;

vec3 unit_or_zero(glm::dvec3 v) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? vec3(v / length) : vec3(0.0f);
}

}  // namespace

Placement::Placement(const glm::dmat4& to_mesh) : to_mesh_(to_mesh) {
  const glm::dvec3 x(to_mesh[0]), y(to_mesh[1]), z(to_mesh[2]);
  normals_ = glm::dmat3(cross(y, z), cross(z, x), cross(x, y));
  mirrors_ = dot(x, normals_[0]) < 0.0;
  if (mirrors_) normals_ = -normals_;
}

vec3 Placement::normal(vec3 n) const {
  return unit_or_zero(normals_ * glm::dvec3(n));
}

uint32_t MeshBuilder::part(uint32_t material, bool flat) {
  const auto [entry, added] =
      parts_.try_emplace(uint64_t{material} << 1 | flat, static_cast<uint32_t>(mesh_.parts.size()));
  if (added) mesh_.parts.push_back({material, flat});
  return entry->second;
}

uint32_t MeshBuilder::corner(vec3 normal, vec2 texcoord) {
  mesh_.normals.push_back(normal);
  mesh_.texcoords[0].push_back(texcoord);
  return static_cast<uint32_t>(mesh_.normals.size() - 1);
}

void MeshBuilder::add(const Primitive& in, const Placement& placement) {
  const bool flat = in.normals.empty();
  const uint32_t part_index = part(in.material, flat);
  const auto first = static_cast<uint32_t>(mesh_.positions.size());
  for (const vec3& p : in.positions) mesh_.positions.push_back(placement.point(p));
  smooth_ |= !flat;
  textured_ |= !in.texcoords.empty();

  std::vector<vec3> normals;
  for (const vec3& n : in.normals) normals.push_back(placement.normal(n));
  // Corners that are equal are stored once; by the indices of their normal and coordinate.
  std::unordered_map<uint64_t, uint32_t> known;
  for (size_t i = 0; i < in.triangles.size(); ++i) {
    const uvec3 t = in.triangles[i];
    const uvec3 n = in.triangle_normals.empty() ? t : in.triangle_normals[i];
    const uvec3 uv = in.triangle_texcoords.empty() ? t : in.triangle_texcoords[i];
    uvec3 corners;
    for (int k = 0; k < 3; ++k) {
      const uint64_t normal_index = flat ? 0 : n[k];
      const uint64_t texcoord_index = in.texcoords.empty() ? 0 : uv[k];
      const auto [entry, added] = known.try_emplace(normal_index << 32 | texcoord_index, 0);
      if (added) {
        const vec3 normal = flat ? vec3(0.0f) : normals[n[k]];
        const bool none = normal == vec3(0.0f);  // its part is flat, or the file is at fault
        entry->second = corner(none ? vec3(0.0f, 1.0f, 0.0f) : normal,
                               in.texcoords.empty() ? vec2(0.0f) : in.texcoords[uv[k]]);
      }
      corners[k] = entry->second;
    }
    mesh_.triangles.push_back(placement.order(t + first));
    mesh_.corners.push_back(placement.order(corners));
    mesh_.triangle_part.push_back(part_index);
  }
}

Mesh MeshBuilder::take() {
  if (!smooth_) mesh_.normals.clear();
  if (!textured_) mesh_.texcoords[0].clear();
  if (!smooth_ && !textured_) mesh_.corners.clear();
  Mesh result = std::move(mesh_);
  *this = MeshBuilder();
  return result;
}

Tessellation tessellate_sphere(vec3 center, float radius) {
  constexpr uint32_t kAround = kRoundSegments, kDown = kRoundSegments / 2;
  Tessellation out;
  const float side = radius < 0.0f ? -1.0f : 1.0f;
  const auto add = [&](vec3 direction) {
    out.positions.push_back(center + std::abs(radius) * direction);
    out.normals.push_back(side * direction);
  };
  add(vec3(0.0f, 1.0f, 0.0f));
  for (uint32_t ring = 1; ring < kDown; ++ring) {
    const float theta = kPi * static_cast<float>(ring) / kDown;
    for (uint32_t i = 0; i < kAround; ++i) {
      const float phi = 2.0f * kPi * static_cast<float>(i) / kAround;
      add(vec3(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi)));
    }
  }
  add(vec3(0.0f, -1.0f, 0.0f));
  const auto vertex = [](uint32_t ring, uint32_t i) {
    return 1 + (ring - 1) * kAround + i % kAround;
  };
  const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
    out.triangles.push_back(side > 0.0f ? uvec3(a, b, c) : uvec3(a, c, b));
  };
  const auto last = static_cast<uint32_t>(out.positions.size() - 1);
  for (uint32_t i = 0; i < kAround; ++i) {
    triangle(0, vertex(1, i), vertex(1, i + 1));
    for (uint32_t ring = 1; ring + 1 < kDown; ++ring) {
      triangle(vertex(ring, i), vertex(ring + 1, i), vertex(ring + 1, i + 1));
      triangle(vertex(ring, i), vertex(ring + 1, i + 1), vertex(ring, i + 1));
    }
    triangle(last, vertex(kDown - 1, i + 1), vertex(kDown - 1, i));
  }
  return out;
}

Tessellation tessellate_cone(vec3 base, float base_radius, vec3 apex, float apex_radius) {
  Tessellation out;
  const bool inside = base_radius < 0.0f || apex_radius < 0.0f;
  const float r0 = std::abs(base_radius), r1 = std::abs(apex_radius);
  const vec3 along = apex - base;
  const float height = length(along);
  const vec3 axis = along / height;
  const vec3 helper = std::abs(axis.x) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
  const vec3 x = normalize(cross(helper, axis)), y = cross(axis, x);
  for (uint32_t i = 0; i < kRoundSegments; ++i) {
    const float phi = 2.0f * kPi * static_cast<float>(i) / kRoundSegments;
    const vec3 outwards = std::cos(phi) * x + std::sin(phi) * y;
    const vec3 normal = normalize(outwards * height + axis * (r0 - r1)) * (inside ? -1.0f : 1.0f);
    out.positions.push_back(base + r0 * outwards);
    out.positions.push_back(apex + r1 * outwards);
    out.normals.insert(out.normals.end(), 2, normal);
  }
  const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
    out.triangles.push_back(inside ? uvec3(a, c, b) : uvec3(a, b, c));
  };
  for (uint32_t i = 0; i < kRoundSegments; ++i) {
    const uint32_t a = 2 * i, b = 2 * ((i + 1) % kRoundSegments);
    if (r0 > 0.0f) triangle(a, b, b + 1);
    if (r1 > 0.0f) triangle(a, b + 1, a + 1);
  }
  return out;
}

}  // namespace sinew::aff
