#include "sinew/io/aff/animated.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace sinew::aff {
namespace {

constexpr size_t kLeastOfSphere = 16;
constexpr float kSphereTolerance = 1e-4f;  // of the radius

// The bytes of one corner's positions over all keys, to find equal ones.
std::string_view bytes_of(const std::vector<vec3>& positions) {
  return {reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(vec3)};
}

}  // namespace

Mesh make_animated_mesh(const AnimatedTriangles& in) {
  const size_t keys = in.times.size(), corners = in.materials.size() * 3;
  Mesh mesh;
  std::unordered_map<std::string, uint32_t> vertices;
  std::vector<std::vector<vec3>> tracks;  // one a vertex
  std::vector<uint32_t> index(corners);
  std::vector<vec3> track(keys);
  for (size_t c = 0; c < corners; ++c) {
    for (size_t k = 0; k < keys; ++k) {
      track[k] = in.positions[(c / 3 * keys + k) * 3 + c % 3] + 0.0f;  // no negative zeros
    }
    const auto [entry, added] =
        vertices.try_emplace(std::string(bytes_of(track)), static_cast<uint32_t>(tracks.size()));
    if (added) tracks.push_back(track);
    index[c] = entry->second;
  }
  mesh.keys = static_cast<uint32_t>(keys);
  mesh.key_positions.resize(keys * tracks.size());
  for (size_t v = 0; v < tracks.size(); ++v) {
    for (size_t k = 0; k < keys; ++k) mesh.key_positions[k * tracks.size() + v] = tracks[v][k];
  }
  mesh.positions.assign(mesh.key_positions.begin(),
                        mesh.key_positions.begin() + static_cast<ptrdiff_t>(tracks.size()));

  const bool flat = in.flat_votes >= in.smooth_votes;
  std::unordered_map<uint32_t, uint32_t> parts;  // of materials
  for (size_t t = 0; t < in.materials.size(); ++t) {
    const auto [part, added] =
        parts.try_emplace(in.materials[t], static_cast<uint32_t>(mesh.parts.size()));
    if (added) mesh.parts.push_back({in.materials[t], flat});
    mesh.triangles.emplace_back(index[3 * t], index[3 * t + 1], index[3 * t + 2]);
    mesh.triangle_part.push_back(part->second);
  }
  return mesh;
}

std::optional<int> complexity_of(size_t triangles) {
  int n = 0;
  for (; triangles > 1 && triangles % 4 == 0; triangles /= 4) ++n;
  return triangles == 1 ? std::optional(n) : std::nullopt;
}

// |p|^2 = 2 c.p + (r^2 - |c|^2) is linear in c and the bracket: least squares about the mean.
std::optional<Sphere> sphere_through(std::span<const vec3> points) {
  if (points.size() < kLeastOfSphere) return std::nullopt;
  glm::dvec3 mean(0.0);
  for (const vec3& p : points) mean += glm::dvec3(p) / static_cast<double>(points.size());
  glm::dmat4 normal(0.0);
  glm::dvec4 right(0.0);
  for (const vec3& p : points) {
    const glm::dvec3 d = glm::dvec3(p) - mean;
    const glm::dvec4 row(2.0 * d, 1.0);
    normal += glm::outerProduct(row, row);
    right += row * dot(d, d);
  }
  const double spread = normal[0][0] + normal[1][1] + normal[2][2];
  const double determinant = glm::determinant(normal);
  if (!(determinant > 1e-9 * spread * spread * spread)) return std::nullopt;  // flat
  const glm::dvec4 solution = glm::inverse(normal) * right;
  const glm::dvec3 offset(solution);
  const Sphere sphere{vec3(mean + offset),
                      static_cast<float>(std::sqrt(solution.w + dot(offset, offset)))};
  for (const vec3& p : points) {
    const float off = std::abs(distance(p, sphere.center) - sphere.radius);
    if (!(off <= kSphereTolerance * sphere.radius)) return std::nullopt;
  }
  return sphere;
}

namespace {

// The edges of a mesh's triangles, each once; its middle is the vertex first + index.
struct Middles {
  uint32_t first = 0;
  std::vector<std::pair<uint32_t, uint32_t>> ends;
  std::unordered_map<uint64_t, uint32_t> index;

  uint32_t between(uint32_t a, uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [entry, added] =
        index.try_emplace(uint64_t{a} << 32 | b, static_cast<uint32_t>(ends.size()));
    if (added) ends.emplace_back(a, b);
    return first + entry->second;
  }
};

}  // namespace

void subdivide(Mesh& mesh) {
  const size_t before = mesh.positions.size();
  Middles middles;
  middles.first = static_cast<uint32_t>(before);
  std::vector<uvec3> triangles;
  std::vector<uint32_t> parts;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const uvec3 v = mesh.triangles[t];
    const uint32_t xy = middles.between(v.x, v.y), yz = middles.between(v.y, v.z),
                   zx = middles.between(v.z, v.x);
    for (const uvec3 child :
         {uvec3(v.x, xy, zx), uvec3(xy, v.y, yz), uvec3(zx, yz, v.z), uvec3(xy, yz, zx)}) {
      triangles.push_back(child);
      parts.push_back(mesh.triangle_part[t]);
    }
  }
  std::vector<vec3> positions;
  for (uint32_t key = 0; key < mesh.keys; ++key) {
    const std::span<const vec3> old(mesh.key_positions.data() + key * before, before);
    const auto sphere = sphere_through(old);
    positions.insert(positions.end(), old.begin(), old.end());
    for (const auto& [a, b] : middles.ends) {
      vec3 middle = 0.5f * (old[a] + old[b]);
      if (sphere) {
        const vec3 from_center = middle - sphere->center;
        const float l = length(from_center);
        if (l > 0.0f) middle = sphere->center + from_center * (sphere->radius / l);
      }
      positions.push_back(middle);
    }
  }
  mesh.key_positions = std::move(positions);
  mesh.positions.assign(
      mesh.key_positions.begin(),
      mesh.key_positions.begin() + static_cast<ptrdiff_t>(before + middles.ends.size()));
  mesh.triangles = std::move(triangles);
  mesh.triangle_part = std::move(parts);
}

}  // namespace sinew::aff
