// The thesis's octree, against formulas by hand and a recursion that asks every pixel.
#include "sinew/svo/thesis/thesis.h"

#include <gtest/gtest.h>

#include <array>

#include "svo/thesis_shapes.h"

namespace sinew {
namespace {

using test::make_view, test::random_joints, test::random_voxels, test::unit_grid;

ThesisNode node_with(std::array<float, 4> weights) {
  ThesisNode node;
  node.skin.weights = weights;
  return node;
}

TEST(Thesis, StretchFactorIsTwoOrTheNumberOfWeights) {
  EXPECT_EQ(stretch_factor(node_with({1.0f, 0.0f, 0.0f, 0.0f})), 1.0f);
  EXPECT_EQ(stretch_factor(node_with({0.99f, 0.01f, 0.0f, 0.0f})), 2.0f);
  EXPECT_EQ(stretch_factor(node_with({0.5f, 0.3f, 0.2f, 0.0f})), 2.0f);
  EXPECT_EQ(stretch_factor(node_with({0.25f, 0.25f, 0.25f, 0.25f})), 2.0f);
  EXPECT_EQ(stretch_factor(node_with({})), 1.0f);  // no joint moves it
}

TEST(Thesis, NearestPointsOfATriangleByHand) {
  const vec3 a(0.0f), b(2.0f, 0.0f, 0.0f), c(0.0f, 2.0f, 0.0f);
  EXPECT_EQ(nearest_on_triangle({-1.0f, -1.0f, 3.0f}, a, b, c), vec3(1.0f, 0.0f, 0.0f));
  EXPECT_EQ(nearest_on_triangle({1.0f, -1.0f, 0.0f}, a, b, c), vec3(0.5f, 0.5f, 0.0f));
  EXPECT_EQ(nearest_on_triangle({2.0f, 2.0f, 5.0f}, a, b, c), vec3(0.0f, 0.5f, 0.5f));
  EXPECT_EQ(nearest_on_triangle({0.5f, 1.0f, -7.0f}, a, b, c), vec3(0.25f, 0.25f, 0.5f));
  EXPECT_EQ(nearest_on_triangle({-3.0f, 1.0f, 0.0f}, a, b, c), vec3(0.5f, 0.0f, 0.5f));
}

TEST(Thesis, MeansKeepTheHeaviestFourAndSumToOne) {
  ThesisMix mix;
  mix.clear();
  for (uint32_t j = 0; j < 6; ++j) mix.add(j, static_cast<float>(j));
  mix.add(5, 1.0f);
  const ThesisWeights mean = mix.mean();  // 6, 4, 3, 2 of 15
  EXPECT_EQ(mean.joints, (std::array<uint16_t, 4>{5, 4, 3, 2}));
  EXPECT_FLOAT_EQ(mean.weights[0], 6.0f / 15.0f);
  EXPECT_FLOAT_EQ(mean.weights[3], 2.0f / 15.0f);
}

TEST(Thesis, InnerNodesAreMeansOfTheirChildren) {
  std::vector<ThesisVoxel> voxels(2);
  voxels[0] = {.voxel = morton_of({0, 0, 0}),
               .normal = pack_normal({1.0f, 0.0f, 0.0f}),
               .color = pack_color(vec3(0.0f))};
  voxels[0].skin = {{3, 0, 0, 0}, {1.0f, 0.0f, 0.0f, 0.0f}};
  voxels[1] = {.voxel = morton_of({3, 0, 0}),
               .normal = pack_normal({0.0f, 1.0f, 0.0f}),
               .color = pack_color(vec3(1.0f))};
  voxels[1].skin = {{1, 3, 0, 0}, {0.75f, 0.25f, 0.0f, 0.0f}};
  const ThesisOctree octree = make_thesis_octree(unit_grid(4), voxels, 4);
  ASSERT_EQ(octree.nodes.size(), 5u);
  EXPECT_EQ(octree.bytes(), 240u);
  const ThesisNode& root = octree.nodes[0];
  EXPECT_EQ(root.level, 2);
  EXPECT_EQ(root.children, 0b11);
  EXPECT_EQ(root.first_child, 1u);
  EXPECT_EQ(octree.nodes[1].children, 0b01);
  EXPECT_EQ(octree.nodes[2].children, 0b10);
  EXPECT_EQ(octree.nodes[2].first_child, 4u);
  EXPECT_EQ(root.skin.joints[0], 3);
  EXPECT_FLOAT_EQ(root.skin.weights[0], 0.625f);
  EXPECT_FLOAT_EQ(root.skin.weights[1], 0.375f);
  EXPECT_NEAR(root.normal.x, std::sqrt(0.5f), 0.01f);
  EXPECT_NEAR(unpack_color(root.color).x, 0.5f, 0.03f);
}

// The same picture by recursion, every pixel asked about every drawn node.
class Recursion {
 public:
  Recursion(const ThesisInstance& instance, const RasterView& view, const ThesisSettings& settings)
      : instance_(instance), view_(view), settings_(settings) {
    keys.assign(size_t{view.width} * view.height, kNothing);
    visit(0, uvec3(0));
  }
  std::vector<VisibilityKey> keys;
  uint64_t drawn = 0;

