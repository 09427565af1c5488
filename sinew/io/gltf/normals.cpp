#include "sinew/io/gltf/normals.h"

#include <cmath>

namespace sinew::gltf {
namespace {

constexpr double kTiny = 1e-30;  // directions shorter than this have no meaning

bool normalize_in_place(vec3& v) {
  const glm::dvec3 wide(v);
  const double size = length(wide);
  if (!(size > kTiny)) return false;
  v = vec3(wide / size);
  return true;
}

vec3 any_across(vec3 normal) {
  const vec3 axis = std::abs(normal.x) < 0.5f ? vec3(1, 0, 0) : vec3(0, 1, 0);
  return normalize(cross(normal, axis));
}

}  // namespace

uint64_t repair_normals(Mesh& mesh) {
  uint64_t missing = 0;
  std::vector<bool> lost(mesh.normals.size(), false);
  for (size_t v = 0; v < mesh.normals.size(); ++v) {
    lost[v] = !normalize_in_place(mesh.normals[v]);
    missing += lost[v];
  }
  if (missing == 0) return 0;

  std::vector<glm::dvec3> sums(mesh.normals.size(), glm::dvec3(0.0));
  for (const uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    const glm::dvec3 area = cross(b - a, c - a);
    for (int k = 0; k < 3; ++k) sums[t[k]] += area;
  }
  for (size_t v = 0; v < lost.size(); ++v) {
    if (!lost[v]) continue;
    const double size = length(sums[v]);
    mesh.normals[v] = size > 0.0 ? vec3(sums[v] / size) : vec3(0, 0, 1);
  }
  return missing;
}

void repair_tangents(Mesh& mesh) {
  for (size_t v = 0; v < mesh.tangents.size(); ++v) {
    vec3 direction(mesh.tangents[v]);
    if (!normalize_in_place(direction)) direction = any_across(mesh.normals[v]);
    mesh.tangents[v] = vec4(direction, mesh.tangents[v].w < 0.0f ? -1.0f : 1.0f);
  }
}

}  // namespace sinew::gltf
