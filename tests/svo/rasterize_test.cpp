// The rasteriser against its slow obvious twin, and against itself: threads, history, settings.
#include "sinew/svo/draw/rasterize.h"

#define HWY_WANT_AVX3_DL  // as the kernel of tiles does
#include <gtest/gtest.h>
#include "sinew/base/simd.h"

#include <memory>

#include <hwy/targets.h>

#include "allocations.h"
#include "sinew/base/parallel.h"
#include "svo/raster_oracle.h"

namespace sinew {
namespace {

using test::HalfSize;
using test::look_at;
using test::RasterBody;
using test::ReadVoxel;
using test::ScreenVoxel;

constexpr uint32_t kSide = 90;

VoxelGrid unit_grid(uint32_t resolution = kSide) {
  return {vec3(-0.5f), 1.0f / static_cast<float>(resolution), uvec3(resolution)};
}

std::vector<PlainVoxel> ball(uint32_t seed, size_t count = 6000, uint32_t materials = 2) {
  return test::random_voxels(kSide, count, materials, seed);
}

std::vector<VisibilityKey> draw(std::span<const VoxelInstance> bodies, const RasterView& view,
                                const RasterSettings& settings = {}) {
  const RasterScratchPtr scratch = make_raster_scratch();
  Visibility out;
  rasterize(bodies, view, settings, *scratch, out);
  return out.keys;
}

std::vector<float> draw_depth(std::span<const VoxelInstance> bodies, const RasterView& view,
                              const RasterSettings& settings = {}) {
  const RasterScratchPtr scratch = make_raster_scratch();
  DepthMap out;
  rasterize_depth(bodies, view, settings, *scratch, out);
  return out.depth;
}

// Per pixel the least depth that must be there, and the least that may be.
struct Twin {
  std::vector<double> must, may;

  Twin(const RasterView& view, const VoxelInstance& body, const std::vector<ReadVoxel>& voxels)
      : must(view.width * view.height, std::numeric_limits<double>::infinity()), may(must) {
    // What rounding in float may do, in pixels: for pictures of a few hundred pixels.
    constexpr double kEdge = 0.01;
    const double wide = 1.0 + 2.0 * RasterSettings().margin;
    for (const ReadVoxel& voxel : voxels) {
      const ScreenVoxel v = test::voxel_on_screen(view, body, voxel);
      const HalfSize half = test::half_of_cell(view, body, voxel.cell, voxel.block);
      const double x = v.middle.x, y = v.middle.y;
      EXPECT_LE(x - half.x, v.x0 + 1e-9);
      EXPECT_GE(x + half.x, v.x1 - 1e-9);
      EXPECT_LE(y - half.y, v.y0 + 1e-9);
      EXPECT_GE(y + half.y, v.y1 - 1e-9);
      const double rx = wide * half.x, ry = wide * half.y;
      cover(view, x - rx, y - ry, x + rx, y + ry, v.middle.depth, must);
      cover(view, x - rx - kEdge, y - ry - kEdge, x + rx + kEdge, y + ry + kEdge, v.middle.depth,
            may);
    }
  }

