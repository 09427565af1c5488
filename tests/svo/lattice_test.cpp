// The skin lattice: sheets, copies and corners against slow twins.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <set>

#include "sinew/base/parallel.h"
#include "sinew/svo/corners.h"
#include "svo/skinned_shape.h"
#include "svo/svo_oracle.h"

namespace sinew {
namespace {

using test::read_voxels;
using test::ReadVoxel;
using test::SkinnedShape;

// Least representative of each item, united by hand.
struct Classes {
  std::vector<uint32_t> parent;
  explicit Classes(size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0u); }
  uint32_t root(uint32_t i) const {
    while (parent[i] != i) i = parent[i];
    return i;
  }
  void unite(uint32_t a, uint32_t b) {
    a = root(a), b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  }
};

using Point = std::array<float, 3>;
Point point_of(vec3 p) {
  return {p.x, p.y, p.z};
}

// Sheets by brute force: of each cell, sets of triangles.
struct SlowSheets {
  struct Sheet {
    uint64_t cell = 0;
    std::set<uint32_t> triangles;
    std::set<Point> points;
  };
  std::vector<Sheet> sheets;
  std::map<uint64_t, std::vector<uint32_t>> of_cell;
};

std::set<Point> points_of(const test::Shape& shape, uint32_t triangle) {
  const uvec3 t = shape.triangles[triangle];
  return {point_of(shape.positions[t.x]), point_of(shape.positions[t.y]),
          point_of(shape.positions[t.z])};
}
bool meet(const std::set<Point>& a, const std::set<Point>& b) {
  return std::ranges::any_of(a, [&](const Point& p) { return b.contains(p); });
}

SlowSheets slow_sheets(const test::Shape& shape, const VoxelSurface& surface) {
  std::map<uint64_t, std::set<uint32_t>> triangles;
  for (const VoxelFragment& f : surface.fragments) triangles[f.voxel >> 9].insert(f.triangle);
  SlowSheets out;
  for (const auto& [cell, set] : triangles) {
    const std::vector<uint32_t> list(set.begin(), set.end());
    Classes classes(list.size());
    for (uint32_t i = 0; i < list.size(); ++i) {
      for (uint32_t j = 0; j < i; ++j) {
        if (meet(points_of(shape, list[i]), points_of(shape, list[j]))) classes.unite(i, j);
      }
    }
    std::map<uint32_t, SlowSheets::Sheet> by_root;
    for (uint32_t i = 0; i < list.size(); ++i) {
      SlowSheets::Sheet& sheet = by_root[classes.root(i)];
      sheet.cell = cell;
      sheet.triangles.insert(list[i]);
      sheet.points.merge(points_of(shape, list[i]));
    }
    for (auto& [root, sheet] : by_root) {
      out.of_cell[cell].push_back(static_cast<uint32_t>(out.sheets.size()));
      out.sheets.push_back(std::move(sheet));
    }
  }
  return out;
}

// For each sheet and corner its class: which corners must be one.
Classes slow_corners(const SlowSheets& sheets) {
  Classes classes(8 * sheets.sheets.size());
  for (uint32_t a = 0; a < sheets.sheets.size(); ++a) {
    const glm::ivec3 at(voxel_of(sheets.sheets[a].cell));
    for (uint32_t b = 0; b < a; ++b) {
      const glm::ivec3 other(voxel_of(sheets.sheets[b].cell));
      if (glm::any(glm::greaterThan(glm::abs(other - at), glm::ivec3(1)))) continue;
      if (at == other || !meet(sheets.sheets[a].points, sheets.sheets[b].points)) continue;
      for (uint32_t k = 0; k < 8; ++k) {
        for (uint32_t l = 0; l < 8; ++l) {
          const glm::ivec3 p = at + glm::ivec3(k & 1, k >> 1 & 1, k >> 2);
          if (p == other + glm::ivec3(l & 1, l >> 1 & 1, l >> 2))
            classes.unite(8 * a + k, 8 * b + l);
        }
      }
    }
  }
  return classes;
}

// The triangle of each colour that color_of_triangle gives; they differ in these shapes.
SkinnedShape two_twisted_shapes(uint32_t seed) {
  SkinnedShape body;
  Random random(seed);
  body.shape = test::sphere(3);
  const test::Shape inner = test::sphere(2);
  const auto first = static_cast<uint32_t>(body.shape.positions.size());
  for (const vec3 p : inner.positions) {
    body.shape.positions.push_back(vec3(0.9f, 1.05f, 0.7f) * p + 0.01f * random.uniform3(-1, 1));
  }
  for (const uvec3 t : inner.triangles) body.shape.triangles.push_back(t + first);
  body.shape.positions = test::twisted(body.shape.positions, 1.5f);
  const std::vector<vec3> rest = body.shape.positions;
  body.follow_along(vec3(0.4f, 0.3f, 0.6f), 5);
  std::vector<vec3> bulge;
  for (const vec3 p : rest) bulge.push_back(p.z > 0.3f ? 0.2f * p : vec3(0.0f));
  body.add_target(bulge);
  return body;
}

// One value of everything that moves a corner.
using CornerValue = std::vector<int>;
CornerValue value_of(const Svo& svo, uint32_t block, uint32_t corner) {
  const SvoBlock& b = svo.blocks[block];
  CornerValue out;
  for (uint32_t k = 0; k < kSvoInfluences; ++k) {
    out.push_back(svo.joint_palette[b.first_joint + svo.corner_joints[b.first_corner + corner][k]]);
    out.push_back(svo.corner_weights[b.first_corner + corner][k]);
    if (out.back() == 0) out[out.size() - 2] = 0;
  }
  std::map<uint32_t, std::array<int16_t, 3>> deltas;
  for (uint32_t t = b.first_target; t < svo.blocks[block + 1].first_target; ++t) {
    deltas[svo.targets[t].target] = svo.deltas[svo.targets[t].first_delta + corner];
  }
  for (uint32_t t = 0; t < svo.morph_targets; ++t) {
    for (const int16_t d : deltas[t]) out.push_back(d);
  }
  return out;
}

class Lattice : public testing::TestWithParam<uint32_t> {};

TEST_P(Lattice, SheetsAndCornersAreThoseOfTheSlowTwin) {
  const uint32_t resolution = GetParam(), seed = 77 + resolution;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  SkinnedShape body = two_twisted_shapes(seed);
  const VoxelSurface surface = *body.voxelized(resolution);
  const Result<Svo> made = make_svo(surface, body.source());
  ASSERT_TRUE(made) << made.error().message();
  const Svo& svo = *made;
  ASSERT_EQ(validate(svo), "");
  const SlowSheets slow = slow_sheets(body.shape, surface);
  const Classes classes = slow_corners(slow);

  // Which voxels each sheet must have.
  // Two sheets of one cell may have
  // the same voxels: then it cannot be told which copy is whose, and their corners are left out.
  std::map<std::pair<uint64_t, std::set<uint64_t>>, std::vector<uint32_t>> sheets_of_voxels;
  for (uint32_t s = 0; s < slow.sheets.size(); ++s) {
    std::set<uint64_t> voxels;
    for (const VoxelFragment& f : surface.fragments) {
      if (f.voxel >> 9 == slow.sheets[s].cell && slow.sheets[s].triangles.contains(f.triangle)) {
        voxels.insert(f.voxel);
      }
    }
    sheets_of_voxels[{slow.sheets[s].cell, voxels}].push_back(s);
  }
  std::vector<std::set<uint64_t>> of_cell(svo.cells.size());
  std::vector<uint32_t> block_of(svo.cells.size());
  for (const ReadVoxel& v : read_voxels(svo)) {
    EXPECT_TRUE(of_cell[v.cell].insert(morton_of(v.voxel)).second);
    block_of[v.cell] = v.block;
  }
  ASSERT_EQ(svo.cells.size(), slow.sheets.size());
  EXPECT_GE(sheets_of_voxels.size(), 0.99 * static_cast<double>(slow.sheets.size()) - 2.0);
  std::map<uint32_t, std::set<std::pair<uint32_t, uint32_t>>> corners_of_class;
  std::map<std::pair<uint32_t, uint32_t>, std::set<uint32_t>> classes_of_corner;
  for (uint32_t c = 0; c < svo.cells.size(); ++c) {
    const auto found = sheets_of_voxels.find({*of_cell[c].begin() >> 9, of_cell[c]});
    ASSERT_NE(found, sheets_of_voxels.end()) << "cell " << c << " has the voxels of no sheet";
    if (found->second.size() > 1) continue;
    for (uint32_t k = 0; k < 8; ++k) {
      const uint32_t root = classes.root(8 * found->second[0] + k);
      const std::pair<uint32_t, uint32_t> corner{block_of[c], svo.cells[c].corner[k]};
      corners_of_class[root].insert(corner);
      classes_of_corner[corner].insert(root);
    }
  }
  for (const auto& [corner, roots] : classes_of_corner) EXPECT_EQ(roots.size(), 1u);
  for (const auto& [root, corners] : corners_of_class) {
    std::set<uint32_t> blocks;
    std::set<CornerValue> values;
    for (const auto& [block, corner] : corners) {
      EXPECT_TRUE(blocks.insert(block).second) << "a class with two corners in a block";
      values.insert(value_of(svo, block, corner));
    }
    EXPECT_EQ(values.size(), 1u) << "a corner that differs between blocks";
  }
}
INSTANTIATE_TEST_SUITE_P(Resolutions, Lattice, testing::Values(1u, 5u, 60u, 90u, 140u));

// Large triangles: their vertices are in many cells at once.
TEST(LatticeJoins, LargeTrianglesJoinAllTheirCells) {
  SkinnedShape body;
  body.shape = test::sphere(0);
  body.follow_along(vec3(0, 0, 1), 3);
  const VoxelSurface surface = *body.voxelized(150);
  const Svo svo = *make_svo(surface, body.source());
  ASSERT_EQ(validate(svo), "");
  std::map<std::array<uint32_t, 3>, std::set<CornerValue>> values;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    std::set<uint16_t> places;
    for (uint32_t i = block.first_corner; i < svo.blocks[b + 1].first_corner; ++i) {
      const uint16_t place = svo.corner_places[i];
      EXPECT_TRUE(places.insert(place).second);
      const auto& p = kCornerPlaceTable.at[place];
      values[{8u * block.x + p[0], 8u * block.y + p[1], 8u * block.z + p[2]}].insert(
          value_of(svo, b, i - block.first_corner));
    }
  }
  for (const auto& [place, set] : values) EXPECT_EQ(set.size(), 1u);
}

