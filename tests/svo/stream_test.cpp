// Blocks that come and go: what is there is right, what is not is not needed, and memory suffices.
#include "sinew/svo/file/stream.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "sinew/base/parallel.h"
#include "svo/paged_svo.h"
#include "svo/raster_oracle.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

using test::all_blocks;
using test::ask;
using test::SvoOnDisk;

constexpr uint64_t kPlenty = uint64_t{1} << 30;

Svo shell_octree(uint32_t resolution = 200, uint32_t seed = 1) {
  const VoxelGrid grid{vec3(-0.5f), 1.0f / static_cast<float>(resolution), uvec3(resolution)};
  const float radius = 0.45f * static_cast<float>(resolution);
  Svo svo = *make_svo(grid, test::shell_voxels(resolution, radius, seed));
  test::set_color_ends(svo, seed);
  return svo;
}

// Whether a block's detail is what the whole octree's is.
bool same_detail(const Svo& a, const Svo& b, uint32_t block) {
  const SvoBlock &here = b.blocks[block], &next = b.blocks[block + 1];
  const auto same = [](const auto& x, const auto& y, size_t begin, size_t end) {
    return std::equal(x.begin() + static_cast<ptrdiff_t>(begin),
                      x.begin() + static_cast<ptrdiff_t>(end),
                      y.begin() + static_cast<ptrdiff_t>(begin));
  };
  for (uint32_t i = here.first_brick; i < next.first_brick && !b.color_ends.empty(); ++i) {
    if (a.color_ends[i].a != b.color_ends[i].a || a.color_ends[i].b != b.color_ends[i].b) {
      return false;
    }
  }
  for (uint32_t i = here.first_voxel; i < next.first_voxel && b.colors.empty(); ++i) {
    const auto selector = [&](const Svo& svo) {
      return svo.color_selectors[i / 16] >> (2 * (i % 16)) & 3;
    };
    if (selector(a) != selector(b)) return false;
  }
  return same(a.bricks, b.bricks, here.first_brick, next.first_brick) &&
         same(a.normals, b.normals, here.first_voxel, next.first_voxel) &&
         (b.colors.empty() || same(a.colors, b.colors, here.first_voxel, next.first_voxel)) &&
         same(a.brick_level.normals, b.brick_level.normals, here.first_brick, next.first_brick) &&
         same(a.brick_level.colors, b.brick_level.colors, here.first_brick, next.first_brick) &&
         same(a.brick_level.spreads, b.brick_level.spreads, here.first_brick, next.first_brick);
}

TEST(Stream, WholeOctreeComesBitForBit) {
  for (const Svo& svo : {shell_octree(), test::plain_octree(130, 4000, 3, 5),
                         test::moving_octree(100, 3000, 7), test::plain_octree(1, 1, 1, 1)}) {
    SCOPED_TRACE(svo.name);
    const SvoOnDisk disk(svo);
    Result<Svo> paged = disk.open(kPlenty);
    ASSERT_TRUE(paged) << paged.error().message();
    EXPECT_EQ(validate(*paged), "");
    EXPECT_EQ(paged->paging->stats().resident, 0u);
    ask(*paged, all_blocks(svo));
    EXPECT_TRUE(is_same(svo, *paged));
    EXPECT_EQ(paged->paging->stats().resident, svo.block_count());
    EXPECT_EQ(paged->paging->stats().missing, 0u);
    EXPECT_EQ(paged->paging->stats().damaged, 0u);
  }
}

// Blocks come and go at random; those that are there are always right.
TEST(Stream, WhatIsThereIsRightWhateverCameAndWent) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  constexpr uint32_t kSeed = 5;
  Random random(kSeed);
  Result<Svo> paged = disk.open(400'000);
  ASSERT_TRUE(paged) << paged.error().message();
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    std::vector<uint32_t> wanted;
    for (uint32_t i = 0; i < 5; ++i) wanted.push_back(random.next() % svo.block_count());
    ask(*paged, wanted);
    const PagingStats stats = paged->paging->stats();
    EXPECT_LE(stats.most, stats.budget);
    uint32_t resident = 0;
    for (uint32_t b = 0; b < svo.block_count(); ++b) {
      if (paged->paging->resident()[b] == 0) continue;
      ++resident;
      EXPECT_TRUE(same_detail(*paged, svo, b)) << "block " << b;
    }
    EXPECT_EQ(resident, stats.resident);
  }
  EXPECT_GT(paged->paging->stats().evicted, 20u);
}

TEST(Stream, LeastRecentlySeenGoesFirst) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(300'000);
  ASSERT_TRUE(paged);
  PagedSvo& paging = *paged->paging.operator->();
  ask(*paged, {0});
  const auto there = [&](uint32_t b) { return paging.resident()[b] != 0; };
  uint32_t next = 1;
  while (paging.stats().evicted == 0 && next < svo.block_count()) {
    if (next > 1) ask(*paged, {0});  // seen again and again
    ask(*paged, {next++});
  }
  ASSERT_GT(paging.stats().evicted, 0u);
  ASSERT_GT(next, 3u);
  EXPECT_TRUE(there(0));
  EXPECT_FALSE(there(1));
  EXPECT_TRUE(there(next - 1));
}