  static void cover(const RasterView& view, double x0, double y0, double x1, double y1,
                    double depth, std::vector<double>& out) {
    const auto first = [](double low) {
      return static_cast<int>(std::ceil(std::max(low, -9.0) - 0.5));
    };
    const auto last = [](double high, uint32_t size) {
      return std::min(static_cast<int>(std::floor(std::min(high, 1e6) - 0.5)),
                      static_cast<int>(size) - 1);
    };
    for (int y = std::max(first(y0), 0); y <= last(y1, view.height); ++y) {
      for (int x = std::max(first(x0), 0); x <= last(x1, view.width); ++x) {
        double& at = out[y * view.width + x];
        at = std::min(at, depth);
      }
    }
  }
};

void expect_twin(const RasterView& view, RasterBody& body, const VoxelInstance& instance,
                 const RasterSettings& settings) {
  const auto keys = draw(std::span(&instance, 1), view, settings);
  const auto depth = draw_depth(std::span(&instance, 1), view, settings);
  for (uint32_t b = 0; b < body.svo.block_count(); ++b) body.posed.make_block(b);
  const Twin twin(view, instance, test::read_voxels(body.svo));
  int wrong = 0, covered = 0;
  for (size_t i = 0; i < keys.size(); ++i) {
    const bool none = keys[i] == kNothing;
    covered += none ? 0 : 1;
    const double infinity = std::numeric_limits<double>::infinity();
    const double drawn = none ? infinity : double{key_depth(keys[i])};
    // A key's depth has 19 bits.
    wrong += drawn > twin.must[i] * (1.0 + 1e-6) || drawn < twin.may[i] * (1.0 - 4e-6) ? 1 : 0;
    wrong += depth[i] > twin.must[i] * (1.0 + 1e-6) || depth[i] < twin.may[i] * (1.0 - 1e-6);
    if (none) continue;
    const VoxelSample sample = sample_voxel(std::span(&instance, 1), keys[i]);
    wrong += std::abs(dot(vec3(view.depth), sample.position) + view.depth.w - drawn) > 1e-5 * drawn;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(covered, 20);
}

// Calls on each instruction set that the machine has.
template <class F>
void on_each_target(const F& call) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::GetChosenTarget().Update(target);
    call();
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(Rasterize, EqualsTheTwinWhereBoxesAreInFront) {
  RasterSettings settings;
  settings.lod = false;
  settings.large = 1e9f;
  for (const float fold : {0.0f, 0.1f, 0.6f, 2.0f}) {
    for (uint32_t seed = 1; seed <= 4; ++seed) {
      RasterBody body(unit_grid(), ball(seed), fold, seed);
      Random random(seed);
      const vec3 direction = random.direction();
      const float spin = random.uniform(0.0f, 6.0f), scale = std::exp(random.uniform(3.0f, 7.0f));
      const VoxelInstance instance{
          &body.posed, trs(vec3(0.1f), glm::angleAxis(spin, direction), vec3(1.0f, 0.7f, 1.2f)), 0};
      for (const bool perspective : {true, false}) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << " fold " << fold << " scale " << scale
                                        << " perspective " << perspective);
        const float distance = perspective ? 3.0f : 1.0f;
        const RasterView view = look_at(3.0f * direction + vec3(0.1f), vec3(0.1f),
                                        distance * 0.3f * scale, 150, 133, 0.01f, perspective);
        on_each_target([&] { expect_twin(view, body, instance, settings); });
      }
    }
  }
}

// Whatever is drawn instead of a voxel covers at least what it covers.
TEST(Rasterize, CoversEveryVoxelAtEveryLevel) {
  for (const float fold : {0.0f, 0.3f}) {
    RasterBody body(unit_grid(), ball(3), fold, 3);
    const VoxelInstance instance{&body.posed, identity_affine(), 0};
    for (const float scale :
         {6000.0f, 900.0f, 400.0f, 150.0f, 60.0f, 25.0f, 9.0f, 2.0f, 0.5f, 0.1f}) {
      for (const bool perspective : {true, false}) {
        SCOPED_TRACE(testing::Message() << scale << " pixels, perspective " << perspective);
        const RasterView view =
            look_at(vec3(1.0f, 2.0f, 3.0f), vec3(0.0f), (perspective ? 3.7f : 1.0f) * scale, 65, 67,
                    0.1f, perspective);
        const auto keys = draw(std::span(&instance, 1), view);
        const auto depth = draw_depth(std::span(&instance, 1), view);
        for (uint32_t b = 0; b < body.svo.block_count(); ++b) body.posed.make_block(b);
        int holes = 0, inside = 0;
        for (const ReadVoxel& voxel : test::read_voxels(body.svo)) {
          test::for_each_pixel(view, test::points_of(view, instance, voxel, 1), 1, [&](size_t i) {
            ++inside;
            holes += keys[i] == kNothing || !std::isfinite(depth[i]) ? 1 : 0;
          });
        }
        EXPECT_GE(inside, scale > 2.0f ? 1 : 0);
        EXPECT_EQ(holes, 0);
      }
    }
  }
}

// From inside the body, voxels before and behind the eye and across the near plane: a point of a
// voxel beyond the near plane is covered, by what is no farther than the voxel's farthest corner.
TEST(Rasterize, NothingIsLostAtTheNearPlane) {
  int drawn = 0;
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    RasterBody body(unit_grid(24), test::random_voxels(24, 900, 1, seed), 0.2f, seed);
    const VoxelInstance instance{&body.posed, identity_affine(), 0};
    const vec3 eye = random.uniform3(-0.45f, 0.45f);
    const bool perspective = seed % 4 != 0;
    const RasterView view =
        look_at(eye, eye + random.direction(), 100.0f, 120, 90, 0.05f, perspective);
    RasterSettings settings;
    settings.lod = seed % 2 == 0;
    const auto keys = draw(std::span(&instance, 1), view, settings);
    const auto depth = draw_depth(std::span(&instance, 1), view, settings);
    for (uint32_t b = 0; b < body.svo.block_count(); ++b) body.posed.make_block(b);
    int holes = 0, inside = 0;
    for (const ReadVoxel& voxel : test::read_voxels(body.svo)) {
      const auto points = test::points_of(view, instance, voxel, 4);
      double farthest = 0.0;
      for (const test::ScreenPoint& p : points) farthest = std::max(farthest, p.depth);
      test::for_each_pixel(view, points, 3, [&](size_t i) {
        ++inside;
        holes += keys[i] == kNothing || key_depth(keys[i]) > farthest * 1.001 ? 1 : 0;
        holes += depth[i] > farthest * 1.001 ? 1 : 0;
      });
    }
    EXPECT_EQ(holes, 0);
    drawn += inside;
  }
  EXPECT_GT(drawn, 1000);
}

