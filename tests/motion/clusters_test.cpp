// Derived boxes contain every position that positions() computes, bit for bit, for every motion,
// random and extreme poses; and are tight where a body is smooth.
#include "sinew/motion/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

#include "motion/random_body.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"
#include "test_data.h"

namespace sinew {
namespace {

using test::RandomBody;

struct Clusters {
  std::vector<uint32_t> first = {0}, vertices;

  operator ClusterVertices() const { return {first, vertices}; }
  uint32_t count() const { return static_cast<uint32_t>(first.size() - 1); }
  std::span<const uint32_t> operator[](uint32_t c) const {
    return std::span(vertices).subspan(first[c], first[c + 1] - first[c]);
  }
  void add(std::vector<uint32_t> list) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    vertices.insert(vertices.end(), list.begin(), list.end());
    first.push_back(static_cast<uint32_t>(vertices.size()));
  }
};

// Overlapping lists of 0 to 40 vertices anywhere in the body, the worst that can be asked for.
Clusters random_clusters(Random& random, uint32_t vertices, uint32_t count) {
  Clusters out;
  for (uint32_t c = 0; c < count; ++c) {
    std::vector<uint32_t> list(random.next() % 41);
    for (uint32_t& v : list) v = random.next() % vertices;
    out.add(std::move(list));
  }
  return out;
}

// Runs of `size` triangles in an order in which neighbours are near each other.
Clusters runs_of_triangles(std::span<const vec3> positions, std::span<const uvec3> triangles,
                           uint32_t size) {
  Box box;
  for (const vec3 p : positions) box.extend(p);
  const float cell = std::cbrt(half_area(box) / float(triangles.size()) * float(size));
  std::vector<std::pair<uint32_t, uint32_t>> order;  // cell, triangle
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const vec3 middle =
        (positions[triangles[t].x] + positions[triangles[t].y] + positions[triangles[t].z]) / 3.0f;
    const glm::uvec3 at((middle - box.min) / (2.0f * std::max(cell, 1e-6f)));
    order.emplace_back((at.x * 512 + at.y) * 512 + at.z, t);
  }
  std::ranges::sort(order);
  Clusters out;
  for (size_t begin = 0; begin < order.size(); begin += size) {
    std::vector<uint32_t> list;
    for (size_t i = begin; i < std::min(order.size(), begin + size); ++i) {
      const uvec3 t = triangles[order[i].second];
      list.insert(list.end(), {t.x, t.y, t.z});
    }
    out.add(std::move(list));
  }
  return out;
}

// Half areas over all clusters.
struct Areas {
  double derived = 0.0, exact = 0.0;
};

// Every cluster's box, and the body's, must contain the finite positions.
void expect_contains(const ClusterBounds& bounds, const Motion& motion, const Clusters& clusters,
                     const Pose& pose, Areas& areas) {
  std::vector<Box> derived(clusters.count());
  derive_bounds(bounds, motion, pose, 0, derived);
  const Box body = derive_body_bounds(bounds, motion, pose);
  for (uint32_t c = 0; c < clusters.count(); ++c) {
    Box exact;
    std::vector<vec3> points(clusters[c].size());
    positions(motion, pose, clusters[c], points);
    for (const vec3 p : points) {
      if (is_finite(Box{p, p})) exact.extend(p);
    }
    ASSERT_TRUE(derived[c].contains(exact)) << "cluster " << c;
    ASSERT_TRUE(body.contains(exact)) << "cluster " << c << " and the body";
    areas.derived += half_area(derived[c]);
    areas.exact += half_area(exact);
  }
}

mat3 random_rotation(Random& random) {
  const float angle = random.uniform(0.0f, 6.28318531f);
  return glm::mat3_cast(glm::angleAxis(angle, random.direction()));
}

// Poses of one body: each call makes another one, of one of these kinds.
class Poser {
 public:
  explicit Poser(RandomBody& body, uint32_t seed) : body_(body), random_(seed) {}

