// Pictures in parts: those of the whole octree, bit for bit, however little memory there is.
#include <gtest/gtest.h>

#include <deque>

#include "sinew/base/parallel.h"
#include "svo/paged_svo.h"
#include "svo/raster_oracle.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

using test::SvoOnDisk;

constexpr uint64_t kPlenty = uint64_t{1} << 30;

Svo shell(uint32_t resolution, uint32_t seed) {
  const VoxelGrid grid{vec3(-0.5f), 1.0f / static_cast<float>(resolution), uvec3(resolution)};
  const float radius = 0.45f * static_cast<float>(resolution);
  Svo svo = *make_svo(grid, test::shell_voxels(resolution, radius, seed));
  test::set_color_ends(svo, seed);
  return svo;
}

// Joints, morph weights and a placement of their own, by seed.
struct Moved {
  std::vector<Affine> joints;
  std::vector<float> weights;
  Affine placement = identity_affine();

  Moved(const Svo& svo, uint32_t seed) {
    Random random(seed);
    for (uint32_t i = 0; i < svo.joints; ++i) {
      const vec3 at = random.uniform3(-0.2f, 0.2f);
      const float angle = random.uniform(-0.5f, 0.5f);
      joints.push_back(trs(at, glm::angleAxis(angle, random.direction()), vec3(1.0f)));
    }
    for (uint32_t i = 0; i < svo.morph_targets; ++i) weights.push_back(random.uniform(-1.0f, 1.0f));
  }
  Pose pose() const {
    Pose out;
    out.joints = joints;
    out.weights = weights;
    return out;
  }
};

// Bodies that stand around in one picture; octrees may be shared.
class Bodies {
 public:
  void add(const Svo& svo, uint32_t seed, vec3 at = vec3(0.0f), float scale = 1.0f) {
    motions_.push_back(make_svo_motion(svo));
    const Moved& moved = moved_.emplace_back(svo, seed);
    PosedSvo& posed = posed_.emplace_back();
    posed.set_pose(motions_.back(), moved.pose());
    const quat turn = glm::angleAxis(0.3f * static_cast<float>(seed), normalize(vec3(1, 2, 3)));
    instances_.push_back({&posed, trs(at, turn, vec3(scale)), units_});
    units_ += unit_count(svo);
  }
  std::span<const VoxelInstance> instances() const { return instances_; }

 private:
  std::deque<SvoMotion> motions_;
  std::deque<Moved> moved_;
  std::deque<PosedSvo> posed_;
  std::vector<VoxelInstance> instances_;
  uint32_t units_ = 0;
};

// Calls draw(part) as VoxelFrame does; returns how many parts there were.
template <class F>
uint32_t draw_parts(std::span<const Svo> octrees, const F& draw) {
  EXPECT_TRUE(begin_parts(octrees));
  draw(RasterPart::first);
  uint32_t parts = 1;
  for (; end_part(octrees); ++parts) {
    read_part(octrees);
    draw(RasterPart::more);
  }
  end_parts(octrees);
  return parts;
}

struct Drawn {
  std::vector<VisibilityKey> keys;
  std::vector<float> depth;
  uint32_t parts = 0;

  bool same(const Drawn& b) const { return keys == b.keys && depth == b.depth; }
};

// `octrees` empty: at once.
Drawn draw(const Bodies& bodies, std::span<const Svo> octrees, const RasterView& view,
           const RasterSettings& settings, RasterScratch* kept = nullptr) {
  const RasterScratchPtr own = make_raster_scratch(), other = make_raster_scratch();
  RasterScratch& scratch = kept != nullptr ? *kept : *own;
  Visibility keys;
  DepthMap depth;
  const auto draw_keys = [&](RasterPart part) {
    rasterize(bodies.instances(), view, settings, scratch, keys, part);
  };
  const auto draw_depth = [&](RasterPart part) {
    rasterize_depth(bodies.instances(), view, settings, *other, depth, part);
  };
  uint32_t parts = 0;
  if (octrees.empty()) {
    draw_keys(RasterPart::whole);
    draw_depth(RasterPart::whole);
  } else {
    parts = draw_parts(octrees, draw_keys);
    draw_parts(octrees, draw_depth);
  }
  return {keys.keys, depth.depth, parts};
}