// Pixels are won where voxels are, all of these and no others: also by voxels next to the eye.
TEST(Rasterize, NothingIsAddedAtTheEye) {
  int drawn = 0, crossing = 0;
  for (uint32_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const size_t count = seed % 3 == 0 ? 3000 : 300;
    RasterBody body(unit_grid(40), test::random_voxels(40, count, 1, seed), 0.2f, seed);
    const VoxelInstance instance{&body.posed, identity_affine(), 0};
    const vec3 eye = random.uniform3(-0.5f, 0.5f);
    const RasterView view = look_at(eye, eye + random.direction(), 100.0f, 150, 100, 1e-3f);
    RasterSettings settings;
    settings.lod = false;
    settings.large = 0.0f;
    const auto keys = draw(std::span(&instance, 1), view, settings);
    const auto depth = draw_depth(std::span(&instance, 1), view, settings);
    for (uint32_t b = 0; b < body.svo.block_count(); ++b) body.posed.make_block(b);
    int added = 0, lost = 0;
    for (uint32_t i = 0; i < keys.size(); ++i) {
      EXPECT_EQ(keys[i] == kNothing, std::isinf(depth[i]));
      if (keys[i] == kNothing) continue;
      ++drawn;
      const auto hull = test::hull_of(view, instance, key_unit(keys[i]), key_code(keys[i]));
      added += test::near_hull(hull, i % view.width + 0.5, i / view.width + 0.5, 1.5) ? 0 : 1;
    }
    for (const ReadVoxel& voxel : test::read_voxels(body.svo)) {
      const auto hull = test::hull_of(view, instance, voxel.cell, voxel.code);
      crossing += hull.size() > 8 ? 1 : 0;
      double farthest = 0.0;
      for (const test::ScreenPoint& p : hull) farthest = std::max(farthest, p.depth);
      test::for_each_pixel(view, hull, 3, [&](size_t i) {
        lost += keys[i] == kNothing || key_depth(keys[i]) > farthest * 1.001 ? 1 : 0;
      });
    }
    EXPECT_EQ(added, 0);
    EXPECT_EQ(lost, 0);
  }
  EXPECT_GT(drawn, 10000);
  EXPECT_GT(crossing, 20);
}

