// Worlds with voxel objects, and the slow obvious answer: every voxel's box in double.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "oracle.h"
#include "shapes.h"
#include "sinew/world/world.h"
#include "svo/skinned_shape.h"
#include "svo/test_octrees.h"

namespace sinew::test {

using glm::dvec3;

struct DoubleBox {
  dvec3 min{std::numeric_limits<double>::infinity()}, max{-min};
  void extend(dvec3 p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
};

// Where the ray is in the box; first > second: nowhere.
inline std::pair<double, double> crossing(const dvec3& origin, const dvec3& direction,
                                          const DoubleBox& box) {
  double first = -std::numeric_limits<double>::infinity(), last = -first;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis]) return {1.0, 0.0};
      continue;
    }
    const double a = (box.min[axis] - origin[axis]) / direction[axis];
    const double b = (box.max[axis] - origin[axis]) / direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return {first, last};
}

// All voxels of level 0 of an octree in a pose.
struct BruteOctree {
  const Svo& svo;
  std::vector<ReadVoxel> voxels;
  std::vector<DoubleBox> boxes;      // of mapped corners, without any margin
  std::map<uint32_t, size_t> index;  // by Hit::primitive

  BruteOctree(const Svo& octree, const Pose& pose) : svo(octree), voxels(read_voxels(octree)) {
    const SvoMotion motion = make_svo_motion(svo);
    PosedSvo posed;
    posed.set_pose(motion, pose);
    for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
    boxes.resize(voxels.size());
    for (size_t i = 0; i < voxels.size(); ++i) {
      const ReadVoxel& v = voxels[i];
      const PosedBlock block = posed.block(v.block);
      for (uint32_t corner = 0; corner < 8; ++corner) {
        const uvec3 at = place_of(v.code).min + uvec3(corner & 1, corner >> 1 & 1, corner >> 2);
        boxes[i].extend(mapped(svo.cells[v.cell], block, dvec3(at) / 8.0));
      }
      index[v.cell << 10 | v.code] = i;
    }
  }

  static dvec3 mapped(const SvoCell& cell, const PosedBlock& block, dvec3 local) {
    dvec3 sum(0.0);
    for (uint32_t k = 0; k < 8; ++k) {
      const dvec3 share((k & 1) != 0 ? local.x : 1 - local.x, (k & 2) != 0 ? local.y : 1 - local.y,
                        (k & 4) != 0 ? local.z : 1 - local.z);
      sum += share.x * share.y * share.z * dvec3(block.positions[cell.corner[k]]);
    }
    return sum;
  }
};

// An object in the world.
struct BruteObject {
  const BruteOctree* octree = nullptr;
  Affine placement = identity_affine();
  ObjectId id = 0;
};

inline std::pair<dvec3, dvec3> in_object(const Ray& ray, const Affine& placement) {
  const glm::dmat3 inverse = glm::inverse(glm::dmat3(linear_part(placement)));
  return {inverse * (dvec3(ray.origin) - dvec3(placement[3])), inverse * dvec3(ray.direction)};
}

// The least t at which the ray surely is in a voxel.
inline double brute_entry(const Ray& ray, const BruteObject& object) {
  const auto [origin, direction] = in_object(ray, object.placement);
  double best = std::numeric_limits<double>::infinity();
  for (const DoubleBox& box : object.octree->boxes) {
    auto [first, last] = crossing(origin, direction, box);
    first = std::max(first, double{ray.t_min});
    if (first <= last && last >= 0.0 && first <= double{ray.t_max}) best = std::min(best, first);
  }
  return best;
}

// Whether the hit is where the named voxel's box, which reaches a little beyond its corners, is
// entered.
inline bool is_entry(const Ray& ray, const BruteObject& object, const Hit& hit) {
  const auto named = object.octree->index.find(hit.primitive);
  if (named == object.octree->index.end()) return false;
  DoubleBox box = object.octree->boxes[named->second];
  const dvec3 extent = box.max - box.min;
  const double margin = 0.25 * std::max({extent.x, extent.y, extent.z}) + 1e-6;
  box.min -= margin;
  box.max += margin;
  const auto [origin, direction] = in_object(ray, object.placement);
  const auto [first, last] = crossing(origin, direction, box);
  const double slack = 1e-5 * (1.0 + std::abs(hit.t));
  const auto inner = crossing(origin, direction, object.octree->boxes[named->second]);
  const double latest = inner.first <= inner.second ? std::max(inner.first, double{ray.t_min})
                                                    : std::max(last, double{ray.t_min});
  return first <= last && hit.t >= std::max(first, double{ray.t_min}) - slack &&
         hit.t <= latest + slack;
}

inline Pose placed(const Affine& placement) {
  Pose pose;
  pose.placement = placement;
  return pose;
}

inline Affine random_place(Random& random, float reach) {
  const vec3 at = random.uniform3(-reach, reach);
  const float angle = random.uniform(0.0f, 6.0f);
  const vec3 axis = random.direction();
  const vec3 scale = random.uniform3(0.4f, 1.6f);
  return trs(at, glm::angleAxis(angle, axis), scale);
}

// What a pose's spans look at.
struct OwnPose {
  std::vector<Affine> joints;
  std::vector<float> weights;
  Affine placement = identity_affine();

  Pose pose() const {
    Pose out;
    out.joints = joints;
    out.weights = weights;
    out.placement = placement;
    return out;
  }
};

// Of moving_octree(): joints that turn and move a little.
inline OwnPose moving_pose(uint32_t seed) {
  Random random(seed);
  OwnPose out;
  for (int i = 0; i < 5; ++i) {
    const vec3 at = random.uniform3(-0.2f, 0.2f);
    const float angle = random.uniform(-0.5f, 0.5f);
    out.joints.push_back(trs(at, glm::angleAxis(angle, random.direction()), vec3(1.0f)));
  }
  const float weight = random.uniform(-1.0f, 1.0f);
  out.weights = {weight, 0.5f};
  return out;
}

inline bool same_hits(std::span<const Hit> a, std::span<const Hit> b) {
  return std::ranges::equal(a, b, [](const Hit& x, const Hit& y) {
    return std::bit_cast<uint32_t>(x.t) == std::bit_cast<uint32_t>(y.t) && x.object == y.object &&
           x.primitive == y.primitive && x.u == y.u && x.v == y.v;
  });
}

// Rays about the box: most through it, some from inside.
inline std::vector<Ray> rays_about(const Box& box, size_t count, uint32_t seed) {
  Random random(seed);
  const float size = length(box.extent());
  std::vector<Ray> rays(count);
  for (size_t i = 0; i < count; ++i) {
    const vec3 to = box.center() + random.uniform3(-0.4f, 0.4f) * box.extent();
    const vec3 from = box.center() + (i % 5 == 0 ? 0.2f : 1.5f) * size * random.direction();
    rays[i].origin = from;
    rays[i].direction = i % 2 == 0 ? normalize(to - from) : to - from;
  }
  return rays;
}

}  // namespace sinew::test
