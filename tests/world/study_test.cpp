// Every study scene over its frames: the same hits as Embree (ROBUST), and where the two differ, as
// brute force in double; every invariant of every tree. Also: the same bits for any thread count.
#include "sinew/scene/study.h"

#include <gtest/gtest.h>

#include <cstring>

#include "oracle.h"
#include "sinew/base/parallel.h"
#include "sinew/world/world.h"
#ifdef SINEW_HAVE_EMBREE
#include "bench/embree_scene.h"
#endif

namespace sinew {
namespace {

struct Study {
  const char* spec;
};
class StudyScene : public testing::TestWithParam<Study> {};
INSTANTIATE_TEST_SUITE_P(All, StudyScene,
                         testing::Values(Study{"creature"}, Study{"twist"}, Study{"soup"},
                                         Study{"fracture"}, Study{"bodies,subdivisions=4"},
                                         Study{"bodies,subdivisions=4,motion=free"}));

// All objects as one mesh in world space; first[i] is the first triangle of object i.
struct Flat {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
  std::vector<uint32_t> first;
  std::vector<float> slack;  // one a triangle: what placing its object may round a coordinate by
};

Flat flatten(const Scene& scene, const ScenePose& pose) {
  Flat flat;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.objects[i].mesh];
    const auto base = static_cast<uint32_t>(flat.positions.size());
    flat.first.push_back(static_cast<uint32_t>(flat.triangles.size()));
    flat.positions.resize(base + mesh.positions.size());
    world_positions(scene, pose, i, {flat.positions.data() + base, mesh.positions.size()});
    for (const uvec3 t : mesh.triangles) flat.triangles.push_back(t + base);
    float reach = 0.0f;
    for (size_t v = base; v < flat.positions.size(); ++v) {
      reach = std::max(reach, length(flat.positions[v]));
    }
    const bool in_place = pose.objects[i].placement == identity_affine();
    flat.slack.resize(flat.triangles.size(), in_place ? 0.0f : 8 * 5.97e-8f * reach);
  }
  return flat;
}

// Hits of the world, named by the flat mesh's triangles.
std::vector<Hit> flat_hits(const World& world, const Flat& flat, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  world.closest_hits(rays, hits);
  for (Hit& hit : hits) {
    if (!hit) continue;
    hit.primitive += flat.first[hit.object];
    hit.object = 0;
  }
  return hits;
}

template <class F>
void over_frames(const Scene& scene, World& world, int frames, const F& body) {
  const double start = scene.clips[0].start, end = scene.clips[0].end;
  for (int frame = 0; frame < frames; ++frame) {
    ASSERT_TRUE(world.set_time(start + (end - start) * frame / std::max(1, frames - 1)));
    body(frame);
  }
}

TEST_P(StudyScene, HitsAreThoseOfBruteForceInDouble) {
  const Scene scene = *make_study_scene(GetParam().spec);
  World world = *prepare(scene);
  over_frames(scene, world, 3, [&](int frame) {
    ASSERT_EQ(world.validate(), "") << "frame " << frame;
    const Flat flat = flatten(scene, world.pose());
    const auto rays = test::test_rays(flat.positions, flat.triangles, 24, 100 + frame);
    const auto hits = flat_hits(world, flat, rays);
    std::vector<test::Verdict> truth(rays.size());
    parallel_for(rays.size(), 1, [&](size_t i, size_t) {
      truth[i] = test::brute_force(rays[i], flat.positions, flat.triangles, flat.slack);
    });
    test::Agreement agreement;
    for (size_t i = 0; i < rays.size(); ++i) test::judge(rays[i], hits[i], truth[i], agreement);
    EXPECT_EQ(agreement.wrong, 0u) << "frame " << frame << ": " << agreement.first_wrong;
    EXPECT_GT(agreement.certain, rays.size() / 2) << "frame " << frame;
  });
}

#ifdef SINEW_HAVE_EMBREE
TEST_P(StudyScene, HitsAreThoseOfEmbree) {
  const Scene scene = *make_study_scene(GetParam().spec);
  World world = *prepare(scene);
  over_frames(scene, world, 5, [&](int frame) {
    const Flat flat = flatten(scene, world.pose());
    const bench::EmbreeScene embree(flat.positions, flat.triangles, bench::EmbreeMode::medium);
    const auto rays = test::test_rays(flat.positions, flat.triangles, 20000, 7 + frame);
    const auto hits = flat_hits(world, flat, rays);
    std::vector<Hit> theirs(rays.size());
    embree.closest_hits(rays, theirs);
    uint64_t doubtful = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (static_cast<bool>(hits[i]) == static_cast<bool>(theirs[i]) &&
          (!hits[i] || hits[i].primitive == theirs[i].primitive)) {
        continue;
      }
      // Triangles that lie on each other: both are right.
      if (hits[i] && theirs[i] && std::abs(hits[i].t - theirs[i].t) < 1e-5f * hits[i].t) continue;
      test::Agreement ours;
      test::judge(rays[i], hits[i],
                  test::brute_force(rays[i], flat.positions, flat.triangles, flat.slack), ours);
      EXPECT_EQ(ours.wrong, 0u) << "frame " << frame << " ray " << i << ": " << ours.first_wrong;
      doubtful += ours.certain == 0;
    }
    // Within rounding of an edge either answer is right; such rays must be rare.
    EXPECT_LE(doubtful, rays.size() / 10000) << "frame " << frame;
  });
}
#endif

TEST_P(StudyScene, SameHitsForAnyThreadCount) {
  const Scene scene = *make_study_scene(GetParam().spec);
  std::vector<Hit> reference;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    World world = *prepare(scene);
    ASSERT_TRUE(world.set_time(0.37 * scene.clips[0].end));
    const Flat flat = flatten(scene, world.pose());
    const auto rays = test::test_rays(flat.positions, flat.triangles, 5000, 3);
    std::vector<Hit> hits(rays.size());
    world.closest_hits(rays, hits);
    if (reference.empty()) reference = hits;
    EXPECT_EQ(0, std::memcmp(hits.data(), reference.data(), hits.size() * sizeof(Hit)));
  }
}

}  // namespace
}  // namespace sinew