SkinnedShape two_plates() {
  SkinnedShape body;
  test::add_plate(body.shape, vec2(0.0f), vec2(1.0f), 0.5f, 8);
  const auto first = static_cast<uint32_t>(body.shape.positions.size());
  test::add_plate(body.shape, vec2(0.0f), vec2(1.0f), 0.53f, 8);
  for (uint32_t v = 0; v < body.shape.positions.size(); ++v) body.follow(v, v < first ? 0 : 1);
  return body;
}

TEST(LatticeJoins, ClosePlatesOfDifferentLimbsMoveApart) {
  SkinnedShape body = two_plates();
  const Svo svo = *make_svo(*body.voxelized(100), body.source());
  ASSERT_EQ(validate(svo), "");
  const SvoMotion motion = make_svo_motion(svo);
  const Affine joints[2] = {identity_affine(),
                            trs(vec3(3, 1, 2), glm::angleAxis(1.0f, vec3(0, 1, 0)), vec3(1.5f))};
  Pose pose;
  pose.joints = joints;
  PosedSvo posed;
  posed.set_pose(motion, pose);
  for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
  size_t together = 0;
  for (const ReadVoxel& v : read_voxels(svo)) {
    const SvoCell& cell = svo.cells[v.cell];
    const vec3 rest = svo.grid.center(v.voxel);
    const vec3 local = (vec3(v.voxel % 8u) + 0.5f) / 8.0f;
    const uint32_t joint = rest.z < 0.515f ? 0 : 1;
    const vec3 moved = map_point(cell, posed.block(v.block), local);
    EXPECT_LT(length(moved - transform_point(joints[joint], rest)), 1e-4f);
    const mat3 normals = map_normals(cell, posed.block(v.block), local);
    const mat3 expected = cofactor(joints[joint]);
    for (int i = 0; i < 3; ++i) EXPECT_LT(length(normals[i] - expected[i]), 1e-3f);
  }
  for (size_t c = 1; c < svo.cells.size(); ++c) {
    if (svo.cells[c].place == svo.cells[c - 1].place) ++together;
  }
  EXPECT_GT(together, 50u);
}