// A block that is seen gives way only to one that matters much more.
TEST(Stream, UrgentBlocksComeFirst) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(0);
  ASSERT_TRUE(paged);
  PagedSvo& paging = *paged->paging.operator->();
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    paging.request(b, b == 7 ? 8.0f : 1.0f);
  }
  paging.settle();
  EXPECT_EQ(paging.resident()[7], 1);
  EXPECT_EQ(paging.stats().unsettled, 0u);  // more came, and is to be drawn
  for (const uint32_t b : all_blocks(svo)) paging.request(b, b == 7 ? 8.0f : 1.0f);
  EXPECT_FALSE(paging.settle());
  EXPECT_EQ(paging.stats().unsettled, 1u);
  EXPECT_GT(paging.stats().missing, 0u);
  EXPECT_LT(paging.stats().resident, svo.block_count());
}

TEST(Stream, FramesDoNotWait) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(kPlenty);
  ASSERT_TRUE(paged);
  PagedSvo& paging = *paged->paging.operator->();
  const uint64_t epoch = paging.epoch();
  for (const uint32_t b : all_blocks(svo)) paging.request(b, 1.0f);
  paging.begin_frame();
  EXPECT_EQ(paging.epoch(), epoch);  // nothing can have come yet
  EXPECT_EQ(paging.stats().missing, svo.block_count());
  for (int i = 0; i < 10'000 && paging.stats().resident < svo.block_count(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    paging.begin_frame();
  }
  EXPECT_TRUE(is_same(svo, *paged));
  EXPECT_GT(paging.epoch(), epoch);
}

TEST(Stream, BudgetBelowTheMinimum) {
  const SvoOnDisk disk(shell_octree(100));
  Result<SvoInFile> found = disk.find();
  ASSERT_TRUE(found);
  const uint64_t least = found->least;
  const Result<Svo> result = PagedSvo::open(std::move(*found), {least - 1, false});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
  EXPECT_NE(result.error().problem.find(std::to_string(least)), std::string::npos);
  // With the least, one block at a time comes.
  Result<Svo> paged = disk.open(0);
  ASSERT_TRUE(paged);
  for (uint32_t b = 0; b < paged->block_count(); ++b) {
    ask(*paged, {b});
    EXPECT_EQ(paged->paging->resident()[b], 1) << b;
  }
  EXPECT_LE(paged->paging->stats().most, least);
}

// Whatever byte is wrong: refused, or the block stays away and says so once; all others are right.
TEST(Stream, EveryFlippedByte) {
  const Svo svo = test::moving_octree(90, 60, 4);
  SvoOnDisk disk(svo);
  const std::string whole = disk.bytes();
  uint32_t damaged = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    SCOPED_TRACE("byte " + std::to_string(i));
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x55);
    disk.write(bytes);
    Result<Svo> paged = disk.open(kPlenty);
    if (!paged) {
      EXPECT_EQ(paged.error().kind, ErrorKind::bad_input);
      continue;
    }
    ask(*paged, all_blocks(svo));
    const PagingStats stats = paged->paging->stats();
    EXPECT_EQ(stats.damaged, 1u);
    EXPECT_NE(stats.problem, "");
    EXPECT_EQ(stats.resident, svo.block_count() - 1);
    for (uint32_t b = 0; b < svo.block_count(); ++b) {
      EXPECT_TRUE(paged->paging->resident()[b] == 0 || same_detail(*paged, svo, b));
    }
    ask(*paged, all_blocks(svo));  // nobody tries again
    EXPECT_EQ(paged->paging->stats().damaged, 1u);
    ++damaged;
  }
  EXPECT_GT(damaged, 100u);
}

TEST(Stream, TruncatedBeforeItIsOpened) {
  const Svo svo = test::moving_octree(9, 30, 4);
  SvoOnDisk disk(svo);
  const std::string whole = disk.bytes();
  for (size_t size = 0; size < whole.size(); ++size) {
    disk.write(whole.substr(0, size));
    EXPECT_FALSE(disk.open(kPlenty)) << size;
  }
}

// A file that is cut while it is read costs blocks and not the program.
TEST(Stream, CutWhileItIsRead) {
  const Svo svo = shell_octree(100);
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(kPlenty);
  ASSERT_TRUE(paged);
  ask(*paged, {0});
  std::filesystem::resize_file(disk.path(), disk.bytes().size() * 2 / 3);
  ask(*paged, all_blocks(svo));
  const PagingStats stats = paged->paging->stats();
  EXPECT_GT(stats.damaged, 0u);
  EXPECT_GT(stats.resident, 0u);
  EXPECT_NE(stats.problem.find("cut"), std::string::npos) << stats.problem;
}

