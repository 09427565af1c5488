#include "sinew/bvh/bvh.h"

#include <cmath>

#include "sinew/bvh/update.h"

namespace sinew {
namespace {

Result<void> check_finite(std::span<const vec3> positions) {
  for (size_t i = 0; i < positions.size(); ++i) {
    const vec3 p = positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      return fail({ErrorKind::bad_input, "", "vertex " + std::to_string(i),
                   "its position is not finite", "remove or repair it"});
    }
  }
  return {};
}

}  // namespace

Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const BuildConfig& config) {
  SINEW_CHECKED(check_finite(positions));
  Bvh bvh;
  SINEW_TRY(bvh.layout_, build_layout(positions, triangles, config));
  update_full(bvh.layout_, positions, bvh.bvh_);
  return bvh;
}

Result<void> Bvh::update(std::span<const vec3> positions) {
  if (positions.size() != layout_.vertex_count) {
    return fail({ErrorKind::usage, "", "",
                 "update got " + std::to_string(positions.size()) + " vertices, the body has " +
                     std::to_string(layout_.vertex_count),
                 "give all vertices in the order of build()"});
  }
  update_full(layout_, positions, bvh_);
  return {};
}

Instance Bvh::instance() const {
  Instance instance;
  instance.nodes = bvh_.nodes.data();
  instance.packets = bvh_.packets.data();
  instance.primitives = layout_.packet_primitives.data();
  instance.root = bvh_.root;
  return instance;
}

std::optional<Hit> Bvh::closest_hit(const Ray& ray) const {
  Hit hit;
  closest_hits({&ray, 1}, {&hit, 1});
  if (!hit) return std::nullopt;
  return hit;
}

bool Bvh::any_hit(const Ray& ray) const {
  uint8_t hit = 0;
  any_hits({&ray, 1}, {&hit, 1});
  return hit != 0;
}

void Bvh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
  const Instance only = instance();
  sinew::closest_hits({nullptr, &only, 1}, rays, hits);
}

void Bvh::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const {
  const Instance only = instance();
  sinew::any_hits({nullptr, &only, 1}, rays, hit);
}

}  // namespace sinew
