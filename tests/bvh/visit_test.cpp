// First visits: rays that meet a place which another thread is making find what is made there.
#include "sinew/bvh/update/visit.h"

#include <gtest/gtest.h>

#include <cstring>

#include "shapes.h"
#include "sinew/bvh/trace/proximity.h"
#include "sinew/bvh/trace/traverse.h"

namespace sinew {
namespace {

// A twisting ball between two keys: only its pose is known, as after a lazy update.
struct Ball {
  test::Shape shape = test::sphere(4);
  std::vector<vec3> keys;
  Motion motion;
  Pose pose;
  Bvh8Layout layout;
  ClusterBounds clusters;
  Bvh8 bvh;
  VisitedBody body;
  Instance instance;

  explicit Ball(bool placed) {
    for (const float amount : {0.0f, 2.0f}) {
      const std::vector<vec3> key = test::twisted(shape.positions, amount);
      keys.insert(keys.end(), key.begin(), key.end());
    }
    motion = KeyframeMotion{static_cast<uint32_t>(shape.positions.size()), keys};
    pose.key_fraction = 0.4f;
    layout = *build_layout(shape.positions, shape.triangles, {});
    std::vector<uint32_t> first;
    for (const Treelet& treelet : layout.treelets) first.push_back(treelet.first_vertex);
    first.push_back(static_cast<uint32_t>(layout.vertices.size()));
    clusters = make_cluster_bounds(motion, {first, layout.vertices});
    reserve(layout, bvh);
    body.layout = &layout;
    body.bvh = &bvh;
    body.motion = &motion;
    body.pose = &pose;
    body.clusters = &clusters;
    instance.nodes = bvh.nodes.data();
    instance.corners = layout.packet_corners.data();
    instance.vertices = bvh.vertices.data();
    instance.primitives = layout.packet_primitives.data();
    instance.body = &body;
    if (!placed) return;
    instance.in_place = false;
    instance.placement[0] *= 1.5f;
    instance.placement[3] = vec3(0.2f, -0.1f, 0.3f);
    instance.to_object = inverse_affine(instance.placement);
  }
};

struct Found {
  std::vector<Hit> grouped, alone, along;
  std::vector<uint8_t> any;
  std::vector<NearestPoint> nearest;
  std::vector<TriangleId> in_box;
};

Found find_all(const Instance& instance) {
  const SceneView view{nullptr, &instance, 1};
  std::vector<Ray> rays;
  for (int i = 0; i < 32 * 32; ++i) {
    const vec3 at(0.08f * static_cast<float>(i % 32 - 16), 0.08f * static_cast<float>(i / 32 - 16),
                  0.0f);
    rays.push_back({.origin = vec3(0.0f, 0.0f, 4.0f), .direction = at - vec3(0.0f, 0.0f, 4.0f)});
  }
  Found found;
  found.grouped.resize(rays.size());
  found.alone.resize(rays.size());
  found.any.resize(rays.size());
  closest_hits(view, rays, found.grouped);
  closest_hits(view, rays, found.alone, {.grouping = Grouping::none});
  any_hits(view, rays, found.any);
  for (size_t i = 0; i < rays.size(); i += 40) {
    std::vector<Hit> along;
    all_hits(view, rays[i], along);
    found.along.insert(found.along.end(), along.begin(), along.end());
    const auto nearest = nearest_point(view, rays[i].origin + 0.8f * rays[i].direction);
    if (nearest) found.nearest.push_back(*nearest);
  }
  triangles_in_box(view, {vec3(0.1f), vec3(0.9f)}, found.in_box);
  return found;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(FirstVisit, WhatIsBeingMadeHidesNothing) {
  for (const bool placed : {false, true}) {
    Ball free(placed);
    const Found expected = find_all(free.instance);
    ASSERT_GT(expected.along.size(), 20u);
    ASSERT_EQ(expected.nearest.size(), 26u);
    ASSERT_GT(expected.in_box.size(), 20u);
    EXPECT_TRUE(same_bits(expected.grouped, expected.alone));
    EXPECT_GT(free.body.made, 8u);
    // Of how many treelets one is in the other thread's hands; 0: the upper tree is.
    for (const uint32_t every : {0u, 1u, 2u}) {
      Ball busy(placed);
      if (every == 0) {
        busy.body.upper = kBeingMade;
      } else {
        ASSERT_TRUE(visit_upper(busy.body));
        for (uint32_t t = 0; t < busy.bvh.links.size(); t += every) busy.bvh.links[t] = kBeingMade;
      }
      const Found found = find_all(busy.instance);
      const std::string where = std::to_string(every) + (placed ? ", placed" : "");
      EXPECT_TRUE(same_bits(expected.grouped, found.grouped)) << where;
      EXPECT_TRUE(same_bits(expected.alone, found.alone)) << where;
      EXPECT_TRUE(same_bits(expected.along, found.along)) << where;
      EXPECT_TRUE(same_bits(expected.nearest, found.nearest)) << where;
      EXPECT_EQ(expected.any, found.any) << where;
      EXPECT_EQ(expected.in_box, found.in_box) << where;
      EXPECT_EQ(busy.body.made > 0, every == 2) << where;
    }
  }
}

}  // namespace
}  // namespace sinew