// A seam: the vertices stand twice, with equal positions.
TEST(LatticeJoins, SeamsDoNotTear) {
  SkinnedShape body;
  test::add_plate(body.shape, vec2(0.0f), vec2(0.5f, 1.0f), 0.5f, 8);
  test::add_plate(body.shape, vec2(0.5f, 0.0f), vec2(1.0f, 1.0f), 0.5f, 8);
  body.follow_along(vec3(1, 0, 0), 2);
  const Svo svo = *make_svo(*body.voxelized(80), body.source());
  for (size_t c = 1; c < svo.cells.size(); ++c) {
    const SvoCell &a = svo.cells[c - 1], &b = svo.cells[c];
    EXPECT_FALSE(a.place == b.place && std::ranges::equal(a.corner, b.corner));
    EXPECT_NE(a.place, b.place);
  }
}

TEST(LatticeMaterials, OneSheetHasACopyForEachMaterialWithCommonCorners) {
  SkinnedShape body;
  body.shape = test::sphere(3);
  body.follow_along(vec3(0, 0, 1), 3);
  body.materials.resize(body.shape.triangles.size());
  for (uint32_t t = 0; t < body.materials.size(); ++t)
    body.materials[t] = static_cast<uint16_t>(t % 3);
  const VoxelSurface surface = *body.voxelized(60);
  const Svo svo = *make_svo(surface, body.source());
  ASSERT_EQ(validate(svo), "");
  EXPECT_EQ(svo.voxel_count(), surface.voxels);
  for (size_t c = 1; c < svo.cells.size(); ++c) {
    const SvoCell &a = svo.cells[c - 1], &b = svo.cells[c];
    if (a.place != b.place) continue;
    EXPECT_NE(a.material, b.material);
    EXPECT_TRUE(std::ranges::equal(a.corner, b.corner));
  }
  // Each voxel has the material of most of its triangles, the lowest of equals.
  std::map<uint64_t, std::map<int, int>> counts;
  for (const VoxelFragment& f : surface.fragments) --counts[f.voxel][f.triangle % 3];
  for (const ReadVoxel& v : read_voxels(svo)) {
    std::pair<int, int> best{1, 0};
    for (const auto& [material, count] : counts[morton_of(v.voxel)]) {
      best = std::min(best, {count, material});
    }
    EXPECT_EQ(v.material, best.second);
  }
}

