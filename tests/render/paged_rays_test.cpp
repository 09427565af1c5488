// Rays through octrees larger than memory: they ask for what they would show, pictures to keep
// settle, and what rays meet stays.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "render/voxel_scene.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/render/layers.h"
#include "sinew/render/refinement.h"
#include "sinew/render/voxelize_scene.h"
#include "svo/paged_svo.h"

namespace sinew {
namespace {

constexpr uint64_t kPlenty = uint64_t{1} << 30;

Svo shell_octree(uint32_t material) {
  constexpr uint32_t kResolution = 200;
  std::vector<PlainVoxel> voxels = test::shell_voxels(kResolution, 0.45f * kResolution, 1);
  for (PlainVoxel& voxel : voxels) voxel.material = static_cast<uint16_t>(material);
  return *make_svo({vec3(-1.0f), 2.0f / kResolution, uvec3(kResolution)}, voxels);
}

// A ball of voxels, a smaller one behind the camera, above a mirror, under a light.
struct Room : test::VoxelScene {
  Room() {
    scene.octrees[0] = shell_octree(0);
    place_ball(vec3(0.0f));
    place_ball(vec3(1.5f, 0.5f, 6.5f), 0.6f);
    const uint32_t mirror = add_material(vec3(1.0f), 0.0f);
    scene.materials[mirror].metallic = 1.0f;
    place(add_quad({-3, -1, 3}, {6, 0, 0}, {0, 0, -6}, mirror));
    place(add_quad({-3, -1, -2}, {6, 0, 0}, {0, 6, 0}, mirror));
    add_light(LightType::directional, vec3(0.0f), vec3(-0.4f, -1.0f, -0.3f), 3.0f);
    scene.environment.ambient = vec3(0.3f);
    camera = look_at(vec3(1.0f, 1.2f, 4.5f), vec3(0.0f), vec3(0, 1, 0), 0.6f);
    settings.width = settings.height = 96;
    settings.samples = 2;
    settings.voxels.shadowing = VoxelShadowing::rays;
  }
  // Mirrors, occlusion and shadows, or nothing but what is in front.
  void set_effects(bool any) {
    settings.reflections = any ? 2 : 0;
    settings.ambient_rays = any ? 4 : 0;
    settings.shadows = any;
  }
};

// Its octrees on disk.
class Pages {
 public:
  explicit Pages(const Scene& scene) {
    for (const Svo& svo : scene.octrees) disks_.push_back(std::make_unique<test::SvoOnDisk>(svo));
  }
  void open(Scene& scene, uint64_t spare, bool settle) const {
    for (size_t i = 0; i < disks_.size(); ++i) {
      Result<Svo> svo = disks_[i]->open(spare, settle);
      ASSERT_TRUE(svo) << svo.error().message();
      svo->name = scene.octrees[i].name;
      scene.octrees[i] = std::move(*svo);
    }
  }
  test::SvoOnDisk& disk(size_t octree) { return *disks_[octree]; }

 private:
  std::vector<std::unique_ptr<test::SvoOnDisk>> disks_;
};

bool same_pixels(const Image& a, const Image& b) {
  return a.pixels.size() == b.pixels.size() &&
         std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec4)) == 0;
}

TEST(WorldPagedRays, SettledPicturesAreThoseOfTheWholeOctree) {
  for (const VoxelPrimary primary :
       {VoxelPrimary::trace, VoxelPrimary::raster, VoxelPrimary::automatic}) {
    for (const bool effects : {false, true}) {
      for (const float lod : {0.0f, 0.75f, 1.5f}) {
        SCOPED_TRACE(testing::Message() << int(primary) << ' ' << effects << ' ' << lod);
        Room room;
        room.settings.voxels.primary = primary;
        room.settings.voxels.lod = lod;
        room.set_effects(effects);
        const Pages pages(room.scene);
        const Image whole = room.render();
        pages.open(room.scene, kPlenty, true);
        EXPECT_TRUE(same_pixels(room.render(), whole));
        const PagingStats stats = paging_stats(room.scene.octrees);
        EXPECT_EQ(stats.missing, 0u);
        EXPECT_EQ(stats.unsettled, 0u);
        EXPECT_GT(stats.loaded, 0u);
        // The far side of what is seen stays on disk.
        EXPECT_TRUE(effects || stats.loaded < stats.blocks);
        EXPECT_TRUE(primary != VoxelPrimary::trace || room.stats.voxels.traced > 0);
      }
    }
  }
}