std::vector<RasterView> views() {
  return {test::look_at(vec3(0.1f, 0.2f, -2.0f), vec3(0), 300.0f, 320, 240, 0.01f),
          test::look_at(vec3(0.1f, 0.0f, 0.42f), vec3(0, 0, -1), 200.0f, 333, 217, 0.01f),
          test::look_at(vec3(0.2f, 0.05f, 0.7f), vec3(0), 9000.0f, 320, 240, 0.01f),
          test::look_at(vec3(3.0f, 0.0f, 9.0f), vec3(0), 300.0f, 320, 240, 0.01f),
          test::look_at(vec3(0.0f, 0.3f, 3.0f), vec3(0), 400.0f, 320, 240, 0.01f, false)};
}

std::vector<RasterSettings> all_settings() {
  return {{},
          {.smallest = 2.5f},
          {.lod = false},
          {.occlusion = false},
          {.front_to_back = true, .large = 2.0f}};
}

// With the least memory, a little more, and enough.
TEST(StreamParts, PicturesAreThoseOfTheWholeOctree) {
  const Svo svo = shell(200, 1);
  const SvoOnDisk disk(svo);
  Bodies whole;
  whole.add(svo, 1);
  for (const uint64_t spare : {uint64_t{0}, uint64_t{300'000}, kPlenty}) {
    std::vector<Svo> paged;
    paged.push_back(*disk.open(spare, true));
    Bodies some;
    some.add(paged[0], 1);
    const RasterScratchPtr scratch = make_raster_scratch();
    uint32_t most = 0;
    for (const RasterView& view : views()) {
      for (const RasterSettings& settings : all_settings()) {
        const Drawn expected = draw(whole, {}, view, settings);
        const Drawn drawn = draw(some, paged, view, settings, scratch.get());
        EXPECT_TRUE(drawn.same(expected)) << spare << " bytes";
        most = std::max(most, drawn.parts);
      }
    }
    const PagingStats stats = paged[0].paging->stats();
    EXPECT_LE(stats.most, stats.budget);
    EXPECT_EQ(stats.missing, 0u);
    EXPECT_EQ(stats.unsettled, 0u);
    EXPECT_EQ(stats.evicted > 0, spare != kPlenty);
    if (spare == 0) {
      EXPECT_GT(most, 8u);
    }
  }
}

// Joints and morph targets, octrees with budgets of their own, one of them drawn twice.
TEST(StreamParts, SeveralMovingBodies) {
  const Svo a = test::moving_octree(140, 6000, 7), b = shell(130, 3);
  const SvoOnDisk on_disk[] = {SvoOnDisk(a), SvoOnDisk(b)};
  std::vector<Svo> paged;
  paged.push_back(*on_disk[0].open(0, true));
  paged.push_back(*on_disk[1].open(100'000, true));
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Bodies whole, some;
    const auto place = [&](Bodies& bodies, const Svo& moving, const Svo& still) {
      bodies.add(moving, seed, vec3(-8.0f, -9.0f, -10.0f));
      bodies.add(still, seed, vec3(0.0f), 10.0f);
      bodies.add(moving, seed + 9, vec3(-6.0f, -8.0f, -6.0f), 0.5f);
    };
    place(whole, a, b);
    place(some, paged[0], paged[1]);
    const vec3 eye = Random(seed).uniform3(-15.0f, 15.0f) + vec3(0, 0, 25.0f);
    const RasterView view = test::look_at(eye, vec3(0), 400.0f, 320, 240, 0.01f);
    for (const RasterSettings& settings : all_settings()) {
      const Drawn expected = draw(whole, {}, view, settings);
      const Drawn drawn = draw(some, paged, view, settings);
      EXPECT_TRUE(drawn.same(expected));
      EXPECT_GT(drawn.parts, 1u);
    }
  }
}

// Two bodies in one place: every depth is there twice, and the first body wins all pixels though
// most of it is drawn after the other.
TEST(StreamParts, TheFirstOfEqualDepthsWinsWheneverItIsDrawn) {
  const Svo svo = shell(130, 3);
  const SvoOnDisk disk(svo);
  std::vector<Svo> paged;
  paged.push_back(*disk.open(0, true));
  paged.push_back(*disk.open(kPlenty, true));
  Bodies whole, some;
  for (int i = 0; i < 2; ++i) {
    whole.add(svo, 1);
    some.add(paged[static_cast<size_t>(i)], 1);
  }
  for (const RasterView& view : views()) {
    const Drawn expected = draw(whole, {}, view, {});
    EXPECT_TRUE(draw(some, paged, view, {}).same(expected));
    for (const VisibilityKey key : expected.keys) {
      EXPECT_TRUE(key == kNothing || key_unit(key) < unit_count(svo));
    }
  }
}

// The far side of a closed body.
TEST(StreamParts, WhatIsHiddenDoesNotCome) {
  const Svo svo = shell(200, 1);
  const SvoOnDisk disk(svo);
  std::vector<Svo> paged;
  paged.push_back(*disk.open(200'000, true));
  const SvoMotion motion = make_svo_motion(paged[0]);
  PosedSvo posed;
  posed.set_pose(motion, {});
  const std::vector<VoxelInstance> bodies = {{&posed}};
  const RasterView view =
      test::look_at(vec3(0, 0, 2), vec3(0), 600.0f, 640, 480, 0.01f);  // the farthest have z = 0
  const RasterScratchPtr scratch = make_raster_scratch();
  Visibility keys;
  std::vector<uint8_t> came(svo.block_count(), 0);
  draw_parts(paged, [&](RasterPart part) {
    const std::span<const uint8_t> resident = paged[0].paging->resident();
    for (size_t b = 0; b < came.size(); ++b) came[b] |= resident[b];
    rasterize(bodies, view, {}, *scratch, keys, part);
  });
  uint32_t near = 0, far = 0;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    // At the outline the test is coarser than that.
    const uvec3 at(svo.blocks[b].x, svo.blocks[b].y, svo.blocks[b].z);
    const bool hidden = at.z == 0 && at.x % 3 != 0 && at.y % 3 != 0;
    if (hidden) {
      EXPECT_EQ(came[b], 0) << "block " << b;
    }
    far += hidden;
    near += came[b];
  }
  EXPECT_GT(near, 3u);
  EXPECT_GT(far, 3u);
}

// Damaged blocks are drawn as cells, whenever that is found out.
TEST(StreamParts, DamagedBlocksStayCells) {
  const Svo svo = shell(130, 3);
  SvoOnDisk disk(svo);
  std::string bytes = disk.bytes();
  for (size_t i = bytes.size() - bytes.size() / 3; i < bytes.size(); i += bytes.size() / 9) {
    bytes[i] = static_cast<char>(bytes[i] ^ 0x55);
  }
  disk.write(bytes);
  const RasterView view = views()[0];
  Drawn drawn[2];
  for (int i = 0; i < 2; ++i) {
    std::vector<Svo> paged;
    paged.push_back(*disk.open(i == 0 ? kPlenty : 0, true));
    Bodies some;
    some.add(paged[0], 1);
    drawn[i] = draw(some, paged, view, {});
    EXPECT_TRUE(draw(some, paged, view, {}).same(drawn[i]));
    EXPECT_GT(paged[0].paging->stats().damaged, 0u);
  }
  EXPECT_TRUE(drawn[0].same(drawn[1]));
  uint32_t cells = 0, fine = 0;
  for (const VisibilityKey key : drawn[0].keys) {
    if (key != kNothing) ++(level_of(key_code(key)) == kCellLevel ? cells : fine);
  }
  EXPECT_GT(cells, 0u);
  EXPECT_GT(fine, cells);
}

TEST(StreamPartsThreads, AnyNumberDrawsTheSame) {
  const Svo svo = shell(130, 1);
  const SvoOnDisk disk(svo);
  Bodies whole;
  whole.add(svo, 1);
  const RasterView view = views()[0];
  const Drawn expected = draw(whole, {}, view, {});
  uint32_t parts = 0;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    std::vector<Svo> paged;
    paged.push_back(*disk.open(50'000, true));
    Bodies some;
    some.add(paged[0], 1);
    const Drawn drawn = draw(some, paged, view, {});
    EXPECT_TRUE(drawn.same(expected));
    if (parts == 0) parts = drawn.parts;
    EXPECT_EQ(drawn.parts, parts);
  }
}

}  // namespace
}  // namespace sinew
