#include "sinew/scene/procedural/flesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "sinew/base/check.h"

namespace sinew {
namespace {

constexpr glm::ivec3 kGrid(10, 14, 34);

}  // namespace

float smooth_min(float a, float b, float blend) {
  const float h = std::max(blend - std::abs(a - b), 0.0f);
  return std::min(a, b) - (blend > 0.0f ? 0.25f * h * h / blend : 0.0f);
}
float smooth_max(float a, float b, float blend) {
  return -smooth_min(-a, -b, blend);
}

// With the axis along t and q the distance from it, sphere s has its surface at
// sqrt((t - s)^2 + q^2) - (radius_a + m s): least where (t - s) = -m q / sqrt(1 - m^2).
float RoundCone::distance(vec3 p) const {
  const vec3 axis = b - a;
  const float length_of_axis = length(axis);
  if (length_of_axis < 1e-6f) return length(p - a) - std::max(radius_a, radius_b);
  const vec3 direction = axis / length_of_axis;
  const float t = dot(p - a, direction);
  const float q = length(p - a - t * direction);
  const float m = std::clamp((radius_b - radius_a) / length_of_axis, -0.98f, 0.98f);
  const float s = std::clamp(t + m * q / std::sqrt(1.0f - m * m), 0.0f, length_of_axis);
  return std::sqrt((t - s) * (t - s) + q * q) - (radius_a + m * s);
}

FleshBody::FleshBody(std::vector<Flesh> flesh, std::vector<int8_t> limbs, const SkinConfig& skin)
    : flesh_(std::move(flesh)), limbs_(std::move(limbs)), skin_(skin) {
  SINEW_CHECK(flesh_.size() < 256);
  for (const Flesh& f : flesh_) {
    box_.extend({f.shape.a - f.shape.radius_a, f.shape.a + f.shape.radius_a});
    box_.extend({f.shape.b - f.shape.radius_b, f.shape.b + f.shape.radius_b});
  }
  box_ = {box_.min - 0.04f, box_.max + 0.04f};
  fill_grid();
}

// Flesh farther from a cell than any blend can reach does not matter there.
void FleshBody::fill_grid() {
  const vec3 cell = box_.extent() / vec3(kGrid);
  for (uint32_t i = 0; i < flesh_.size(); ++i) all_flesh_.push_back(static_cast<uint8_t>(i));
  constexpr float kReach = 0.30f;  // three times the widest blend
  cell_start_.push_back(0);
  for (int i = 0; i < kGrid.x * kGrid.y * kGrid.z; ++i) {
    const vec3 at(i % kGrid.x, i / kGrid.x % kGrid.y, i / kGrid.x / kGrid.y);
    const vec3 middle = box_.min + cell * (at + 0.5f);
    const float slack = kReach + length(cell);
    const float value = blend_all(middle, all_flesh_);
    for (const uint8_t f : all_flesh_) {
      if (flesh_[f].shape.distance(middle) < value + slack) cell_flesh_.push_back(f);
    }
    cell_start_.push_back(static_cast<uint32_t>(cell_flesh_.size()));
  }
}

float FleshBody::blend_all(vec3 p, std::span<const uint8_t> pieces) const {
  float value = 1e3f;
  for (const uint8_t piece : pieces) {
    const Flesh& f = flesh_[piece];
    value = smooth_min(value, f.shape.distance(p), f.blend);
  }
  return value;
}

float FleshBody::field(vec3 p) const {
  const vec3 at = (p - box_.min) / box_.extent() * vec3(kGrid);
  if (!glm::all(glm::greaterThanEqual(at, vec3(0.0f))) ||
      !glm::all(glm::lessThan(at, vec3(kGrid)))) {
    return blend_all(p, all_flesh_);
  }
  const glm::ivec3 c(at);
  const uint32_t cell = static_cast<uint32_t>(c.x + kGrid.x * (c.y + kGrid.y * c.z));
  return blend_all(
      p,
      std::span(cell_flesh_).subspan(cell_start_[cell], cell_start_[cell + 1] - cell_start_[cell]));
}

uint32_t FleshBody::nearest(vec3 p) const {
  uint32_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (uint32_t i = 0; i < flesh_.size(); ++i) {
    const float distance = flesh_[i].shape.distance(p);
    if (distance >= least) continue;
    least = distance;
    best = i;
  }
  return best;
}

FleshBody::NearestLimb FleshBody::nearest_limb(std::span<const float> distances) const {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  NearestLimb result;
  float least = kFar, second = kFar;  // distances of the nearest limb, and of the nearest other
  for (size_t j = 0; j < limbs_.size(); ++j) {
    if (limbs_[j] == kTrunk) continue;
    if (distances[j] < least) {
      if (limbs_[j] != result.limb) second = least;
      least = distances[j];
      result.limb = limbs_[j];
    } else if (limbs_[j] != result.limb) {
      second = std::min(second, distances[j]);
    }
  }
  if (skin_.limb_margin > 0.0f && second < kFar) {
    result.share = glm::smoothstep(0.0f, skin_.limb_margin, second - least);
  }
  return result;
}

SkinWeights FleshBody::skin_weights(vec3 p) const {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  std::vector<float> distance(limbs_.size(), kFar), softness(limbs_.size(), 0.0f);
  for (const Flesh& f : flesh_) {
    const float d = f.shape.distance(p);
    if (d >= distance[f.joint]) continue;
    distance[f.joint] = d;
    softness[f.joint] = skin_.softness *
                        std::min(skin_.most_softness, std::max(f.shape.radius_a, f.shape.radius_b));
  }
  // Only the nearest limb counts, so that nothing bleeds from leg to leg.
  const float nearest = *std::ranges::min_element(distance);
  const NearestLimb limb = nearest_limb(distance);
  std::vector<std::pair<float, uint16_t>> candidates(limbs_.size());
  for (size_t j = 0; j < limbs_.size(); ++j) {
    const float share = limbs_[j] == kTrunk ? 1.0f : limbs_[j] == limb.limb ? limb.share : 0.0f;
    const float x = (distance[j] - nearest) / std::max(softness[j], 1e-3f);
    candidates[j] = {share > 0.0f ? share * std::exp(-x * x) : 0.0f, static_cast<uint16_t>(j)};
  }
  constexpr uint32_t n = SkinWeights::kInfluences;
  std::ranges::partial_sort(candidates, candidates.begin() + n + 1, std::greater<>());
  // Less the greatest weight left out: so a joint fades in and out without a jump.
  SkinWeights result;
  float sum = 0.0f;
  for (uint32_t k = 0; k < n; ++k) {
    const float weight = candidates[k].first - candidates[n].first + (k == 0 ? 1e-3f : 0.0f);
    result.joints[k] = candidates[k].second;
    result.weights[k] = weight > 1e-4f ? weight : 0.0f;
    sum += result.weights[k];
  }
  for (float& w : result.weights) w /= sum;
  return result;
}

}  // namespace sinew