TEST(LatticeSoup, ManyPiecesInACellAreOneSheet) {
  SkinnedShape body;
  body.shape = test::random_triangles(3000, 5, 0.02f);
  body.follow_along(vec3(1, 0, 0), 4);
  for (const uint32_t resolution : {1u, 8u, 40u}) {
    const VoxelSurface surface = *body.voxelized(resolution, {.shell = Shell::conservative});
    const Result<Svo> svo = make_svo(surface, body.source());
    ASSERT_TRUE(svo) << svo.error().message();
    EXPECT_EQ(validate(*svo), "");
    std::set<uint64_t> voxels;
    for (const ReadVoxel& v : read_voxels(*svo)) voxels.insert(morton_of(v.voxel));
    EXPECT_EQ(voxels.size(), surface.voxels);
  }
}

// Voxels on both sides of a face between cells, of one smooth closed surface: its triangles much
// larger than voxels, and much smaller.
TEST(LatticeJoins, NeighboursOfOneSurfaceShareTheirFace) {
  for (const auto& [levels, resolution] : {std::pair{2, 200u}, {4, 70u}, {6, 40u}, {6, 150u}}) {
    for (const Shell shell : {Shell::thin, Shell::conservative}) {
      SkinnedShape body;
      body.shape = test::sphere(levels);
      body.follow_along(vec3(0.8f, 0.0f, 0.5f), 5);
      const Svo svo = *make_svo(*body.voxelized(resolution, {.shell = shell}), body.source());
      std::map<uint64_t, ReadVoxel> voxels;
      for (const ReadVoxel& v : read_voxels(svo)) {
        EXPECT_TRUE(voxels.emplace(morton_of(v.voxel), v).second) << "a second sheet";
      }
      size_t faces = 0;
      for (const auto& [morton, v] : voxels) {
        for (int axis = 0; axis < 3; ++axis) {
          uvec3 next = v.voxel;
          ++next[axis];
          const auto other = voxels.find(morton_of(next));
          if (other == voxels.end() || next[axis] % 8 != 0) continue;
          ++faces;
          const SvoCell &a = svo.cells[v.cell], &b = svo.cells[other->second.cell];
          for (uint32_t k = 0; k < 8; ++k) {
            if (!(k >> axis & 1)) continue;
            EXPECT_EQ(value_of(svo, v.block, a.corner[k]),
                      value_of(svo, other->second.block, b.corner[k ^ (1u << axis)]));
          }
        }
      }
      EXPECT_GT(faces, 100u);
    }
  }
}

