// Octrees come back from bytes bit for bit, or not at all.
#include "sinew/svo/file/file.h"

#include <gtest/gtest.h>

#include "io/hostile.h"
#include "svo/sealed_svo.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

constexpr uint64_t kLimit = uint64_t{1} << 30;
constexpr int kEffort = 3;

std::vector<Svo> some_octrees() {
  Svo nothing;
  nothing.grid.resolution = uvec3(1);
  Svo named = test::plain_octree(7, 20, 1, 3);
  named.name = "a name \xc3\xa9";
  return {nothing, named, test::plain_octree(1, 1, 1, 1), test::plain_octree(130, 4000, 3, 5),
          test::moving_octree(100, 3000, 7)};
}

std::vector<uint8_t> encoded(const Svo& svo) {
  const Result<EncodedSvo> result = encode_svo(svo, kEffort);
  EXPECT_TRUE(result) << result.error().message();
  return result ? result->bytes : std::vector<uint8_t>();
}

TEST(SvoFile, ComesBackBitForBit) {
  for (const Svo& svo : some_octrees()) {
    SCOPED_TRACE(svo.name);
    ASSERT_EQ(validate(svo), "");
    const std::vector<uint8_t> bytes = encoded(svo);
    const Result<Svo> again = decode_svo(bytes, kLimit);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(is_same(svo, *again));
  }
}

TEST(SvoFile, RandomOctreesComeBack) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const uint32_t resolution = 1 + hash_u32(seed) % 200;
    const Svo svo = seed % 2 == 0 ? test::moving_octree(resolution, 500, seed)
                                  : test::plain_octree(resolution, 2000, 1 + seed % 4, seed);
    ASSERT_EQ(validate(svo), "");
    const Result<Svo> again = decode_svo(encoded(svo), kLimit);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(is_same(svo, *again));
  }
}

TEST(SvoFile, PartsSumToTheWhole) {
  const Svo svo = test::moving_octree(100, 3000, 7);
  const Result<EncodedSvo> result = encode_svo(svo, kEffort);
  ASSERT_TRUE(result);
  for (const SvoFileParts& parts : {result->parts, *parts_of_svo(result->bytes, kLimit)}) {
    EXPECT_EQ(
        parts.tables + parts.topology + parts.normals + parts.colors + parts.levels + parts.lattice,
        result->bytes.size());
    EXPECT_GT(parts.lattice, 0u);
  }
}

// Levels that are not the filter's are stored.
TEST(SvoFile, LevelsAreLeftOutOnlyIfTheyFollow) {
  Svo svo = test::plain_octree(100, 3000, 1, 9);
  const uint64_t cells = encode_svo(svo, kEffort)->parts.levels;
  svo.brick_level.spreads[5] ^= 1;
  svo.cell_level.colors[2] ^= 0x8000;
  const Result<EncodedSvo> result = encode_svo(svo, kEffort);
  ASSERT_TRUE(result);
  EXPECT_GT(result->parts.levels, 2 * cells);
  EXPECT_TRUE(is_same(svo, *decode_svo(result->bytes, kLimit)));
}

TEST(SvoFile, BlocksAreReadAlone) {
  const Svo svo = test::moving_octree(200, 6000, 11);
  const std::vector<uint8_t> bytes = encoded(svo);
  Result<SvoIndex> index = decode_svo_index(bytes, kLimit);
  ASSERT_TRUE(index) << index.error().message();
  ASSERT_GT(index->details.size(), 8u);
  EXPECT_EQ(index->bytes, svo.bytes());
  EXPECT_TRUE(index->svo.cells.empty());
  EXPECT_EQ(index->svo.nodes.size(), svo.nodes.size());
  allocate_pages(*index);
  const uint32_t block = 3;
  Svo part = index->svo;
  const auto page = [&](const SvoPage& p) { return std::span(bytes).subspan(p.offset, p.packed); };
  ASSERT_TRUE(decode_skeleton(*index, page(index->skeletons[block]), block, part));
  ASSERT_TRUE(decode_detail(*index, page(index->details[block]), block, part));
  fill_level(*index, block, part);
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    EXPECT_EQ(std::memcmp(&part.cells[c], &svo.cells[c], sizeof(SvoCell)), 0);
    EXPECT_EQ(part.cell_level.colors[c], svo.cell_level.colors[c]);
  }
  for (uint32_t v = svo.blocks[block].first_voxel; v < svo.blocks[block + 1].first_voxel; ++v) {
    EXPECT_EQ(part.normals[v], svo.normals[v]);
    EXPECT_EQ(part.color_selectors[v / 16] >> (2 * (v % 16)) & 3,
              svo.color_selectors[v / 16] >> (2 * (v % 16)) & 3);
  }
  EXPECT_EQ(part.cells[svo.blocks[block + 1].first_cell].voxels, 0);  // not read
}

