// Voxels for rays: boxes and hits against a slow twin in double, levels of detail, closed surfaces,
// and that hits have the same bits whoever asks.
#include "sinew/svo/leaves.h"

#include <gtest/gtest.h>

#include <memory>
#include <unordered_map>

#include "allocations.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/trace/traverse.h"
#include "svo/raster_oracle.h"
#include "svo/skinned_shape.h"

namespace sinew {
namespace {

using glm::dvec3;
using test::ReadVoxel;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct RayBody {
  Svo svo;
  SvoMotion motion;
  SvoLeafLayout layout;
  PosedSvo posed;
  SvoLeaves leaves;
  std::vector<ReadVoxel> voxels;
  std::vector<Affine> joints;
  std::vector<float> weights;
  Instance instance;

  explicit RayBody(Svo octree) : svo(std::move(octree)) {
    motion = make_svo_motion(svo);
    layout = *make_leaf_layout(svo);
    voxels = test::read_voxels(svo);
    joints.assign(svo.joints, identity_affine());
    weights.assign(svo.morph_targets, 1.0f);
    pose();
  }
  RayBody(const RayBody&) = delete;

  void pose(std::span<const uint8_t> resident = {}) {
    Pose now;
    now.joints = joints;
    now.weights = weights;
    posed.set_pose(motion, now);
    leaves.set_pose(layout, posed, resident);
    instance.boxes = &leaves.body();
    instance.object = 3;
  }
  void place(const Affine& placement) {
    instance.placement = placement;
    instance.to_object = inverse_affine(placement);
    instance.in_place = false;
  }
  SceneView scene() const { return {nullptr, &instance, 1, nullptr}; }
  Box box() const {
    const Box local = leaves.bounds();
    return instance.in_place ? local : transform_box(instance.placement, local);
  }
};

// Small balls of which each follows a joint of its own: cells have many copies, nodes of the octree
// more than eight children.
std::unique_ptr<RayBody> crowded_body(uint32_t seed) {
  Random random(seed);
  test::SkinnedShape shape;
  shape.joint_count = 120;
  const test::Shape ball = test::sphere(1);
  for (uint16_t joint = 0; joint < 120; ++joint) {
    const vec3 center = random.uniform3(0.0f, 1.0f);
    const auto first = static_cast<uint32_t>(shape.shape.positions.size());
    for (const vec3 p : ball.positions) {
      shape.shape.positions.push_back(center + 0.06f * p);
      shape.follow(static_cast<uint32_t>(shape.shape.positions.size()) - 1, joint);
    }
    for (const uvec3 t : ball.triangles) shape.shape.triangles.push_back(first + t);
  }
  auto out = std::make_unique<RayBody>(*make_svo(*shape.voxelized(28), shape.source()));
  for (Affine& joint : out->joints) {
    joint = trs(random.uniform3(-0.5f, 0.5f), glm::angleAxis(1.0f, random.direction()), vec3(1));
  }
  out->pose();
  return out;
}

// Kind 0: a ball of plain voxels that is bent; 1: a skinned one; 2: see crowded_body().
std::unique_ptr<RayBody> random_body(uint32_t kind, uint32_t seed) {
  if (kind == 2) return crowded_body(seed);
  Random random(seed);
  if (kind == 0) {  // a ball, its corners moved at random: folds
    const VoxelGrid grid{vec3(-0.5f), 1.0f / 90.0f, uvec3(90)};
    Svo svo = *make_svo(grid, test::random_voxels(90, 3000, 2, seed));
    const float most = random.uniform(0.0f, 1.2f) * 8.0f / 90.0f;
    test::bend(svo, 1.2f * 8.0f / 90.0f, [&](uvec3 c) {
      return Random(seed + c.x + 1000 * c.y + 1000000 * c.z).uniform3(-most, most);
    });
    return std::make_unique<RayBody>(std::move(svo));
  }
  test::SkinnedShape shape;
  shape.shape = test::sphere(3);
  shape.shape.positions = test::twisted(shape.shape.positions, 1.0f);
  shape.follow_along(vec3(0.5f, -0.2f, 0.6f), 6);
  auto out = std::make_unique<RayBody>(*make_svo(*shape.voxelized(70), shape.source()));
  out->joints = test::random_joints(shape.joint_count, random);
  out->pose();
  return out;
}

struct DoubleBox {
  dvec3 min{std::numeric_limits<double>::infinity()};
  dvec3 max{-std::numeric_limits<double>::infinity()};
  void extend(dvec3 p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
};

// Where the voxel is, `margin` voxels larger on every side.
DoubleBox twin_box(const RayBody& body, uint32_t cell, uint32_t block, VoxelCode code,
                   double margin) {
  const VoxelPlace place = place_of(code);
  DoubleBox out;
  for (uint32_t i = 0; i < 8; ++i) {
    dvec3 at(place.min);
    for (int axis = 0; axis < 3; ++axis) {
      at[axis] += i >> axis & 1 ? place.side + margin : -margin;
    }
    out.extend(test::lattice_point(body.svo.cells[cell], body.posed.block(block), at));
  }
  return out;
}

// Where the ray enters the box, infinity if it does not.
double enter(const DoubleBox& box, const Ray& ray, double spare) {
  double near = ray.t_min, far = double{ray.t_max};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = double{ray.origin[axis]}, d = double{ray.direction[axis]};
    const double low = box.min[axis] - spare, high = box.max[axis] + spare;
    if (d == 0.0) {
      if (o < low || o > high) return std::numeric_limits<double>::infinity();
      continue;
    }
    near = std::max(near, std::min((low - o) / d, (high - o) / d));
    far = std::min(far, std::max((low - o) / d, (high - o) / d));
  }
  return near <= far ? near : std::numeric_limits<double>::infinity();
}

// Half of them through a point of the box from all sides, half alike.
std::vector<Ray> random_rays(const Box& box, size_t count, Random& random) {
  std::vector<Ray> rays;
  const vec3 extent = box.extent();
  const float size = length(extent);
  while (rays.size() < count) {
    const vec3 eye = box.center() + size * random.direction();
    const vec3 at = box.min + extent * random.uniform3(0.0f, 1.0f);
    for (int i = 0; i < 80; ++i) {
      Ray ray{eye, 0.0f, at - eye + 0.05f * size * random.uniform3(-1.0f, 1.0f)};
      if (rays.size() / 800 % 2 == 1) {
        ray.origin = box.min + extent * random.uniform3(0.0f, 1.0f);
        ray.direction = random.direction();
        if (i % 4 == 0) ray.t_max = 0.2f * size;
      }
      if (i % 16 == 5) ray.direction[static_cast<int>(random.next() % 3)] = 0.0f;
      rays.push_back(ray);
    }
  }
  return rays;
}

std::vector<Hit> hits_of(const SceneView& scene, std::span<const Ray> rays,
                         const QueryOptions& options = {}) {
  std::vector<Hit> hits(rays.size());
  closest_hits(scene, rays, hits, options);
  return hits;
}

TEST(SvoLeaves, HitsAreThoseOfASlowTwin) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto body = random_body(seed % 3, seed);
    Random random(seed);
    const std::vector<Ray> rays = random_rays(body->box(), 240, random);
    const std::vector<Hit> hits = hits_of(body->scene(), rays, {.grouping = Grouping::none});
    for (uint32_t b = 0; b < body->svo.block_count(); ++b) body->posed.make_block(b);
    std::vector<DoubleBox> must, may;
    std::unordered_map<uint32_t, size_t> index;
    double size = 0.0;
    for (const ReadVoxel& v : body->voxels) {
      index[voxel_primitive(v.cell, v.code)] = must.size();
      must.push_back(twin_box(*body, v.cell, v.block, v.code, 0.0));
      may.push_back(twin_box(*body, v.cell, v.block, v.code, double{kRayMargin}));
      size = std::max({size, length(must.back().min), length(must.back().max)});
    }
    const double spare = 1e-5 * size;
    size_t met = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity(), could = nearest;
      for (size_t v = 0; v < must.size(); ++v) {
        nearest = std::min(nearest, enter(must[v], rays[i], 0.0));
        could = std::min(could, enter(may[v], rays[i], spare));
      }
      const double t = double{hits[i].t}, rounding = 1e-6 * std::abs(t);
      ASSERT_LE(t, nearest * (1.0 + 1e-6)) << "ray " << i;
      if (!hits[i]) continue;
      ++met;
      ASSERT_GE(t + rounding, could) << "ray " << i;
      ASSERT_TRUE(index.contains(hits[i].primitive)) << "ray " << i;
      const double own = enter(may[index[hits[i].primitive]], rays[i], spare);
      ASSERT_LE(own, t + rounding) << "ray " << i;
    }
    EXPECT_GT(met, rays.size() / 20);
  }
}