// Draws as VoxelFrame does.
std::vector<VisibilityKey> draw_settled(const Svo& svo, const RasterView& view,
                                        const RasterSettings& settings = {}) {
  const SvoMotion motion = make_svo_motion(svo);
  PosedSvo posed;
  posed.set_pose(motion, {});
  const std::vector<VoxelInstance> bodies = {{&posed}};
  const RasterScratchPtr scratch = make_raster_scratch();
  Visibility out;
  rasterize(bodies, view, settings, *scratch, out);
  for (int i = 0; i < 32 && svo.paging && svo.paging->settle(); ++i) {
    rasterize(bodies, view, settings, *scratch, out);
  }
  return out.keys;
}

std::vector<RasterView> views() {
  return {test::look_at(vec3(0.1f, 0.2f, -2.0f), vec3(0), 300.0f, 320, 240, 0.01f),
          test::look_at(vec3(1.0f, 0.4f, 0.5f), vec3(0, 0.1f, 0), 500.0f, 320, 240, 0.01f),
          test::look_at(vec3(0.1f, 0.0f, 0.42f), vec3(0, 0, -1), 200.0f, 320, 240, 0.01f),
          test::look_at(vec3(3.0f, 0.0f, 9.0f), vec3(0), 300.0f, 320, 240, 0.01f),
          test::look_at(vec3(0.0f, 0.3f, 3.0f), vec3(0), 400.0f, 320, 240, 0.01f, false)};
}

TEST(Stream, SettledPicturesAreThoseOfTheWholeOctree) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  for (const bool occlusion : {true, false}) {
    for (const float smallest : {0.75f, 2.5f}) {
      const RasterSettings settings{.smallest = smallest, .occlusion = occlusion};
      Result<Svo> paged = disk.open(kPlenty);
      ASSERT_TRUE(paged);
      for (const RasterView& view : views()) {
        EXPECT_EQ(draw_settled(*paged, view, settings), draw_settled(svo, view, settings));
        EXPECT_EQ(paged->paging->stats().missing, 0u);
      }
    }
  }
}

// Blocks behind others are not asked for, and those far away neither.
TEST(Stream, WhatIsHiddenDoesNotCome) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(kPlenty);
  ASSERT_TRUE(paged);
  draw_settled(*paged, test::look_at(vec3(0, 0, 9), vec3(0), 30.0f, 320, 240, 0.01f));
  EXPECT_EQ(paged->paging->stats().loaded, 0u);
  draw_settled(*paged, test::look_at(vec3(0, 0, 2), vec3(0), 300.0f, 320, 240, 0.01f));
  EXPECT_GT(paged->paging->stats().loaded, 0u);
  EXPECT_LT(paged->paging->stats().loaded, svo.block_count());
}

// Without detail the picture has the body's outline, within a cell.
TEST(Stream, CellsStandInForWhatIsMissing) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(kPlenty);
  ASSERT_TRUE(paged);
  const RasterView view = views()[0];
  const SvoMotion motion = make_svo_motion(*paged);
  PosedSvo posed;
  posed.set_pose(motion, {});
  const std::vector<VoxelInstance> bodies = {{&posed}};
  const RasterScratchPtr scratch = make_raster_scratch();
  Visibility coarse;
  rasterize(bodies, view, {}, *scratch, coarse);
  const std::vector<VisibilityKey> fine = draw_settled(svo, view);
  for (size_t i = 0; i < fine.size(); ++i) {
    if (fine[i] == kNothing) continue;
    ASSERT_NE(coarse.keys[i], kNothing) << i;
    EXPECT_EQ(key_code(coarse.keys[i]), kFirstCode[3]);
    EXPECT_EQ(sample_voxel(bodies, coarse.keys[i]).level, 3u);
  }
}

// Requests from all threads, frames that begin meanwhile, a thread that reads: for the sanitizers.
TEST(StreamThreads, RequestsFromManyThreads) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  Result<Svo> paged = disk.open(600'000);
  ASSERT_TRUE(paged);
  PagedSvo& paging = *paged->paging.operator->();
  for (uint32_t frame = 0; frame < 50; ++frame) {
    parallel_for(4 * svo.block_count(), 7, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const uint32_t b = static_cast<uint32_t>(i) % svo.block_count();
        if (hash_u32(frame / 5 + b) % 3 == 0) paging.request(b, 1.0f + static_cast<float>(i));
        // What is there is read while other blocks come.
        EXPECT_TRUE(paging.resident()[b] == 0 || same_detail(*paged, svo, b));
      }
    });
    paging.begin_frame();
  }
  paging.settle();
  EXPECT_GT(paging.stats().loaded, 0u);
}

TEST(StreamThreads, AnyNumberDrawsTheSame) {
  const Svo svo = shell_octree();
  const SvoOnDisk disk(svo);
  const RasterView view = views()[1];
  const std::vector<VisibilityKey> whole = draw_settled(svo, view);
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    Result<Svo> paged = disk.open(kPlenty);
    ASSERT_TRUE(paged);
    EXPECT_EQ(draw_settled(*paged, view), whole);
  }
}

}  // namespace
}  // namespace sinew