TEST(WorldPagedRays, SkinnedBodiesSettle) {
  const Result<Scene> triangles = load("study:creature");
  ASSERT_TRUE(triangles);
  VoxelizeSceneOptions options;
  options.resolution = 300;
  Result<VoxelizedScene> made = voxelize_scene(*triangles, options);
  ASSERT_TRUE(made);
  RenderSettings settings;
  settings.width = settings.height = 96;
  settings.ambient_rays = 2;
  settings.voxels.primary = VoxelPrimary::trace;
  const auto render = [&](const Scene& scene) {
    Result<World> world = prepare(scene);
    EXPECT_TRUE(world);
    const RenderScratchPtr scratch = make_render_scratch();
    std::vector<Image> out;
    for (const double time : {0.1, 0.4}) {
      EXPECT_TRUE(world->set_time(time));
      const CameraView camera = frame_box(world->box(), vec3(0.7f, 0.35f, 0.6f), 0.6f, 1.0f);
      render_frame(*world, scene, world->pose(), camera, settings, *scratch, out.emplace_back());
    }
    return out;
  };
  const std::vector<Image> whole = render(made->scene);
  Pages(made->scene).open(made->scene, kPlenty, true);
  const std::vector<Image> paged = render(made->scene);
  EXPECT_GT(paging_stats(made->scene.octrees).loaded, 0u);
  for (size_t i = 0; i < whole.size(); ++i) EXPECT_TRUE(same_pixels(paged[i], whole[i])) << i;
}

// Frames that do not wait become the whole octree's.
TEST(WorldPagedRays, FramesSettleInTime) {
  for (const VoxelPrimary primary : {VoxelPrimary::trace, VoxelPrimary::raster}) {
    Room room;
    room.settings.voxels.primary = primary;
    const Pages pages(room.scene);
    const Image whole = room.render();
    pages.open(room.scene, kPlenty, false);
    const World world = room.prepare_world();
    const RenderScratchPtr scratch = make_render_scratch();
    Image image, first;
    uint32_t quiet = 0;
    for (uint32_t i = 0; i < 1000 && quiet < 3; ++i) {
      const uint64_t before = paging_epoch(room.scene.octrees);
      render_frame(world, room.scene, world.pose(), room.camera, room.settings, *scratch, image);
      if (i == 0) first = image;
      const bool moved = paging_epoch(room.scene.octrees) != before;
      const bool missing = paging_stats(room.scene.octrees).missing > 0;
      quiet = i > 0 && !moved && !missing ? quiet + 1 : 0;
    }
    EXPECT_EQ(quiet, 3u);
    EXPECT_FALSE(same_pixels(first, whole)) << "the first frame waits for nothing";
    EXPECT_TRUE(same_pixels(image, whole));
  }
}

// What does not fit is shown by cells, counted, and memory stays within the budget.
TEST(WorldPagedRays, TooSmallABudgetLeavesCells) {
  for (const VoxelPrimary primary : {VoxelPrimary::trace, VoxelPrimary::raster}) {
    Room room;
    room.settings.voxels.primary = primary;
    const Pages pages(room.scene);
    const Image whole = room.render();
    pages.open(room.scene, 100'000, true);
    const Image image = room.render();
    const PagingStats stats = paging_stats(room.scene.octrees);
    EXPECT_GT(stats.unsettled, 0u);
    EXPECT_GT(stats.missing, 0u);
    EXPECT_GT(stats.resident, 0u);
    EXPECT_LE(stats.most, stats.budget);
    EXPECT_FALSE(same_pixels(image, whole));
    EXPECT_LT(test::mean_difference(image, whole), 0.1);
  }
}

// Blocks that rays meet are not given up for others that matter less.
TEST(WorldPagedRays, WhatRaysMeetStays) {
  constexpr uint64_t kSlack = 65536;
  Room room;
  room.settings.voxels.primary = VoxelPrimary::trace;
  room.set_effects(false);
  const Pages pages(room.scene);
  pages.open(room.scene, kPlenty, true);
  const Image whole = room.render();
  const PagingStats before = paging_stats(room.scene.octrees);
  ASSERT_LT(before.resident + 4, before.blocks);
  pages.open(room.scene, before.in_use - before.least + kSlack, false);
  const World world = room.prepare_world();
  const RenderScratchPtr scratch = make_render_scratch();
  PagedSvo& paging = *room.scene.octrees[0].paging.operator->();
  Image image;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    render_frame(world, room.scene, world.pose(), room.camera, room.settings, *scratch, image);
    std::vector<uint32_t> seen;
    for (uint32_t b = 0; b < before.blocks; ++b) {
      if (paging.wishes()[b].load() > 0) {
        seen.push_back(b);
      } else if (frame >= 6) {
        paging.request(b, 0x1p-10f);  // the body's back
      }
    }
    paging.settle();
    world.refresh_octrees();
    if (frame < 5) continue;
    EXPECT_GT(seen.size(), 4u);
    EXPECT_TRUE(same_pixels(image, whole)) << frame;
    for (const uint32_t b : seen) EXPECT_EQ(paging.resident()[b], 1) << b;
  }
  EXPECT_GT(paging.stats().missing, 0u) << "the back does not fit";
}