void expect_same(const std::vector<Hit>& a, const std::vector<Hit>& b, const char* what) {
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(std::bit_cast<uint32_t>(a[i].t), std::bit_cast<uint32_t>(b[i].t)) << what << i;
    ASSERT_EQ(a[i].primitive, b[i].primitive) << what << i;
    ASSERT_EQ(a[i].object, b[i].object) << what << i;
  }
}

TEST(SvoLeaves, HitsAreDeterministicAloneInGroupsAndOnManyThreads) {
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto body = random_body(seed % 3, seed);
    Random random(seed);
    if (seed % 4 >= 2) {
      body->place(trs(random.uniform3(-3.0f, 3.0f), glm::angleAxis(1.0f, random.direction()),
                      random.uniform3(0.3f, 3.0f)));
    }
    const std::vector<Ray> rays = random_rays(body->box(), 8000, random);
    const float voxel = body->svo.grid.voxel;
    const auto third = [](const void*, uint32_t ray, const Hit& hit) {
      return (hit.primitive + ray) % 3 == 0;
    };
    for (const RayFootprint footprint :
         {RayFootprint{}, RayFootprint{2.0f * voxel, 0.0f}, RayFootprint{0.0f, 0.7f * voxel}}) {
      for (const HitFilter filter : {HitFilter{}, HitFilter{third, nullptr, true}}) {
        const QueryOptions alone{
            .grouping = Grouping::none, .filter = filter, .footprint = footprint};
        QueryOptions grouped = alone;
        grouped.grouping = Grouping::automatic;
        body->pose();
        const std::vector<Hit> expected = hits_of(body->scene(), rays, alone);
        body->pose();
        expect_same(expected, hits_of(body->scene(), rays, grouped), "grouped ");
        std::vector<uint8_t> any(rays.size()), any_alone(rays.size());
        any_hits(body->scene(), rays, any, grouped);
        any_hits(body->scene(), rays, any_alone, alone);
        std::vector<Hit> counted(rays.size());
        std::vector<TraversalCounts> counts(rays.size());
        count_closest_hits(body->scene(), rays, counted, counts, alone);
        expect_same(expected, counted, "counted ");
        for (size_t i = 0; i < rays.size(); ++i) {
          ASSERT_EQ(any[i] != 0, static_cast<bool>(expected[i])) << i;
          ASSERT_EQ(any_alone[i] != 0, static_cast<bool>(expected[i])) << i;
        }
        // Each thread begins elsewhere, all make the same cells at the same time.
        body->pose();
        std::vector<Hit> parallel(rays.size());
        parallel_for(rays.size(), 320, [&](size_t begin, size_t end) {
          QueryOptions part = grouped;
          part.first_ray = static_cast<uint32_t>(begin);
          closest_hits(body->scene(), std::span(rays).subspan(begin, end - begin),
                       std::span(parallel).subspan(begin, end - begin), part);
        });
        expect_same(expected, parallel, "parallel ");
      }
    }
    const std::vector<Hit> hits = hits_of(body->scene(), rays);
    for (size_t i = 0; i < 300; ++i) {
      std::vector<Hit> all;
      all_hits(body->scene(), rays[i], all);
      ASSERT_EQ(all.empty(), !hits[i]) << i;
      if (hits[i]) {
        ASSERT_EQ(all[0].primitive, hits[i].primitive) << i;
      }
    }
    EXPECT_TRUE(hits_of(body->scene(), rays, {.mask = 0})[0].object == kNoObject);
  }
}

