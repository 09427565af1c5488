// Evaluation: chooses the motion, then runs its position() (rigid.h, skin.h, ...) over the
// vertices.
#include "sinew/motion/motion.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/motion/free.h"
#include "sinew/motion/keyframes.h"
#include "sinew/motion/morph.h"
#include "sinew/motion/rigid.h"
#include "sinew/motion/skin.h"

namespace sinew {
namespace {

template <class M>
uint32_t count_of(const M& motion) {
  if constexpr (requires { motion.rest; })
    return static_cast<uint32_t>(motion.rest.size());
  else
    return motion.vertex_count;
}

template <class M>
void fill_range(const M& motion, const Pose& pose, uint32_t first, std::span<vec3> out) {
  const uint32_t count = static_cast<uint32_t>(out.size());
  for (uint32_t i = 0; i < count; ++i) out[i] = position(motion, pose, first + i);
}

// Target by target, so that memory is read in order; the sums are those of position().
void fill_range(const MorphMotion& motion, const Pose& pose, uint32_t first, std::span<vec3> out) {
  constexpr size_t kBlock = 512;  // vertices that stay in the first cache over all targets
  for (size_t begin = 0; begin < out.size(); begin += kBlock) {
    const std::span<vec3> block = out.subspan(begin, std::min(kBlock, out.size() - begin));
    const uint32_t vertex = first + static_cast<uint32_t>(begin);
    std::ranges::copy(motion.rest.subspan(vertex, block.size()), block.begin());
    for_each_target(motion, pose, [&](float weight, std::span<const vec3> deltas) {
      for (size_t i = 0; i < block.size(); ++i) block[i] += weight * deltas[vertex + i];
    });
    if (motion.skin.influences == 0) continue;
    for (uint32_t i = 0; i < block.size(); ++i) {
      block[i] = skin_point(motion.skin, pose, vertex + i, block[i]);
    }
  }
}

// The vertices of a list are anywhere in memory: what one needs is fetched while others are moved.
constexpr size_t kAhead = 12;

template <class M>
void prefetch(const M& motion, uint32_t vertex) {
  if constexpr (requires { motion.rest; }) __builtin_prefetch(&motion.rest[vertex]);
}
void prefetch(const SkinMotion& skin, uint32_t vertex) {
  const size_t first = size_t{vertex} * skin.influences;
  __builtin_prefetch(&skin.rest[vertex]);
  __builtin_prefetch(&skin.weights[first]);
  __builtin_prefetch(&skin.joints[first]);
}

template <class M>
void fill_list(const M& motion, const Pose& pose, std::span<const uint32_t> vertices,
               std::span<vec3> out) {
  for (const uint32_t v : vertices.first(std::min(kAhead, out.size()))) prefetch(motion, v);
  for (size_t i = 0; i < out.size(); ++i) {
    if (i + kAhead < out.size()) prefetch(motion, vertices[i + kAhead]);
    out[i] = position(motion, pose, vertices[i]);
  }
}

// Target by target, as over a range: a target's turn costs more than its sum for one vertex.
void fill_list(const MorphMotion& motion, const Pose& pose, std::span<const uint32_t> vertices,
               std::span<vec3> out) {
  for (size_t i = 0; i < out.size(); ++i) out[i] = motion.rest[vertices[i]];
  for_each_target(motion, pose, [&](float weight, std::span<const vec3> deltas) {
    for (size_t i = 0; i < out.size(); ++i) out[i] += weight * deltas[vertices[i]];
  });
  if (motion.skin.influences == 0) return;
  for (size_t i = 0; i < out.size(); ++i) {
    out[i] = skin_point(motion.skin, pose, vertices[i], out[i]);
  }
}

mat3 local_map_of(const SkinMotion& motion, const Pose& pose, uint32_t vertex) {
  return linear_part(blend_joints(motion, pose, vertex));
}
mat3 local_map_of(const MorphMotion& motion, const Pose& pose, uint32_t vertex) {
  return motion.skin.influences == 0 ? mat3(1.0f) : local_map_of(motion.skin, pose, vertex);
}
template <class M>
mat3 local_map_of(const M&, const Pose&, uint32_t) {
  return mat3(1.0f);
}

}  // namespace

uint32_t vertex_count(const Motion& motion) {
  return std::visit([](const auto& m) { return count_of(m); }, motion);
}

void positions(const Motion& motion, const Pose& pose, uint32_t first, std::span<vec3> out) {
  SINEW_DCHECK(pose_fits(motion, pose));
  SINEW_CHECK(first + out.size() <= vertex_count(motion));
  std::visit([&](const auto& m) { fill_range(m, pose, first, out); }, motion);
}

void positions(const Motion& motion, const Pose& pose, std::span<const uint32_t> vertices,
               std::span<vec3> out) {
  SINEW_DCHECK(pose_fits(motion, pose));
  SINEW_CHECK(vertices.size() == out.size());
  std::visit([&](const auto& m) { fill_list(m, pose, vertices, out); }, motion);
}

Box bounds(const Motion& motion, const Pose& pose, std::span<const uint32_t> vertices) {
  SINEW_DCHECK(pose_fits(motion, pose));
  Box box;
  std::visit(
      [&](const auto& m) {
        for (const uint32_t vertex : vertices) box.extend(position(m, pose, vertex));
      },
      motion);
  return box;
}

mat3 local_map(const Motion& motion, const Pose& pose, uint32_t vertex) {
  SINEW_DCHECK(pose_fits(motion, pose));
  return std::visit([&](const auto& m) { return local_map_of(m, pose, vertex); }, motion);
}

}  // namespace sinew