TEST(WorldPagedRaysThreads, AnyNumberDrawsTheSame) {
  Room room;
  room.settings.voxels.primary = VoxelPrimary::trace;
  const Pages pages(room.scene);
  const Image whole = room.render();
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    pages.open(room.scene, kPlenty, true);
    EXPECT_TRUE(same_pixels(room.render(), whole)) << threads;
    pages.open(room.scene, 100'000, true);
    room.render();
  }
}

// A block that cannot be read stays a matter of cells; all else settles.
TEST(WorldPagedRays, DamagedPages) {
  Room room;
  room.settings.voxels.primary = VoxelPrimary::trace;
  Pages pages(room.scene);
  const Image whole = room.render();
  std::string bytes = pages.disk(0).bytes();
  const size_t details = bytes.size() - bytes.size() / 3;
  for (size_t at = details; at < bytes.size(); at += bytes.size() / 60) bytes[at] ^= 0x40;
  pages.disk(0).write(bytes);
  pages.open(room.scene, kPlenty, true);
  const Image image = room.render();
  const PagingStats stats = paging_stats(room.scene.octrees);
  EXPECT_GT(stats.damaged, 0u);
  EXPECT_GT(stats.resident, 0u);
  EXPECT_EQ(stats.missing, 0u);
  EXPECT_EQ(stats.unsettled, 0u);
  EXPECT_NE(stats.problem, "");
  EXPECT_LT(test::mean_difference(image, whole), 0.1);
}

TEST(WorldPagedRays, LayersSettle) {
  for (const VoxelPrimary primary : {VoxelPrimary::trace, VoxelPrimary::raster}) {
    Room room;
    const Pages pages(room.scene);
    FrameLayers layers[2];
    for (FrameLayers& out : layers) {
      if (&out == &layers[1]) pages.open(room.scene, kPlenty, true);
      const World world = room.prepare_world();
      LayerScratch scratch;
      VoxelSettings voxels;
      voxels.primary = primary;
      trace_layers(world, room.scene, world.pose(), room.camera, 96, 96, {}, scratch, out, voxels);
    }
    EXPECT_GT(paging_stats(room.scene.octrees).loaded, 0u);
    EXPECT_EQ(layers[0].depth, layers[1].depth);
    EXPECT_EQ(layers[0].normal, layers[1].normal);
    EXPECT_EQ(layers[0].object, layers[1].object);
    EXPECT_EQ(layers[0].primitive, layers[1].primitive);
  }
}

// A view that gets better holds nothing of the passes that showed cells.
TEST(WorldPagedRays, RefinementForgetsCells) {
  Room room;
  room.settings.samples = 1;
  const Pages pages(room.scene);
  Image whole, image;
  const auto refine = [&](uint32_t samples, Image& out) {
    const World world = room.prepare_world();
    const RenderScratchPtr scratch = make_render_scratch();
    Refinement refinement;
    uint64_t epoch = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
      refinement.draw(world, room.scene, world.pose(), room.camera, room.settings, *scratch, out);
      const uint64_t now = paging_epoch(room.scene.octrees);
      if (now == epoch && refinement.samples() == samples) return;
      epoch = now;
    }
    FAIL() << "does not settle";
  };
  refine(12, whole);
  pages.open(room.scene, kPlenty, false);
  refine(12, image);
  EXPECT_GT(paging_stats(room.scene.octrees).loaded, 0u);
  EXPECT_TRUE(same_pixels(image, whole));
}

}  // namespace
}  // namespace sinew