 private:
  void visit(uint32_t index, uvec3 place) {
    const ThesisOctree& octree = *instance_.octree;
    const ThesisNode& node = octree.nodes[index];
    const float side = static_cast<float>(1u << node.level);
    const vec3 rest = octree.grid.origin + octree.grid.voxel * (vec3(place) + 0.5f * side);
    const vec3 skinned = octree.joints > 0 ? thesis_point(node.skin, instance_.joints, rest) : rest;
    const vec4 p(transform_point(instance_.placement, skinned), 1.0f);
    const float depth = dot(view_.depth, p), w = dot(view_.w, p);
    const vec2 at(dot(view_.x, p) / w, dot(view_.y, p) / w);
    const float focal = view_.x.x;
    const float size =
        side * (settings_.enlarge ? stretch_factor(node) : 1.0f) * octree.grid.voxel * focal / w;
    const bool seen = depth > view_.near;
    if (node.children != 0 && (!settings_.lod || !seen || size > settings_.pixel)) {
      uint32_t child = node.first_child;
      for (uint32_t bit = 0; bit < 8; ++bit) {
        if (node.children >> bit & 1) {
          visit(child++, place + (1u << (node.level - 1)) * uvec3(bit & 1, bit >> 1 & 1, bit >> 2));
        }
      }
    } else if (seen) {
      ++drawn;
      paint(at, 0.5f * size, make_key(depth, instance_.first_unit + (index >> 10), index & 1023));
    }
  }
  void paint(vec2 at, float half, VisibilityKey key) {
    for (uint32_t y = 0; y < view_.height; ++y) {
      for (uint32_t x = 0; x < view_.width; ++x) {
        const vec2 corner(static_cast<float>(x), static_cast<float>(y)), center = corner + 0.5f;
        const bool in_x =
            std::floor(at.x) == corner.x || (at.x - half <= center.x && center.x <= at.x + half);
        const bool in_y =
            std::floor(at.y) == corner.y || (at.y - half <= center.y && center.y <= at.y + half);
        VisibilityKey& pixel = keys[size_t{y} * view_.width + x];
        if (in_x && in_y) pixel = std::min(pixel, key);
      }
    }
  }
  const ThesisInstance& instance_;
  const RasterView& view_;
  const ThesisSettings& settings_;
};

TEST(Thesis, PicturesAreThoseOfTheRecursion) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const uint32_t side = 4u << seed % 4;
    const uint32_t joint_count = seed % 3 == 0 ? 0 : 5;
    const std::vector<ThesisVoxel> voxels = random_voxels(random, side, 150, joint_count);
    const ThesisOctree octree = make_thesis_octree(unit_grid(side), voxels, joint_count);
    const std::vector<Affine> joints = random_joints(random, 5);
    const quat turn = glm::angleAxis(0.3f * static_cast<float>(seed), normalize(vec3(1, 2, 3)));
    const Affine placement = trs(vec3(0.1f, 0.0f, 0.2f), turn, vec3(1.0f));
    const ThesisInstance instance{&octree, joints, placement, 7};
    const RasterView view = make_view(random.uniform(0.6f, 4.0f), 40.0f, 64, 48);
    const ThesisSettings settings{.lod = seed % 2 == 0, .enlarge = seed % 5 != 0};
    Visibility picture;
    ThesisScratch scratch;
    const ThesisStats stats = rasterize_thesis({&instance, 1}, view, settings, scratch, picture);
    const Recursion expected(instance, view, settings);
    EXPECT_EQ(stats.drawn, expected.drawn);
    size_t different = 0;
    for (size_t i = 0; i < picture.keys.size(); ++i) {
      different += picture.keys[i] != expected.keys[i];
    }
    // The size of a square is found in another order of roundings: a pixel centre may lie on it.
    EXPECT_LE(different, 2u);
  }
}