// One voxel that is a box: depths of the first face that the ray meets, by slabs in double.
TEST(Rasterize, FacesOfLargeVoxels) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const VoxelGrid grid{vec3(-0.5f), 1.0f, uvec3(1)};
    RasterBody body(grid, {{0, 0, 0, 0}});
    const vec3 axis = random.direction();
    const vec3 size = random.uniform3(0.3f, 1.0f);
    const VoxelInstance instance{
        &body.posed, trs(vec3(0.0f), glm::angleAxis(random.uniform(0.0f, 3.0f), axis), size), 0};
    const bool perspective = seed % 2 == 0;
    const RasterView view = look_at(2.0f * random.direction(), vec3(0.0f),
                                    perspective ? 150.0f : 80.0f, 140, 120, 0.1f, perspective);
    const auto depth = draw_depth(std::span(&instance, 1), view);
    const Affine back = inverse_affine(instance.placement);
    // Pixel and depth to the world.
    const glm::dmat4 rows =
        glm::transpose(glm::dmat4(view.x, view.y, view.depth, vec4(0, 0, 0, 1)));
    const glm::dmat4 to_world = glm::inverse(rows);
    int wrong = 0, inside = 0;
    for (uint32_t i = 0; i < depth.size(); ++i) {
      const double x = i % view.width + 0.5, y = i / view.width + 0.5;
      const auto at = [&](double d) {
        const glm::dvec4 p =
            to_world * (perspective ? glm::dvec4(x * d, y * d, d, 1.0) : glm::dvec4(x, y, d, 1.0));
        return test::dvec3(glm::dmat4x3(back) * p);
      };
      const test::dvec3 origin = at(0.1), direction = at(1.1) - origin;
      double enter = 0.0, leave = 1e9;
      for (int k = 0; k < 3; ++k) {
        const double a = (-0.5 - origin[k]) / direction[k], b = (0.5 - origin[k]) / direction[k];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (leave < enter) {
        // Rays that pass at a hair's breadth may count as hits.
        wrong += std::isfinite(depth[i]) && leave < enter - 1e-2 ? 1 : 0;
      } else {
        ++inside;
        wrong += std::abs(depth[i] - 0.1 - enter) > 1e-4 ? 1 : 0;
      }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(inside, 300);
  }
}

// What a key names, read by hand.
TEST(SampleVoxel, NamesWhatIsThere) {
  RasterBody body(unit_grid(), ball(4), 0.2f, 4);
  const Affine placement =
      trs(vec3(1, 2, 3), glm::angleAxis(0.7f, vec3(0, 0.6f, 0.8f)), vec3(2.0f));
  const VoxelInstance instances[2] = {{&body.posed, identity_affine(), 0},
                                      {&body.posed, placement, unit_count(body.svo)}};
  for (uint32_t b = 0; b < body.svo.block_count(); ++b) body.posed.make_block(b);
  for (const ReadVoxel& voxel : test::read_voxels(body.svo)) {
    const VisibilityKey key = make_key(1.0f, instances[1].first_unit + voxel.cell, voxel.code);
    const VoxelSample sample = sample_voxel(instances, key);
    EXPECT_EQ(sample.instance, 1u);
    EXPECT_EQ(sample.unit, voxel.cell);
    EXPECT_EQ(sample.code, voxel.code);
    EXPECT_EQ(sample.level, 0u);
    EXPECT_EQ(sample.material, voxel.material);
    EXPECT_EQ(sample.spread, 1.0f);
    EXPECT_NEAR(sample.size, 2.0f * body.svo.grid.voxel, 1e-6f);
    const test::dvec3 at =
        test::lattice_point(body.svo.cells[voxel.cell], body.posed.block(voxel.block),
                            test::dvec3(place_of(voxel.code).min) + 0.5);
    EXPECT_LT(distance(sample.position, transform_point(placement, vec3(at))), 1e-5f);
    const vec3 normal = normalize(linear_part(placement) * unpack_normal(voxel.normal));
    EXPECT_LT(distance(sample.normal, normal), 1e-5f);
  }
  for (uint32_t n = 0; n < body.svo.nodes.size(); ++n) {
    const uint32_t unit = static_cast<uint32_t>(body.svo.cells.size()) + n;
    const VoxelSample sample = sample_voxel(instances, make_key(1.0f, unit, 0));
    EXPECT_EQ(sample.instance, 0u);
    EXPECT_EQ(sample.level, body.svo.nodes[n].level);
    EXPECT_LT(length(sample.position), 1.0f);
  }
}