TEST(SvoLeaves, ThreadsMayMeetAtOneBlock) {
  const auto body = random_body(1, 5);
  Random random(5);
  const std::vector<Ray> rays = random_rays(body->box(), 400, random);
  const std::vector<Hit> expected = hits_of(body->scene(), rays);
  for (int round = 0; round < 30; ++round) {
    body->pose();
    std::vector<std::vector<Hit>> hits(8);
    parallel_for(8, 1, [&](size_t k, size_t) {
      hits[k] = hits_of(body->scene(), rays,
                        {.grouping = k % 2 == 0 ? Grouping::none : Grouping::automatic});
    });
    for (const std::vector<Hit>& h : hits) expect_same(expected, h, "thread's ");
  }
}

// Every box of every level, by primitive.
using Boxes = std::unordered_map<uint32_t, Box>;
void add_boxes(const BoxBody& body, uint32_t word, uint32_t level, const Box& above, Boxes& out) {
  if (is_leaf_word(word)) {
    for (uint32_t p = leaf_first(word); p < leaf_first(word) + leaf_packets(word); ++p) {
      for (uint32_t lane = 0; lane < kWidth; ++lane) {
        if (body.nodes[p].child[lane] == kNoChild) continue;
        const Box box = lane_box(body.nodes[p], lane);
        ASSERT_TRUE(above.contains(box));
        ASSERT_TRUE(out.emplace(body.nodes[p].child[lane], box).second);
      }
    }
  } else if (is_inner_word(word)) {
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t child = body.nodes[word].child[lane];
      if (child == kNoChild) continue;
      const Box box = lane_box(body.nodes[word], lane);
      ASSERT_TRUE(above.contains(box));
      add_boxes(body, child, level, box, out);
    }
  } else if (treelet_of(word) < body.parts) {
    add_boxes(body, body.part_root[treelet_of(word)], level, above, out);
  } else {
    const BoxDetail& detail = body.details[treelet_of(word) - body.parts];
    const Box box{vec3(detail.low[0], detail.low[1], detail.low[2]),
                  vec3(detail.high[0], detail.high[1], detail.high[2])};
    ASSERT_TRUE(above.contains(box));
    if (level == kCellLevel) {
      out.emplace(detail.whole, box);
    } else {
      add_boxes(body, detail.root[level], level, box, out);
    }
  }
}

