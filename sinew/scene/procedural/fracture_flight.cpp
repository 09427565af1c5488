// Free flight of a rigid piece with impulses at the ground.
// Based on: B. Mirtich, J. Canny, "Impulse-based Simulation of Rigid Bodies", I3D 1995; here with
// the inertia of a ball and one contact point a step.
#include <algorithm>
#include <cmath>

#include "sinew/scene/procedural/fracture.h"

namespace sinew {
namespace {

constexpr float kStep = 1.0f / 480.0f;  // seconds

struct Body {
  std::vector<vec3> points;  // relative to the centre, at rest
  float radius = 0.0f;       // of a ball around all points
  float inertia = 1.0f;      // a unit of mass
  PiecePose pose;
  vec3 velocity{0.0f};
  vec3 spin{0.0f};
};

// The points that lie farthest out in some direction: enough for contact.
std::vector<vec3> support_points(std::span<const vec3> points, vec3 center) {
  constexpr int kDirections = 256;
  std::vector<vec3> support;
  for (int i = 0; i < kDirections; ++i) {
    const float y = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / kDirections;
    const float r = std::sqrt(1.0f - y * y), angle = 2.39996323f * static_cast<float>(i);
    const vec3 direction(r * std::cos(angle), y, r * std::sin(angle));
    const vec3 farthest =
        *std::ranges::max_element(points, {}, [&](const vec3& p) { return dot(p, direction); });
    support.push_back(farthest - center);
  }
  return support;
}

// Stops the lowest point if it is below the ground and sinks.
void collide(Body& body, const FlightConfig& config) {
  if (body.pose.center.y > body.radius) return;
  vec3 arm(0.0f);
  float lowest = 0.0f;
  for (const vec3 p : body.points) {
    const vec3 r = body.pose.rotation * p;
    if (body.pose.center.y + r.y < lowest) {
      lowest = body.pose.center.y + r.y;
      arm = r;
    }
  }
  if (lowest >= 0.0f) return;
  body.pose.center.y -= lowest;
  const vec3 velocity = body.velocity + cross(body.spin, arm);
  if (velocity.y >= 0.0f) return;
  // Effective inverse mass along a direction, for a unit mass with the inertia of a ball.
  const auto inverse_mass = [&](vec3 direction) {
    const vec3 turn = cross(arm, direction);
    return 1.0f + dot(turn, turn) / body.inertia;
  };
  const auto push = [&](vec3 impulse) {
    body.velocity += impulse;
    body.spin += cross(arm, impulse) / body.inertia;
  };
  const vec3 up(0.0f, 1.0f, 0.0f);
  const float bounce = velocity.y < -0.4f ? config.restitution : 0.0f;
  const float normal_impulse = -(1.0f + bounce) * velocity.y / inverse_mass(up);
  push(normal_impulse * up);
  const vec3 sliding(velocity.x, 0.0f, velocity.z);
  const float speed = length(sliding);
  if (speed > 1e-6f) {
    const vec3 direction = sliding / speed;
    push(-std::min(config.friction * normal_impulse, speed / inverse_mass(direction)) * direction);
  }
  body.spin *= 0.985f;
}

void advance(Body& body, const FlightConfig& config) {
  body.velocity.y -= config.gravity * kStep;
  body.pose.center += kStep * body.velocity;
  const float rate = length(body.spin);
  if (rate > 1e-6f) {
    body.pose.rotation =
        normalize(glm::angleAxis(rate * kStep, body.spin / rate) * body.pose.rotation);
  }
  collide(body, config);
}

}  // namespace

std::vector<PiecePose> fly(std::span<const vec3> points, vec3 center, const FlightConfig& config,
                           std::span<const float> times) {
  Body body;
  body.points = support_points(points, center);
  body.pose.center = center;
  body.velocity = config.velocity;
  body.spin = config.spin;
  float radius_squared = 0.0f;
  for (const vec3 p : body.points) radius_squared = std::max(radius_squared, dot(p, p));
  body.radius = std::sqrt(radius_squared);
  body.inertia = 0.25f * radius_squared;

  std::vector<PiecePose> poses;
  uint32_t steps = 0;
  for (const float time : times) {
    while (config.start + kStep * static_cast<float>(steps + 1) <= time) {
      advance(body, config);
      ++steps;
    }
    poses.push_back(body.pose);
  }
  return poses;
}

}  // namespace sinew