struct Crowd {
  std::vector<std::unique_ptr<RasterBody>> bodies;
  std::vector<VoxelInstance> instances;

  // The bodies in turn.
  explicit Crowd(uint32_t count) {
    for (uint32_t i = 0; i < 3; ++i) {
      bodies.push_back(
          std::make_unique<RasterBody>(unit_grid(), ball(i + 1), 0.15f * static_cast<float>(i), i));
    }
    Random random(5);
    uint32_t unit = 0;
    for (uint32_t i = 0; i < count; ++i) {
      PosedSvo& posed = bodies[i % 3]->posed;
      const vec3 axis = random.direction(), at = random.uniform3(-1.0f, 1.0f);
      instances.push_back({&posed, trs(at, glm::angleAxis(1.0f, axis), vec3(0.6f)), unit});
      unit += unit_count(posed.svo());
    }
  }
};

TEST(Rasterize, SamePictureForAnyThreadsHistoryAndSettings) {
  Crowd crowd(12);
  const RasterView view = look_at(vec3(0.5f, 1.0f, 3.0f), vec3(0.0f), 700.0f, 403, 277, 0.1f);
  const RasterView other = look_at(vec3(-2.5f, 1.0f, 1.0f), vec3(0.3f), 900.0f, 403, 277, 0.1f);
  for (const bool lod : {true, false}) {
    RasterSettings plain;
    plain.lod = lod;
    plain.occlusion = false;
    const auto expected = draw(crowd.instances, view, plain);
    const auto expected_depth = draw_depth(crowd.instances, view, plain);
    for (int threads = 1; threads <= 4; ++threads) {
      ThreadLimit limit(threads);
      for (const bool front_to_back : {false, true}) {
        RasterSettings settings = plain;
        settings.occlusion = true;
        settings.front_to_back = front_to_back;
        const RasterScratchPtr scratch = make_raster_scratch(), shadow = make_raster_scratch();
        Visibility out;
        DepthMap depth;
        RasterStats first, last;
        for (const RasterView* v : {&other, &view, &view, &other, &view}) {
          const RasterStats stats = rasterize(crowd.instances, *v, settings, *scratch, out);
          rasterize_depth(crowd.instances, *v, settings, *shadow, depth);
          if (v != &view) continue;
          EXPECT_EQ(out.keys, expected);
          EXPECT_EQ(depth.depth, expected_depth);
          if (first.cells == 0) first = stats;
          last = stats;
        }
        EXPECT_GT(last.cells_hidden, 0u);
        EXPECT_LT(last.voxels_drawn,
                  rasterize(crowd.instances, view, plain, *scratch, out).voxels_drawn);
      }
    }
  }
}

TEST(Rasterize, PicturesOfAnySize) {
  Crowd crowd(2);
  for (const auto& [width, height] :
       {std::pair{1u, 1u}, {1u, 200u}, {200u, 1u}, {64u, 64u}, {65u, 63u}, {129u, 3u}}) {
    const RasterView view = look_at(vec3(0, 0, 3), vec3(0.0f), 100.0f, width, height, 0.1f);
    const auto keys = draw(crowd.instances, view);
    ASSERT_EQ(keys.size(), width * height);
    // The same as a part of a larger picture, its middle where this one's is.
    RasterView large = view;
    large.width = large.height = 300;
    const auto whole = draw(crowd.instances, large);
    for (uint32_t y = 0; y < height; ++y) {
      for (uint32_t x = 0; x < width; ++x) {
        EXPECT_EQ(keys[y * width + x], whole[y * 300 + x]) << x << ", " << y;
      }
    }
  }
}