TEST(SvoLeaves, CoarserLevelsContainFinerOnes) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto body = random_body(seed % 3, seed);
    Boxes levels[kBoxLevels];
    const Box everything{vec3(-kInfinity), vec3(kInfinity)};
    for (uint32_t l = 0; l < kBoxLevels; ++l) {
      body->leaves.make_all(l);
      add_boxes(body->leaves.body(), body->leaves.body().root, l, everything, levels[l]);
      for (const auto& [primitive, box] : levels[l]) {
        ASSERT_TRUE(body->leaves.bounds().contains(box));
      }
    }
    EXPECT_EQ(levels[0].size(), body->voxels.size());
    EXPECT_EQ(levels[2].size(), body->svo.bricks.size());
    EXPECT_EQ(levels[3].size(), body->svo.cells.size());
    std::unordered_map<uint32_t, uint32_t> finer[kBoxLevels];
    for (const ReadVoxel& v : body->voxels) {
      const Box& box = levels[0].at(voxel_primitive(v.cell, v.code));
      const DoubleBox twin = twin_box(*body, v.cell, v.block, v.code, 0.0);
      ASSERT_TRUE(glm::all(glm::lessThanEqual(dvec3(box.min), twin.min)));
      ASSERT_TRUE(glm::all(glm::greaterThanEqual(dvec3(box.max), twin.max)));
      for (uint32_t l = 1; l < kBoxLevels; ++l) {
        const uvec3 at = place_of(v.code).min >> l;
        const uint32_t bits = 3 - l;
        const uint32_t primitive =
            voxel_primitive(v.cell, kFirstCode[l] + (at.x | at.y << bits | at.z << 2 * bits));
        ASSERT_TRUE(levels[l].at(primitive).contains(box)) << "level " << l;
        ++finer[l][primitive];
      }
    }
    for (uint32_t l = 1; l < kBoxLevels; ++l) EXPECT_EQ(finer[l].size(), levels[l].size());
  }
}