  const Pose& next() {
    const uint32_t kind = count_++ % 8;
    for (Affine& joint : body_.joints) joint = random_joint(kind);
    if (kind == 4) {  // half turns between neighbours
      for (size_t j = 0; j < body_.joints.size(); j += 2) {
        body_.joints[j] = trs(vec3(0), glm::angleAxis(3.14159265f, vec3(1, 0, 0)), vec3(1));
      }
    }
    for (float& weight : body_.morph_weights) weight = random_weight(kind);
    body_.pose.key = random_.next() % (RandomBody::kKeys - 1);
    body_.pose.key_fraction = kind == 0 ? 0.0f : kind == 1 ? 1.0f : random_.uniform();
    return body_.pose;
  }

 private:
  Affine random_joint(uint32_t kind) {
    if (kind == 0) return identity_affine();
    if (kind == 1) return test::random_affine(random_, 2.0f);  // sheared, mirrored
    if (kind == 2) return Affine(0.0f);
    const mat3 r = random_rotation(random_);
    const float scale = kind == 3 ? std::pow(10.0f, random_.uniform(-3.0f, 3.0f)) : 1.0f;
    const float far = kind == 5 ? 1e6f : 1.0f;
    const vec3 t = random_.uniform3(-far, far);
    return Affine(r[0] * scale, r[1] * scale, r[2] * scale, t);
  }
  float random_weight(uint32_t kind) {
    if (kind == 2) return 0.0f;
    if (kind == 3) return random_.next() % 2 == 0 ? 0.0f : 1.0f;
    if (kind == 5) return random_.uniform(-1e4f, 1e4f);
    return random_.uniform(-2.0f, 2.0f);
  }

  RandomBody& body_;
  Random random_;
  uint32_t count_ = 0;
};

class ClustersProperty : public testing::TestWithParam<uint32_t> {};