TEST(Thesis, LevelOfDetailStopsAtThePixel) {
  Random random(3);
  const std::vector<ThesisVoxel> voxels = random_voxels(random, 64, 4000, 0);
  const ThesisOctree octree = make_thesis_octree(unit_grid(64), voxels, 0);
  const ThesisInstance instance{&octree, {}, identity_affine(), 0};
  Visibility picture;
  ThesisScratch scratch;
  const auto draw = [&](float focal, bool lod) {
    return rasterize_thesis({&instance, 1}, make_view(10.0f, focal, 32, 32), {.lod = lod}, scratch,
                            picture);
  };
  EXPECT_EQ(draw(20.0f, false).leaves_drawn, voxels.size());
  const ThesisStats far = draw(20.0f, true);  // two pixels: 2^3 or 4^3 nodes
  EXPECT_LE(far.drawn, 64u);
  EXPECT_EQ(far.leaves_drawn, 0u);
  EXPECT_EQ(draw(2000.0f, true).leaves_drawn, voxels.size());
}

TEST(Thesis, KeysNameTheirNodesAndNormalsStayAtRest) {
  Random random(5);
  const std::vector<ThesisVoxel> voxels = random_voxels(random, 32, 3000, 3);
  const ThesisOctree octree = make_thesis_octree(unit_grid(32), voxels, 3);
  ASSERT_GT(octree.nodes.size(), 2048u);  // more than one unit
  const std::vector<Affine> joints = random_joints(random, 3);
  const ThesisInstance instances[] = {
      {&octree, joints, identity_affine(), 0},
      {&octree, joints, trs(vec3(0.4f, 0, 0), glm::identity<quat>(), vec3(2.0f)),
       unit_count(octree)}};
  Visibility picture;
  ThesisScratch scratch;
  rasterize_thesis(instances, make_view(3.0f, 40.0f, 64, 64), {}, scratch, picture);
  std::array<int, 2> seen{};
  for (const VisibilityKey key : picture.keys) {
    if (key == kNothing) continue;
    const VoxelSample sample = sample_thesis(instances, key);
    const ThesisNode& node = octree.nodes[size_t{sample.unit} << 10 | sample.code];
    EXPECT_NEAR(dot(sample.normal, node.normal), 1.0f, 1e-5f);
    EXPECT_EQ(sample.color, unpack_color(node.color));
    EXPECT_EQ(sample.level, node.level);
    EXPECT_FLOAT_EQ(sample.size,
                    (sample.instance ? 2.0f : 1.0f) / 32.0f * static_cast<float>(1u << node.level));
    ++seen[sample.instance];
  }
  EXPECT_GT(seen[0], 20);
  EXPECT_GT(seen[1], 20);
}

TEST(Thesis, VoxelsTakeWeightsFromTheNearestTriangle) {
  const std::vector<vec3> rest = {{0.0f, 0.0f, 0.5f}, {4.0f, 0.0f, 0.5f}, {0.0f, 4.0f, 0.5f},
                                  {0.0f, 0.0f, 0.9f}, {4.0f, 0.0f, 0.9f}, {0.0f, 4.0f, 0.9f}};
  const std::vector<uvec3> triangles = {{3, 4, 5}, {0, 1, 2}};
  const std::vector<uint16_t> materials = {1, 2};
  const std::vector<uint16_t> joints = {0, 1, 0, 1, 0, 1, 2, 0, 2, 0, 2, 0};
  const std::vector<float> weights = {1, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1, 0};
  const SvoSource source{triangles, materials, SkinMotion{rest, 2, joints, weights, 3}};
  const VoxelSurface surface{{vec3(0.0f), 1.0f, uvec3(4, 4, 1)},
                             {{morton_of({0, 0, 0}), 0, 1, 10},
                              {morton_of({0, 0, 0}), 1, 2, 20},
                              {morton_of({2, 0, 0}), kInside, 3, 30}},
                             2};
  const std::vector<ThesisVoxel> voxels = make_thesis_voxels(surface, source);
  ASSERT_EQ(voxels.size(), 2u);
  EXPECT_EQ(voxels[0].material, 2);
  EXPECT_EQ(voxels[0].normal, 2);
  EXPECT_EQ(voxels[0].color, 20);
  EXPECT_EQ(voxels[0].skin.joints[0], 0);
  EXPECT_FLOAT_EQ(voxels[0].skin.weights[0], 0.875f);  // (0.5, 0.5): an eighth of vertex 1
  EXPECT_FLOAT_EQ(voxels[0].skin.weights[1], 0.125f);
  EXPECT_EQ(voxels[1].color, 30);
  EXPECT_EQ(voxels[1].skin.weights[0], 0.0f);
  EXPECT_EQ(joint_count(source.motion), 3u);
}

}  // namespace
}  // namespace sinew