// A wide ray meets what a narrow one meets, or something before it.
TEST(SvoLeaves, FootprintsChooseLevels) {
  const auto body = random_body(1, 3);
  Random random(3);
  const std::vector<Ray> rays = random_rays(body->box(), 2000, random);
  body->joints.assign(body->joints.size(), identity_affine());
  body->pose();
  const std::vector<Hit> fine = hits_of(body->scene(), rays);
  const float voxel = body->svo.grid.voxel;
  for (uint32_t level = 0; level < kBoxLevels; ++level) {
    const float width = 0.9f * voxel * static_cast<float>(1u << level);
    const std::vector<Hit> wide = hits_of(body->scene(), rays, {.footprint = {width, 0.0f}});
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_LE(wide[i].t, fine[i].t * 1.00001f);
      if (!wide[i]) continue;
      ASSERT_EQ(level_of(code_of_primitive(wide[i].primitive)), level);
    }
  }
  // Twice as large and twice as wide is the same.
  const RayFootprint footprint{0.0f, 1.5f * voxel};
  const std::vector<Hit> before = hits_of(body->scene(), rays, {.footprint = footprint});
  body->place(trs(vec3(0.0f), glm::angleAxis(0.0f, vec3(1, 0, 0)), vec3(2.0f)));
  std::vector<Ray> twice = rays;
  for (Ray& ray : twice) {
    ray.origin *= 2.0f;
    ray.t_max *= 2.0f;
  }
  const std::vector<Hit> after = hits_of(body->scene(), twice, {.footprint = footprint});
  for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(before[i].primitive, after[i].primitive);
}

TEST(SvoLeaves, WhatIsNotResidentIsMetAsCells) {
  const auto body = random_body(1, 9);
  Random random(9);
  const std::vector<Ray> rays = random_rays(body->box(), 3000, random);
  std::vector<uint8_t> resident(body->svo.block_count());
  for (uint8_t& r : resident) r = random.next() % 2;
  const std::vector<uint64_t> bricks = body->svo.bricks;
  for (uint32_t b = 0; b < body->svo.block_count(); ++b) {
    if (resident[b] != 0) continue;
    const auto first = body->svo.bricks.begin();
    std::fill(first + body->svo.blocks[b].first_brick, first + body->svo.blocks[b + 1].first_brick,
              ~uint64_t{0});
  }
  body->pose(resident);
  size_t cells = 0;
  for (const Hit& hit : hits_of(body->scene(), rays)) {
    if (!hit) continue;
    uint32_t block = 0;
    while (body->svo.blocks[block + 1].first_cell <= cell_of_primitive(hit.primitive)) ++block;
    ASSERT_EQ(level_of(code_of_primitive(hit.primitive)), resident[block] != 0 ? 0u : kCellLevel);
    cells += resident[block] == 0;
  }
  EXPECT_GT(cells, 0u);
  body->svo.bricks = bricks;
  body->pose();
  for (const Hit& hit : hits_of(body->scene(), rays)) {
    EXPECT_TRUE(!hit || level_of(code_of_primitive(hit.primitive)) == 0);
  }
}

// Rays from outside to the inside of a shell.
TEST(SvoLeaves, NoRaySlipsThroughAClosedSurface) {
  size_t traced = 0;
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    test::SkinnedShape shape;
    shape.shape = test::sphere(5);
    shape.follow_along(random.direction(), 4);
    VoxelizeOptions options;
    options.shell = seed % 2 == 0 ? Shell::thin : Shell::conservative;
    RayBody body(*make_svo(*shape.voxelized(40 + 17 * seed, options), shape.source()));
    // Of one placement or another, or bent a little: the middle stays inside.
    for (Affine& joint : body.joints) {
      joint = trs(random.uniform3(-0.1f, 0.1f),
                  glm::angleAxis(random.uniform(-0.3f, 0.3f), random.direction()),
                  random.uniform3(0.8f, 1.3f));
    }
    body.pose();
    std::vector<Ray> rays(40000);
    for (size_t i = 0; i < rays.size(); i += 80) {
      const vec3 eye = 3.0f * random.direction(), at = random.uniform3(-0.3f, 0.3f);
      for (size_t k = i; k < i + 80; ++k) {
        rays[k] = {eye, 0.0f, at + random.uniform3(-0.05f, 0.05f) - eye, 1.0f};
      }
    }
    for (const float width : {0.0f, 1.5f, 6.0f}) {
      const RayFootprint footprint{width * body.svo.grid.voxel, 0.0f};
      for (const Hit& hit : hits_of(body.scene(), rays, {.footprint = footprint})) {
        ASSERT_TRUE(static_cast<bool>(hit));
      }
    }
    traced += rays.size();
  }
  EXPECT_GT(traced, 0u);
}

