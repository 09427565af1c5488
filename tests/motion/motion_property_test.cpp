// What holds for every motion over random bodies and poses: agreement with a twin in double, the
// same bits in every form, and containment.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "motion/random_body.h"
#include "sinew/motion/motion.h"

namespace sinew {
namespace {

using glm::dvec3;
using test::RandomBody;

// A position in double, and the sum of the magnitudes that were added to get it.
struct Twin {
  dvec3 value{0.0};
  dvec3 magnitude{0.0};

  void add(double factor, dvec3 v) {
    value += factor * v;
    magnitude += std::abs(factor) * glm::abs(v);
  }
};

Twin morphed(const RandomBody& body, uint32_t vertex) {
  Twin twin;
  twin.add(1.0, body.rest[vertex]);
  for (size_t t = 0; t < body.morph_weights.size(); ++t) {
    twin.add(body.morph_weights[t], body.deltas[t * body.rest.size() + vertex]);
  }
  return twin;
}

// sum_k w_k (M_k p): the joints move the point first, other than in the library.
Twin skinned(const RandomBody& body, uint32_t vertex, const Twin& p) {
  Twin twin;
  for (uint32_t k = 0; k < body.influences; ++k) {
    const size_t at = size_t{vertex} * body.influences + k;
    const Affine& joint = body.joints[body.joint_indices[at]];
    const double weight = body.skin_weights[at];
    for (int axis = 0; axis < 3; ++axis) {
      twin.value += weight * p.value[axis] * dvec3(joint[axis]);
      twin.magnitude += weight * p.magnitude[axis] * glm::abs(dvec3(joint[axis]));
    }
    twin.add(weight, joint[3]);
  }
  return twin;
}

Twin twin_of(const RandomBody& body, size_t motion, uint32_t vertex) {
  Twin rest;
  rest.add(1.0, body.rest[vertex]);
  Twin out;
  switch (motion) {
    case 0:
      return rest;
    case 1:
      return skinned(body, vertex, rest);
    case 2:
      return morphed(body, vertex);
    case 3:
      return skinned(body, vertex, morphed(body, vertex));
    case 4:
      out.add(1.0 - body.pose.key_fraction, body.keys[body.pose.key * body.rest.size() + vertex]);
      out.add(body.pose.key_fraction, body.keys[(body.pose.key + 1) * body.rest.size() + vertex]);
      return out;
    default:
      out.add(1.0, body.free[vertex]);
      return out;
  }
}

class MotionProperty : public testing::TestWithParam<uint32_t> {};

TEST_P(MotionProperty, AgreesWithItsTwinInDouble) {
  const RandomBody body(GetParam(), 200, 1 + GetParam() % 9);
  const auto motions = body.motions();
  for (size_t m = 0; m < motions.size(); ++m) {
    std::vector<vec3> out(body.rest.size());
    positions(motions[m], body.pose, 0, out);
    for (uint32_t v = 0; v < out.size(); ++v) {
      const Twin twin = twin_of(body, m, v);
      // Roundings: two a target, two an influence, six in the transform, with some to spare.
      const double gamma = (2.0 * RandomBody::kTargets + 2.0 * body.influences + 8.0) * 0x1p-24;
      const dvec3 error = glm::abs(dvec3(out[v]) - twin.value);
      EXPECT_TRUE(glm::all(glm::lessThanEqual(error, gamma * twin.magnitude)))
          << "seed " << GetParam() << ", motion " << m << ", vertex " << v;
    }
  }
}

TEST_P(MotionProperty, RangesAndListsGiveTheSameBits) {
  const uint32_t seed = GetParam();
  const uint32_t count = 1500;  // more than one block of morphing
  const RandomBody body(seed, count, 1 + seed % 9);
  Random random(seed + 1000);
  for (const Motion& motion : body.motions()) {
    std::vector<vec3> whole(count);
    positions(motion, body.pose, 0, whole);

    std::vector<vec3> pieces(count);
    for (uint32_t first = 0; first < count;) {
      const uint32_t size = std::min(count - first, 1 + random.next() % 700);
      positions(motion, body.pose, first, std::span(pieces).subspan(first, size));
      first += size;
    }
    EXPECT_EQ(std::memcmp(whole.data(), pieces.data(), count * sizeof(vec3)), 0) << seed;

    std::vector<uint32_t> list(count);
    for (uint32_t& vertex : list) vertex = random.next() % count;
    std::vector<vec3> listed(count);
    positions(motion, body.pose, list, listed);
    for (uint32_t i = 0; i < count; ++i) {
      ASSERT_EQ(std::memcmp(&listed[i], &whole[list[i]], sizeof(vec3)), 0) << seed;
    }
  }
}

TEST_P(MotionProperty, BoundsContainAndAreTight) {
  const RandomBody body(GetParam(), 300, 1 + GetParam() % 9);
  Random random(GetParam() + 2000);
  for (const Motion& motion : body.motions()) {
    std::vector<uint32_t> list(1 + random.next() % 80);
    for (uint32_t& vertex : list) vertex = random.next() % 300;
    std::vector<vec3> points(list.size());
    positions(motion, body.pose, list, points);
    const Box box = bounds(motion, body.pose, list);
    vec3 low = points[0], high = points[0];
    for (const vec3 p : points) {
      EXPECT_TRUE(box.contains(p)) << "seed " << GetParam();
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    EXPECT_EQ(box.min, low) << "seed " << GetParam();
    EXPECT_EQ(box.max, high) << "seed " << GetParam();
  }
}

// Moving a vertex's rest position moves its posed position by the local map (keyframes and free
// bodies have no rest position that counts).
TEST_P(MotionProperty, LocalMapIsTheDerivative) {
  RandomBody body(GetParam(), 50, 1 + GetParam() % 9);
  const auto motions = body.motions();
  const vec3 step(0.5f, -0.25f, 0.125f);
  for (size_t m = 0; m < 4; ++m) {
    std::vector<vec3> before(50), after(50);
    positions(motions[m], body.pose, 0, before);
    for (vec3& p : body.rest) p += step;
    positions(motions[m], body.pose, 0, after);
    for (vec3& p : body.rest) p -= step;
    for (uint32_t v = 0; v < 50; ++v) {
      const vec3 error = after[v] - before[v] - local_map(motions[m], body.pose, v) * step;
      EXPECT_LT(length(error), 2e-5f) << "seed " << GetParam() << ", motion " << m;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, MotionProperty, testing::Range(1u, 19u));

}  // namespace
}  // namespace sinew
