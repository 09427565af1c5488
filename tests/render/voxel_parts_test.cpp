// Pictures in parts through render_frame(): their shading and shadow maps are those of the whole
// octrees, bit for bit.
#include <gtest/gtest.h>

#include <cstring>

#include "io/hostile.h"
#include "render/voxel_scene.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/io/svo/svo.h"
#include "sinew/svo/file/stream.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

using test::VoxelScene;

bool same_pixels(const Image& a, const Image& b) {
  return a.pixels.size() == b.pixels.size() &&
         std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec4)) == 0;
}

// A walking body of many blocks with balls in front of it and behind, and lights of all kinds.
class PagedScene {
 public:
  PagedScene() {
    VoxelScene s;
    Svo moving = test::moving_octree(140, 6000, 7);
    Node body;
    body.octree = 1;
    body.skin = 0;
    body.weights = {0.5f, -0.25f};
    Skin skin{"bones", {}, std::vector<Affine>(moving.joints, identity_affine())};
    for (uint32_t j = 0; j < moving.joints; ++j) {
      skin.joints.push_back(static_cast<int32_t>(s.scene.nodes.size()));
      Node joint;
      joint.scale = vec3(0.1f);
      joint.translation = vec3(-0.8f, -0.9f, -1.2f) + 0.02f * static_cast<float>(j);
      s.scene.nodes.push_back(joint);
    }
    s.scene.octrees.push_back(std::move(moving));
    while (s.scene.materials.size() < 2) s.add_material(vec3(0.5f), 0.7f);
    s.scene.skins.push_back(skin);
    s.scene.nodes.push_back(body);
    s.place_ball(vec3(0.8f, 0.5f, 1.5f), 0.4f);
    s.place_ball(vec3(-1.0f, 0.0f, -2.0f));
    s.add_light(LightType::directional, vec3(0), vec3(-1.0f, -2.0f, -1.5f), 2.0f);
    s.add_light(LightType::point, vec3(2.0f, 3.0f, 3.0f), vec3(0, -1, 0), 20.0f);
    list_objects(s.scene);
    const Result<SavedSvo> saved = save_svo(s.scene, path(), {.effort = 3});
    EXPECT_TRUE(saved) << saved.error().message();
    least_ = 0;
    for (const Svo& svo : open(uint64_t{1} << 30).scene.octrees) {
      least_ += svo.paging->stats().least;
    }
  }
  // A scene with its settings; `memory` 0: whole.
  VoxelScene open(uint64_t memory) const {
    VoxelScene s;
    Result<Scene> loaded = load(path(), {.voxel_memory = memory, .settle = true});
    EXPECT_TRUE(loaded) << loaded.error().message();
    s.scene = std::move(*loaded);
    s.settings.reflections = 0;
    s.settings.voxels.primary = VoxelPrimary::raster;
    return s;
  }
  uint64_t least() const { return least_; }

 private:
  std::string path() const { return folder_.path("a.svo"); }

  TemporaryFolder folder_;
  uint64_t least_ = 0;
};

// Moves the body's joints.
void walk(VoxelScene& s, uint32_t step) {
  for (size_t i = 0; i < s.scene.skins[0].joints.size(); ++i) {
    Node& joint = s.scene.nodes[static_cast<size_t>(s.scene.skins[0].joints[i])];
    const float angle = 0.1f * static_cast<float>(step * (i + 1));
    joint.rotation = glm::angleAxis(angle, normalize(vec3(1.0f, 2.0f, 0.5f)));
  }
}

TEST(VoxelParts, PicturesAndShadowsAreThoseOfWholeOctrees) {
  const PagedScene file;
  VoxelScene whole = file.open(0), paged = file.open(file.least());
  for (uint32_t step = 0; step < 3; ++step) {
    for (const uint32_t samples : {1u, 3u}) {
      for (const float lod : {0.0f, 0.75f, 3.0f}) {
        Image pictures[2];
        for (VoxelScene* s : {&whole, &paged}) {
          walk(*s, step);
          s->settings.samples = samples;
          s->settings.subsampling = 1 + step % 2;
          s->settings.voxels.lod = lod;
          pictures[s == &paged] = s->render();
        }
        EXPECT_TRUE(same_pixels(pictures[0], pictures[1]))
            << "step " << step << ", " << samples << " samples, lod " << lod;
      }
    }
  }
  const PagingStats stats = paging_stats(paged.scene.octrees);
  EXPECT_GT(stats.evicted, 100u);
  EXPECT_GT(stats.parts, 100u);
  EXPECT_EQ(stats.unsettled, 0u);
  EXPECT_LE(stats.most, stats.budget);
}

TEST(VoxelPartsThreads, AnyNumberDrawsTheSame) {
  const PagedScene file;
  const Image expected = file.open(0).render();
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    for (const uint64_t spare : {uint64_t{0}, uint64_t{200'000}, uint64_t{1} << 28}) {
      EXPECT_TRUE(same_pixels(file.open(file.least() + spare).render(), expected));
    }
  }
}

}  // namespace
}  // namespace sinew