TEST(SvoLeaves, PlainOctreesAreMadeOnce) {
  const VoxelGrid grid{vec3(-0.5f), 1.0f / 90.0f, uvec3(90)};
  RayBody body(*make_svo(grid, test::random_voxels(90, 4000, 2, 8)));
  body.leaves.make_all(0);
  const SvoLeaves::Counts made = body.leaves.made();
  EXPECT_EQ(made.blocks, body.svo.block_count());
  EXPECT_EQ(made.cells[0], body.svo.cells.size());
  EXPECT_EQ(made.cells[1], 0u);
  EXPECT_GT(body.leaves.bytes_made(), 32 * body.svo.voxel_count());
  body.pose();
  EXPECT_EQ(body.leaves.made().cells[0], made.cells[0]);
}

TEST(SvoLeaves, CopiesOfCellsMakeMoreThanEightChildren) {
  const auto body = random_body(2, 1);
  const uint32_t most = std::ranges::max(body->svo.nodes, {}, &SvoNode::count).count;
  EXPECT_GT(most, 2 * kWidth);
}

// Boxes have no edges between them that a ray could slip through: they overlap.
TEST(SvoLeaves, FastRaysMeetTheSameVoxels) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto body = random_body(seed % 3, seed);
    Random random(seed);
    const std::vector<Ray> rays = random_rays(body->box(), 4000, random);
    const std::vector<Hit> careful = hits_of(body->scene(), rays);
    for (const Grouping grouping : {Grouping::none, Grouping::automatic}) {
      const std::vector<Hit> fast =
          hits_of(body->scene(), rays, {.grouping = grouping, .precision = Precision::fast});
      size_t other = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        const bool same =
            fast[i].primitive == careful[i].primitive && fast[i].object == careful[i].object;
        if (!same) ++other;
      }
      EXPECT_LE(other, rays.size() / 2000);
    }
  }
}

TEST(SvoLeaves, MoreCellsThanRaysTellApartAreRefused) {
  Svo svo;
  svo.name = "whale";
  svo.cells.resize(kMostRayCells + 1);
  const Result<SvoLeafLayout> layout = make_leaf_layout(svo);
  ASSERT_FALSE(layout);
  EXPECT_EQ(layout.error().element, "whale");
  EXPECT_NE(layout.error().problem.find("4194305 cells"), std::string::npos);
}

TEST(SvoLeaves, EmptyAndSmallest) {
  const VoxelGrid grid{vec3(-0.5f), 0.125f, uvec3(8)};
  RayBody none{Svo()};
  const Ray ray{vec3(0.01f, 0.02f, 5.0f)};
  EXPECT_FALSE(hits_of(none.scene(), {&ray, 1})[0]);
  const std::vector<Ray> many(100, ray);
  EXPECT_FALSE(hits_of(none.scene(), many)[0]);
  EXPECT_TRUE(none.leaves.bounds().empty());
  RayBody one(*make_svo(grid, std::vector<PlainVoxel>{{morton_of(uvec3(4, 4, 5)), 0, 0, 0}}));
  const Hit hit = hits_of(one.scene(), {&ray, 1})[0];
  ASSERT_TRUE(static_cast<bool>(hit));
  EXPECT_EQ(hit.object, 3u);
  EXPECT_EQ(cell_of_primitive(hit.primitive), 0u);
  EXPECT_EQ(place_of(code_of_primitive(hit.primitive)).min, uvec3(4, 4, 5));
  EXPECT_NEAR(hit.t, 5.0f - (-0.5f + 0.125f * 6.05f), 1e-5f);
}

TEST(SvoLeaves, PosesAfterTheFirstAllocateNothing) {
  const auto body = random_body(1, 4);
  Random random(4);
  const std::vector<Ray> rays = random_rays(body->box(), 500, random);
  std::vector<Hit> hits(rays.size());
  Pose pose;
  pose.joints = body->joints;
  test::start_counting();
  for (int i = 0; i < 3; ++i) {
    body->posed.set_pose(body->motion, pose);
    body->leaves.set_pose(body->layout, body->posed);
    closest_hits(body->scene(), rays, hits);
  }
  EXPECT_EQ(test::stop_counting(), 0);
}

}  // namespace
}  // namespace sinew
