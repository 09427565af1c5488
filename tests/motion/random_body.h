// A body with random data for every kind of motion, and poses for it.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/motion/motion.h"

namespace sinew::test {

inline Affine random_affine(Random& random, float size) {
  return Affine(random.uniform3(-size, size), random.uniform3(-size, size),
                random.uniform3(-size, size), random.uniform3(-size, size));
}

inline std::vector<vec3> random_points(Random& random, size_t count, float size) {
  std::vector<vec3> points(count);
  for (vec3& p : points) p = random.uniform3(-size, size);
  return points;
}

struct RandomBody {
  static constexpr uint32_t kTargets = 5, kKeys = 4, kJoints = 7;

  uint32_t influences;
  std::vector<vec3> rest, deltas, keys, free;
  std::vector<uint16_t> joint_indices;
  std::vector<float> skin_weights;
  std::vector<Affine> joints;
  std::vector<float> morph_weights;
  Pose pose;

  RandomBody(uint32_t seed, uint32_t vertices, uint32_t influences_) : influences(influences_) {
    Random random(seed);
    rest = random_points(random, vertices, 2.0f);
    deltas = random_points(random, size_t{vertices} * kTargets, 0.5f);
    keys = random_points(random, size_t{vertices} * kKeys, 3.0f);
    free = random_points(random, vertices, 4.0f);
    for (uint32_t v = 0; v < vertices; ++v) add_influences(random);
    for (uint32_t j = 0; j < kJoints; ++j) joints.push_back(random_affine(random, 2.0f));
    for (uint32_t t = 0; t < kTargets; ++t) {
      morph_weights.push_back(t == 2 ? 0.0f : random.uniform(-1.0f, 1.0f));
    }
    pose.joints = joints;
    pose.weights = morph_weights;
    pose.key = random.next() % (kKeys - 1);
    pose.key_fraction = random.uniform();
    pose.positions = free;
  }
  RandomBody(const RandomBody&) = delete;

  SkinMotion skin() const { return {rest, influences, joint_indices, skin_weights, kJoints}; }
  std::array<Motion, 6> motions() const {
    const uint32_t vertices = static_cast<uint32_t>(rest.size());
    return {RigidMotion{rest},
            skin(),
            MorphMotion{rest, deltas, {}},
            MorphMotion{rest, deltas, skin()},
            KeyframeMotion{vertices, keys},
            FreeMotion{vertices}};
  }

 private:
  // The last influence of every other vertex is unused.
  void add_influences(Random& random) {
    const size_t begin = skin_weights.size();
    float sum = 0.0f;
    for (uint32_t k = 0; k < influences; ++k) {
      const bool unused = k > 0 && k + 1 == influences && random.next() % 2 == 0;
      joint_indices.push_back(unused ? uint16_t{0} : uint16_t(random.next() % kJoints));
      skin_weights.push_back(unused ? 0.0f : random.uniform(0.05f, 1.0f));
      sum += skin_weights.back();
    }
    for (uint32_t k = 0; k < influences; ++k) skin_weights[begin + k] /= sum;
  }
};

}  // namespace sinew::test