TEST(SvoFile, InvalidOctreesAreRefused) {
  Svo svo = test::plain_octree(20, 100, 1, 2);
  svo.cells[0].voxels ^= 1;
  const Result<EncodedSvo> result = encode_svo(svo, kEffort);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
}

TEST(SvoFile, MoreMemoryThanAllowed) {
  const Svo svo = test::plain_octree(100, 3000, 1, 9);
  const Result<Svo> result = decode_svo(encoded(svo), svo.bytes() - 1);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().problem.find("memory"), std::string::npos) << result.error().problem;
  EXPECT_TRUE(decode_svo(encoded(svo), svo.bytes()));
}

void expect_refused(std::span<const uint8_t> bytes) {
  const Result<Svo> result = decode_svo(bytes, kLimit);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
  EXPECT_FALSE(result.error().problem.empty());
}

TEST(SvoFile, EveryTruncationAndEveryFlippedBitIsRefused) {
  for (const Svo& svo : {test::plain_octree(7, 20, 1, 3), test::moving_octree(9, 30, 4)}) {
    std::vector<uint8_t> bytes = encoded(svo);
    for (size_t size = 0; size < bytes.size(); ++size) {
      SCOPED_TRACE("truncated to " + std::to_string(size));
      expect_refused(std::span(bytes).first(size));
    }
    for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      SCOPED_TRACE("bit " + std::to_string(bit));
      bytes[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
      expect_refused(bytes);
      bytes[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    }
    bytes.push_back(0);
    expect_refused(bytes);
  }
}

// What is wrong behind the checksums is found too, or makes a valid octree.
TEST(SvoFile, PatchedPartsAreRefusedOrValid) {
  const test::UnsealedSvo whole = test::unseal(encoded(test::moving_octree(100, 400, 13)));
  ASSERT_TRUE(decode_svo(test::seal(whole), kLimit));
  constexpr uint32_t kSeed = 17;
  Random random(kSeed);
  int valid = 0;
  for (int i = 0; i < 3000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", patch " + std::to_string(i));
    test::UnsealedSvo parts = whole;
    for (uint32_t patches = 1 + random.next() % 3; patches > 0; --patches) {
      const bool in_head = random.next() % 2 == 0;
      std::vector<uint8_t>& bytes =
          in_head ? parts.head : parts.pages[random.next() % parts.pages.size()];
      if (in_head && random.next() % 2 == 0) {
        bytes[random.next() % 100] = static_cast<uint8_t>(random.next() >> 24);
      } else {
        bytes[random.next() % bytes.size()] = static_cast<uint8_t>(random.next() >> 24);
      }
    }
    const Result<Svo> result = decode_svo(test::seal(parts), kLimit);
    if (!result) {
      EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
      continue;
    }
    ++valid;
    EXPECT_EQ(validate(*result), "");
    EXPECT_TRUE(encode_svo(*result, 1));
  }
  EXPECT_GT(valid, 100);
}

// Sizes that no page can hold cost no memory.
TEST(SvoFile, SizesWithoutBytes) {
  test::UnsealedSvo parts = test::unseal(encoded(test::plain_octree(20, 200, 1, 2)));
  ASSERT_EQ(parts.pages.size(), 2u);
  // The counts of the one block stand last: 6 numbers of 4 bytes.
  const size_t counts = parts.head.size() - 24;
  parts.head[counts + 3] = 0x3f;  // 10^9 cells
  const Result<Svo> result = decode_svo(test::seal(parts), UINT64_MAX);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().problem.find("larger than its page"), std::string::npos)
      << result.error().problem;
}

}  // namespace
}  // namespace sinew