TEST_P(ClustersProperty, BoxesContainAllPositionsInAnyPose) {
  const uint32_t seed = GetParam();
  SCOPED_TRACE(seed);
  RandomBody body(seed, 120, 1 + seed % 5);
  Random random(seed + 3000);
  // Some vertices at the corners of the weights' simplex, some far from a sum of 1.
  for (uint32_t v = 0; v < 120; ++v) {
    const std::span<float> weights = std::span(body.skin_weights).subspan(v * body.influences);
    if (v % 7 == 0) {
      for (uint32_t k = 0; k < body.influences; ++k) weights[k] = k == 0 ? 1.0f : 0.0f;
    }
    if (seed % 6 == 0 && v % 11 == 0) weights[0] = seed == 6 ? -0.3f : 2.0f;
  }
  if (seed % 5 == 0) {  // flat
    for (vec3& p : body.rest) p.z = 0.25f;
  }
  const Clusters clusters = random_clusters(random, 120, 12);
  for (const Motion& motion : body.motions()) {
    if (!derivable(motion)) continue;
    const ClusterBounds bounds =
        make_cluster_bounds(motion, clusters, {.most_pieces = 1 + seed % 4});
    Poser poser(body, seed + 4000);
    Areas areas;
    for (int pose = 0; pose < 48; ++pose) {
      SCOPED_TRACE(pose);
      expect_contains(bounds, motion, clusters, poser.next(), areas);
      if (HasFatalFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ClustersProperty, testing::Range(1u, 21u));

// A tube along x whose skin goes smoothly from joint 0 to joint 1 around x = 0, two morph targets
// that swell and lift it.
struct Tube {
  static constexpr uint32_t kAround = 48, kRows = 96;
  std::vector<vec3> rest, deltas;
  std::vector<uvec3> triangles;
  std::vector<uint16_t> joints;
  std::vector<float> weights;

  Tube() {
    for (uint32_t row = 0; row <= kRows; ++row) {
      for (uint32_t i = 0; i < kAround; ++i) {
        const float x = 6.0f * float(row) / kRows - 3.0f, turn = 6.28318531f * float(i) / kAround;
        rest.emplace_back(x, std::cos(turn), std::sin(turn));
        const float t = std::clamp(0.5f + 0.5f * x, 0.0f, 1.0f), w = t * t * (3.0f - 2.0f * t);
        joints.insert(joints.end(), {0, 1});
        weights.insert(weights.end(), {1.0f - w, w});
        const uint32_t a = row * kAround + i, b = row * kAround + (i + 1) % kAround;
        if (row == kRows) continue;
        triangles.emplace_back(a, b, a + kAround);
        triangles.emplace_back(b, b + kAround, a + kAround);
      }
    }
    for (const vec3 p : rest) deltas.push_back(std::exp(-p.x * p.x) * vec3(0, p.y, p.z));
    for (const vec3 p : rest) deltas.emplace_back(0.0f, std::sin(p.x), 0.0f);
  }
  SkinMotion skin() const { return {rest, 2, joints, weights, 2}; }
};

TEST(Clusters, AreTightOnASmoothBody) {
  const Tube tube;
  const Clusters clusters = runs_of_triangles(tube.rest, tube.triangles, 64);
  std::vector<Affine> joints = {identity_affine(), identity_affine()};
  std::vector<float> weights = {0.0f, 0.0f};
  Pose pose;
  pose.joints = joints;
  pose.weights = weights;
  const Motion motions[] = {tube.skin(), MorphMotion{tube.rest, tube.deltas, {}},
                            MorphMotion{tube.rest, tube.deltas, tube.skin()}};
  for (const Motion& motion : motions) {
    const ClusterBounds bounds = make_cluster_bounds(motion, clusters);
    Areas areas;
    for (int step = 0; step <= 8; ++step) {
      const float angle = 0.25f * float(step);
      joints[0] = trs({1, 2, 3}, glm::angleAxis(0.4f, normalize(vec3(1, 2, 3))), vec3(1));
      joints[1] = compose(joints[0], trs({}, glm::angleAxis(angle, vec3(0, 0.6f, 0.8f)), vec3(1)));
      weights = {0.1f * float(step), 1.0f - 0.2f * float(step)};
      expect_contains(bounds, motion, clusters, pose, areas);
    }
    EXPECT_LT(areas.derived, 1.3 * areas.exact);
  }
}

TEST(Clusters, TheSameBitsForEveryThreadCount) {
  const Tube tube;
  const Clusters clusters = runs_of_triangles(tube.rest, tube.triangles, 64);
  const Motion motion = MorphMotion{tube.rest, tube.deltas, tube.skin()};
  const auto make = [&](int threads) {
    const ThreadLimit limit(threads);
    return make_cluster_bounds(motion, clusters);
  };
  const ClusterBounds one = make(1), many = make(4);
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
  };
  EXPECT_TRUE(same(one.first_piece, many.first_piece));
  EXPECT_TRUE(same(one.pieces, many.pieces));
  EXPECT_TRUE(same(one.joints, many.joints));
  EXPECT_TRUE(same(one.targets, many.targets));
}

TEST(Clusters, KeyframesGiveTheirExactBoxesBack) {
  const RandomBody body(7, 60, 1);
  const Motion motion = body.motions()[4];
  Random random(1);
  const Clusters clusters = random_clusters(random, 60, 5);
  const ClusterBounds known = make_cluster_bounds(motion, clusters);
  Pose pose;
  for (pose.key = 0; pose.key < body.kKeys; ++pose.key) {
    std::vector<Box> boxes(clusters.count());
    derive_bounds(known, motion, pose, 0, boxes);
    for (uint32_t c = 0; c < clusters.count(); ++c) {
      const Box exact = bounds(motion, pose, clusters[c]);
      EXPECT_EQ(boxes[c].min, exact.min);
      EXPECT_EQ(boxes[c].max, exact.max);
    }
  }
}

TEST(Clusters, APoseThatIsNotFiniteShows) {
  RandomBody body(3, 40, 2);
  Random random(2);
  Clusters clusters;
  clusters.add({1, 5, 9, 22});
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    for (const size_t m : {size_t{1}, size_t{2}, size_t{3}}) {
      const Motion motion = body.motions()[m];
      const ClusterBounds bounds = make_cluster_bounds(motion, clusters);
      const auto expect_bad = [&] {
        Box box;
        derive_bounds(bounds, motion, body.pose, 0, {&box, 1});
        EXPECT_FALSE(is_finite(box)) << "motion " << m;
        EXPECT_FALSE(is_finite(derive_body_bounds(bounds, motion, body.pose))) << "motion " << m;
      };
      for (uint32_t j = 0; m != 2 && j < 4; ++j) {
        float& entry = body.joints[body.joint_indices[10]][j].y;  // of vertex 5
        const float saved = std::exchange(entry, bad);
        expect_bad();
        entry = saved;
      }
      if (m == 1) continue;
      const float saved = std::exchange(body.morph_weights[1], bad);
      expect_bad();
      body.morph_weights[1] = saved;
    }
  }
}

TEST(Clusters, VerticesThatAreNotFiniteAreNowhere) {
  RandomBody body(4, 40, 2);
  for (uint32_t v = 0; v < 10; ++v) body.rest[v].y = body.keys[v].y = std::nanf("");
  body.deltas[12].x = std::numeric_limits<float>::infinity();
  Clusters clusters;
  clusters.add({0, 3, 5});
  clusters.add({2, 4, 12, 17, 30});
  clusters.add({});
  for (const Motion& motion : body.motions()) {
    if (!derivable(motion)) continue;
    const ClusterBounds bounds = make_cluster_bounds(motion, clusters);
    body.pose.key = 0;
    Areas areas;
    expect_contains(bounds, motion, clusters, body.pose, areas);
    Box boxes[3];
    derive_bounds(bounds, motion, body.pose, 0, boxes);
    EXPECT_TRUE(boxes[0].empty());
    EXPECT_TRUE(is_finite(boxes[1]));
    EXPECT_TRUE(boxes[2].empty());
  }
}

TEST(Clusters, NothingIsEmpty) {
  const RandomBody body(5, 10, 2);
  for (const Motion& motion : body.motions()) {
    if (!derivable(motion)) continue;
    const ClusterBounds bounds = make_cluster_bounds(motion, {});
    derive_bounds(bounds, motion, body.pose, 0, {});
    EXPECT_TRUE(derive_body_bounds(bounds, motion, body.pose).empty());
  }
  EXPECT_FALSE(derivable(FreeMotion{10}));
}

void check_scene(const std::string& path) {
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << path;
  const int clip = scene->clips.empty() ? kRestPose : 0;
  ScenePose pose;
  std::vector<Motion> motions;
  std::vector<Clusters> clusters;
  std::vector<ClusterBounds> bounds;
  for (const SceneObject& object : scene->objects) {
    const Mesh& mesh = scene->meshes[object.mesh];
    motions.push_back(motion_of(mesh, object.skin >= 0));
    clusters.push_back(runs_of_triangles(mesh.positions, mesh.triangles, 64));
    bounds.push_back(make_cluster_bounds(motions.back(), clusters.back()));
  }
  for (const double part : {0.1, 0.45, 0.8}) {
    sample(*scene, clip, clip == kRestPose ? 0.0 : part * scene->clips[clip].end, pose);
    Areas areas;
    for (size_t i = 0; i < motions.size(); ++i) {
      if (!pose.objects[i].present) continue;
      SCOPED_TRACE(path + ", object " + std::to_string(i));
      expect_contains(bounds[i], motions[i], clusters[i], pose.objects[i], areas);
    }
  }
}

TEST(Clusters, ContainAnimatedCharacters) {
  SINEW_DATA_OR_SKIP(data, "skinned");
  check_scene(data + "/pigman/pigman.glb");
  check_scene(data + "/robot-expressive/RobotExpressive.glb");
}

TEST(Clusters, ContainAFace) {
  SINEW_DATA_OR_SKIP(data, "vertex-cache/ict-facekit");
  check_scene(data + "/generic_neutral_mesh.obj+" + data + "/expressions.pc2");
}

}  // namespace
}  // namespace sinew