TEST(LatticeSolid, FilledCellsFollowTheirSurfaceWithoutTears) {
  SkinnedShape body;
  body.shape = test::sphere(4);
  body.follow_along(vec3(0.8f, 0.0f, 0.5f), 3);
  const VoxelSurface surface = *body.voxelized(90, {.solid = true});
  const Svo svo = *make_svo(surface, body.source());
  ASSERT_EQ(validate(svo), "");
  std::map<uint64_t, ReadVoxel> voxels;
  for (const ReadVoxel& v : read_voxels(svo)) voxels[morton_of(v.voxel)] = v;
  EXPECT_EQ(voxels.size(), surface.voxels);
  EXPECT_EQ(svo.voxel_count(), surface.voxels);
  Random random(3);
  const std::vector<Affine> joints = test::random_joints(3, random);
  Pose pose;
  pose.joints = joints;
  const SvoMotion motion = make_svo_motion(svo);
  PosedSvo posed;
  posed.set_pose(motion, pose);
  for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
  size_t faces = 0;
  for (const auto& [morton, v] : voxels) {
    for (int axis = 0; axis < 3; ++axis) {
      uvec3 next = v.voxel;
      ++next[axis];
      const auto other = voxels.find(morton_of(next));
      if (other == voxels.end() || next[axis] % 8 != 0) continue;
      vec3 local = (vec3(v.voxel % 8u) + 0.5f) / 8.0f;
      local[axis] = 1.0f;
      const vec3 here = map_point(svo.cells[v.cell], posed.block(v.block), local);
      local[axis] = 0.0f;
      const ReadVoxel& w = other->second;
      const vec3 there = map_point(svo.cells[w.cell], posed.block(w.block), local);
      EXPECT_LE(length(here - there), 1e-5f * (1.0f + length(here))) << morton;
      ++faces;
    }
  }
  EXPECT_GT(faces, 10000u);
}

void expect_equal(const Svo& a, const Svo& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  EXPECT_TRUE(same(a.nodes, b.nodes) && same(a.blocks, b.blocks) && same(a.cells, b.cells));
  EXPECT_TRUE(same(a.bricks, b.bricks) && same(a.normals, b.normals));
  EXPECT_TRUE(same(a.color_ends, b.color_ends) && same(a.color_selectors, b.color_selectors));
  EXPECT_TRUE(same(a.corner_joints, b.corner_joints) && same(a.corner_weights, b.corner_weights));
  EXPECT_TRUE(same(a.deltas, b.deltas) && same(a.brick_level.colors, b.brick_level.colors));
  EXPECT_TRUE(same(a.node_level.normals, b.node_level.normals));
}

TEST(LatticeThreads, SameBitsForAnyNumber) {
  SkinnedShape body = two_twisted_shapes(9);
  const VoxelSurface surface = *body.voxelized(180, {.solid = true});
  std::vector<Svo> made;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    made.push_back(*make_svo(surface, body.source()));
  }
  expect_equal(made[0], made[1]);
  expect_equal(made[0], made[2]);
}

TEST(LatticeErrors, BadSourcesAreRefused) {
  SkinnedShape body = two_plates();
  const VoxelSurface surface = *body.voxelized(20);
  SkinnedShape bad = body;
  bad.joints[0] = 7;  // of 2
  EXPECT_FALSE(make_svo(surface, bad.source()));
  bad = body;
  bad.shape.triangles[3].y = 100000;
  EXPECT_FALSE(make_svo(surface, bad.source()));
  SvoSource source = body.source();
  source.materials = source.materials.first(3);
  EXPECT_FALSE(make_svo(surface, source));
  VoxelSurface wrong = surface;
  wrong.fragments.back().triangle = 1u << 20;
  EXPECT_FALSE(make_svo(wrong, body.source()));
  EXPECT_FALSE(make_svo(VoxelSurface{surface.grid, {}, 0}, body.source()));
}

}  // namespace
}  // namespace sinew
