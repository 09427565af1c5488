// The slow, obvious twin of every ray query: brute force over all triangles in double, with bounds
// on what float arithmetic may decide differently.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/math/ray.h"
#include "sinew/math/vec.h"

namespace sinew::test {

// A triangle as the ray sees it. Float arithmetic may decide either way where edge functions lie
// within its error bound of zero; then the triangle is neither surely hit nor surely missed.
struct ExactHit {
  bool sure_hit = false;  // of the plane region, whatever t is
  bool sure_miss = false;
  double t = 0.0;        // where the ray meets the plane
  double t_error = 0.0;  // bound on the float error of t
};

// `slack` bounds how far coordinates may be off before the test begins: the rounding of placements.
inline ExactHit exact_hit(const Ray& ray, vec3 v0, vec3 v1, vec3 v2, double slack = 0.0) {
  constexpr double kUnit = 5.97e-8;
  const glm::dvec3 d(ray.direction), o(ray.origin);
  int kz = 0;
  for (int k = 1; k < 3; ++k) kz = std::abs(d[k]) > std::abs(d[kz]) ? k : kz;
  const int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
  double x[3], y[3], z[3], reach_x = 0, reach_y = 0;
  const vec3 corners[3] = {v0, v1, v2};
  for (int c = 0; c < 3; ++c) {
    const glm::dvec3 p = glm::dvec3(corners[c]) - o;
    const double sx = d[kx] / d[kz] * p[kz], sy = d[ky] / d[kz] * p[kz];
    x[c] = p[kx] - sx;
    y[c] = p[ky] - sy;
    z[c] = p[kz] / d[kz];
    reach_x = std::max(reach_x, std::abs(p[kx]) + std::abs(sx));
    reach_y = std::max(reach_y, std::abs(p[ky]) + std::abs(sy));
  }
  double e[3], det = 0, sum = 0, sum_abs = 0, error_abs = 0;
  ExactHit out;
  int negative = 0, positive = 0;  // edge functions that surely are
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 2) % 3, b = (i + 1) % 3;
    e[i] = x[a] * y[b] - y[a] * x[b];
    // Every sheared coordinate carries about four roundings of its reach.
    const double off_x = 4 * kUnit * reach_x + 2 * slack, off_y = 4 * kUnit * reach_y + 2 * slack;
    const double error = off_x * (std::abs(y[a]) + std::abs(y[b])) +
                         off_y * (std::abs(x[a]) + std::abs(x[b])) + 2 * off_x * off_y;
    negative += e[i] < -error;
    positive += e[i] > error;
    det += e[i];
    sum += e[i] * z[i];
    sum_abs += std::abs(e[i] * z[i]);
    error_abs += error;
  }
  out.sure_miss = negative > 0 && positive > 0;
  out.sure_hit = negative == 3 || positive == 3;
  if (det == 0) return out;
  const double z_reach = std::max({std::abs(z[0]), std::abs(z[1]), std::abs(z[2])});
  out.t = sum / det;
  out.t_error = (error_abs * (z_reach + std::abs(out.t)) + 16 * kUnit * sum_abs) / std::abs(det) +
                8 * kUnit * std::abs(out.t) + 2 * slack / std::abs(d[kz]);
  return out;
}

// Where the closest hit may lie as far as float arithmetic can tell. `slack` is empty or holds one
// value a triangle.
struct Verdict {
  bool certain = false;  // exactly one answer is right: `primitive` (or nothing)
  uint32_t primitive = kNoObject;
  double t = std::numeric_limits<double>::infinity();
  double t_error = 0.0;
};

inline Verdict brute_force(const Ray& ray, std::span<const vec3> positions,
                           std::span<const uvec3> triangles, std::span<const float> slack = {}) {
  Verdict best;
  double first_doubtful = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, double>> others;  // (t, error) of sure hits
  for (size_t i = 0; i < triangles.size(); ++i) {
    const uvec3 t = triangles[i];
    const ExactHit hit = exact_hit(ray, positions[t.x], positions[t.y], positions[t.z],
                                   slack.empty() ? 0.0 : double{slack[i]});
    const bool sure_behind = hit.t < ray.t_min - hit.t_error || hit.t > ray.t_max + hit.t_error;
    if (hit.sure_miss || sure_behind) continue;
    const bool sure_ahead = hit.t > ray.t_min + hit.t_error && hit.t < ray.t_max - hit.t_error;
    if (!hit.sure_hit || !sure_ahead) {
      first_doubtful = std::min(first_doubtful, hit.t - hit.t_error);
      continue;
    }
    others.emplace_back(hit.t, hit.t_error);
    if (hit.t < best.t) {
      best.primitive = static_cast<uint32_t>(i);
      best.t = hit.t;
      best.t_error = hit.t_error;
    }
  }
  int near = 0;
  for (const auto& [t, error] : others) near += t - error <= best.t + best.t_error;
  const bool doubt = std::isfinite(first_doubtful) && first_doubtful <= best.t + best.t_error;
  best.certain = near <= 1 && !doubt;
  return best;
}

// How a set of answers compares with the truth.
struct Agreement {
  uint64_t rays = 0, certain = 0, wrong = 0, hits = 0;
  std::string first_wrong;

  double doubtful_fraction() const {
    return rays == 0 ? 0.0 : double(rays - certain) / double(rays);
  }
};

inline void judge(const Ray& ray, const Hit& hit, const Verdict& truth, Agreement& out) {
  ++out.rays;
  out.hits += static_cast<bool>(hit);
  if (!truth.certain) return;
  ++out.certain;
  const bool truly_hit = truth.primitive != kNoObject;
  const bool same = truly_hit == static_cast<bool>(hit) &&
                    (!truly_hit || (hit.primitive == truth.primitive &&
                                    std::abs(double{hit.t} - truth.t) <= truth.t_error));
  if (same) return;
  if (out.wrong++ == 0) {
    out.first_wrong = "origin " + std::to_string(ray.origin.x) + " " +
                      std::to_string(ray.origin.y) + " " + std::to_string(ray.origin.z) +
                      ": got triangle " + std::to_string(hit.primitive) + " at " +
                      std::to_string(hit.t) + ", truth is " + std::to_string(truth.primitive) +
                      " at " + std::to_string(truth.t);
  }
}

// Rays of the kinds that rendering makes: towards points on triangles from outside, and from points
// on triangles outwards.
inline std::vector<Ray> test_rays(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                  size_t count, uint32_t seed) {
  Random random(seed);
  vec3 low(std::numeric_limits<float>::infinity()), high(-low);
  for (const uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      low = glm::min(low, positions[t[k]]);
      high = glm::max(high, positions[t[k]]);
    }
  }
  const vec3 center = 0.5f * (low + high);
  const float radius = length(high - low);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    const uvec3 t = triangles[random.next() % triangles.size()];
    float u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const vec3 target = positions[t.x] * (1 - u - v) + positions[t.y] * u + positions[t.z] * v;
    if (random.uniform() < 0.5f) {
      ray.origin = center + random.direction() * radius;
      ray.direction = target - ray.origin;
      if (random.uniform() < 0.5f) ray.direction = normalize(ray.direction);
    } else {
      ray.direction = random.direction();
      ray.origin = target + ray.direction * (radius * 1e-4f);
    }
  }
  return rays;
}

}  // namespace sinew::test
