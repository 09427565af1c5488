// Octrees made in parts: the same bytes as those made at once, whatever the memory.
#include "sinew/svo/make/make_parts.h"

#include <gtest/gtest.h>

#include "sinew/svo/file/file.h"
#include "svo/skinned_shape.h"

namespace sinew {
namespace {

using test::SkinnedShape;

constexpr uint64_t kMuch = uint64_t{8} << 30;

SkinnedShape moving_body(uint32_t seed, uint32_t targets) {
  SkinnedShape body;
  Random random(seed);
  body.shape = test::sphere(3);
  body.shape.positions = test::twisted(body.shape.positions, random.uniform(0.5f, 1.5f));
  add_plate(body.shape, vec2(-1.3f, -0.2f), vec2(1.2f, 0.7f), random.uniform(-0.5f, 0.5f), 4);
  const std::vector<vec3> rest = body.shape.positions;
  body.follow_along(random.direction(), 6);
  for (uint32_t t = 0; t < targets; ++t) {
    std::vector<vec3> bulge;
    const vec3 side = random.direction();
    for (const vec3 p : rest) bulge.push_back(dot(p, side) > 0.3f ? 0.2f * p : vec3(0.0f));
    body.add_target(bulge);
  }
  for (size_t i = 0; i < body.shape.triangles.size(); ++i) {
    body.materials.push_back(static_cast<uint16_t>(i % 11 == 0));
  }
  return body;
}

struct Packed {
  std::vector<uint8_t> bytes;
  SvoPartsMade made;
};

Result<Packed> by_parts(SkinnedShape& body, uint32_t resolution, const VoxelizeOptions& voxels,
                        uint64_t memory) {
  const auto look = [&](const SurfaceBatch& batch) {
    const uvec3 t = body.shape.triangles[batch.triangle];
    const vec3 a = body.shape.positions[t.x];
    const vec3 normal = cross(body.shape.positions[t.y] - a, body.shape.positions[t.z] - a);
    std::ranges::fill(batch.normals, pack_normal(normal));
    std::ranges::fill(batch.colors, test::color_of_triangle(batch.triangle));
  };
  const Box box = surface_box(body.shape.positions, body.shape.triangles);
  SINEW_TRY(const VoxelGrid grid, grid_of_resolution(box, resolution));
  SurfaceVoxelizer surface(body.shape.positions, body.shape.triangles, grid, look, voxels);
  std::vector<uint8_t> skeletons, details;
  const auto into = [](std::vector<uint8_t>& to) {
    return [&to](std::span<const uint8_t> bytes) -> Result<void> {
      to.insert(to.end(), bytes.begin(), bytes.end());
      return {};
    };
  };
  SvoEncoder encoder(3, into(skeletons), into(details));
  SvoPartsOptions options;
  options.memory = memory;
  options.take = [&](const Svo& part) { return encoder.add(part); };
  Packed out;
  SINEW_TRY(out.made, make_svo_by_parts(surface, body.source(), options));
  out.bytes = encoder.finish(out.made.outline).bytes;
  out.bytes.insert(out.bytes.end(), skeletons.begin(), skeletons.end());
  out.bytes.insert(out.bytes.end(), details.begin(), details.end());
  return out;
}

// What the error says would do, in bytes.
uint64_t least_memory(const Error& error) {
  const std::string text = error.remedy, before = "--memory-limit ";
  const size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << error.message();
  return at == std::string::npos ? 0 : std::stoull(text.substr(at + before.size())) << 20;
}

void expect_same_bytes(SkinnedShape& body, uint32_t resolution, const VoxelizeOptions& voxels) {
  const Svo whole = *make_svo(*body.voxelized(resolution, voxels), body.source());
  const std::vector<uint8_t> expected = encode_svo(whole, 3)->bytes;
  const Result<Packed> at_once = by_parts(body, resolution, voxels, kMuch);
  ASSERT_TRUE(at_once) << at_once.error().message();
  EXPECT_EQ(at_once->made.parts, 1u);
  EXPECT_EQ(at_once->bytes, expected);
  EXPECT_EQ(at_once->made.bytes, whole.bytes());
  if (voxels.solid) return;
  const Result<Packed> too_little = by_parts(body, resolution, voxels, 1 << 20);
  ASSERT_FALSE(too_little);
  EXPECT_EQ(too_little.error().kind, ErrorKind::runtime);
  const uint64_t least = least_memory(too_little.error());
  for (const uint64_t memory : {least, least + (2 << 20), least + (8 << 20)}) {
    const Result<Packed> parts = by_parts(body, resolution, voxels, memory);
    ASSERT_TRUE(parts) << parts.error().message();
    EXPECT_GT(parts->made.parts, resolution > 300 && memory == least ? 2u : 0u);
    EXPECT_TRUE(parts->bytes == expected) << parts->made.parts << " parts";
  }
}

TEST(MakeParts, SameBytesAsAtOnce) {
  for (const uint32_t resolution : {130, 330}) {
    for (uint32_t seed = 1; seed <= 2; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", resolution " << resolution);
      SkinnedShape body = moving_body(seed, seed == 1 ? 0 : 3);
      expect_same_bytes(body, resolution, {.shell = Shell::thin});
      expect_same_bytes(body, resolution, {.shell = Shell::conservative});
    }
  }
}

TEST(MakeParts, SolidsAreMadeAsAWholeOrRefused) {
  SkinnedShape body = moving_body(5, 1);
  expect_same_bytes(body, 100, {.solid = true});
  const Result<Packed> refused = by_parts(body, 100, {.solid = true}, 1 << 20);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(by_parts(body, 100, {.solid = true}, least_memory(refused.error())));
}

TEST(MakeParts, ErrorsOfWhoTakesPartsEndTheWork) {
  SkinnedShape body = moving_body(7, 0);
  const auto look = [](const SurfaceBatch& batch) {
    std::ranges::fill(batch.normals, uint16_t{0});
    std::ranges::fill(batch.colors, uint16_t{0});
  };
  const Box box = surface_box(body.shape.positions, body.shape.triangles);
  SurfaceVoxelizer surface(body.shape.positions, body.shape.triangles, *grid_of_resolution(box, 99),
                           look, {});
  SvoPartsOptions options;
  options.take = [](const Svo&) -> Result<void> {
    return fail({ErrorKind::output, "x", "", "the disk is full", ""});
  };
  const auto full = make_svo_by_parts(surface, body.source(), options);
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().kind, ErrorKind::output);
  options.on_part = [](size_t, size_t) { return false; };
  const auto ended = make_svo_by_parts(surface, body.source(), options);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, ErrorKind::runtime);
}

}  // namespace
}  // namespace sinew