TEST(Rasterize, NothingToDraw) {
  const RasterView view = look_at(vec3(0, 0, 3), vec3(0.0f), 100.0f, 33, 22, 0.1f);
  for (const VisibilityKey key : draw({}, view)) EXPECT_EQ(key, kNothing);
  Svo nothing;
  nothing.grid = unit_grid();
  const VoxelInstance absent;
  RasterBody behind(unit_grid(), ball(1));
  const VoxelInstance away{&behind.posed, trs(vec3(0, 0, 9), quat(1, 0, 0, 0), vec3(1.0f)), 0};
  for (const VoxelInstance& instance : {absent, away}) {
    for (const VisibilityKey key : draw(std::span(&instance, 1), view)) EXPECT_EQ(key, kNothing);
    for (const float depth : draw_depth(std::span(&instance, 1), view)) {
      EXPECT_EQ(depth, std::numeric_limits<float>::infinity());
    }
  }
}

// Numbers out of hand end in some picture, of units that exist.
TEST(Rasterize, AnyNumbers) {
  RasterBody body(unit_grid(), ball(5), 0.5f, 5);
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float scale : {1e-30f, 1e-9f, 1e9f, 1e18f, 1e30f, infinity, NAN}) {
    for (const float distance : {0.0f, 1e-9f, 1.0f, 1e9f, 1e30f}) {
      for (const bool perspective : {true, false}) {
        const RasterView view = look_at(vec3(0.0f, 0.0f, distance), vec3(0.1f, 0.0f, -1.0f), 100.0f,
                                        70, 70, 1e-12f, perspective);
        const VoxelInstance instance{
            &body.posed, trs(vec3(0.0f), quat(1, 0, 0, 0), vec3(scale, 1.0f, scale)), 0};
        draw_depth(std::span(&instance, 1), view);
        for (const VisibilityKey key : draw(std::span(&instance, 1), view)) {
          if (key == kNothing) continue;
          EXPECT_LT(key_unit(key), unit_count(body.svo));
          EXPECT_LT(key_code(key), kCodes);
        }
      }
    }
  }
}

TEST(Rasterize, ThousandsOfBodies) {
  Crowd crowd(3000);
  for (const float scale : {3000.0f, 600.0f, 150.0f}) {
    const RasterView view = look_at(vec3(0, 0, 30), vec3(0.0f), scale, 200, 200, 0.1f);
    RasterSettings settings;
    const RasterScratchPtr scratch = make_raster_scratch();
    Visibility out, again;
    const RasterStats stats = rasterize(crowd.instances, view, settings, *scratch, out);
    rasterize(crowd.instances, view, settings, *scratch, again);
    EXPECT_EQ(out.keys, again.keys);
    EXPECT_GT(stats.voxels_drawn + stats.nodes_drawn, 500u);
    for (const VisibilityKey key : out.keys) {
      if (key == kNothing) continue;
      const VoxelSample sample = sample_voxel(crowd.instances, key);
      EXPECT_NEAR(length(sample.normal), 1.0f, 1e-4f);
      EXPECT_LT(sample.instance, 3000u);
    }
  }
}

#ifndef SINEW_SANITIZED
TEST(Rasterize, FramesLikeTheOnesBeforeNeedNoMemory) {
  Crowd crowd(20);
  const RasterScratchPtr scratch = make_raster_scratch(), shadow = make_raster_scratch();
  Visibility out;
  DepthMap depth;
  int counts[3];
  for (int& count : counts) {
    test::start_counting();
    for (const float turn : {0.0f, 0.5f, 1.0f}) {
      const vec3 eye(4.0f * std::sin(turn), 1.0f, 4.0f * std::cos(turn));
      const RasterView view = look_at(eye, vec3(0.0f), 500.0f, 300, 200, 0.1f);
      for (auto& body : crowd.bodies) body->pose();
      rasterize(crowd.instances, view, {}, *scratch, out);
      rasterize_depth(crowd.instances, view, {}, *shadow, depth);
    }
    count = test::stop_counting();
  }
  EXPECT_GT(counts[0], 0);
  EXPECT_EQ(counts[2], 0);
}
#endif

}  // namespace
}  // namespace sinew
