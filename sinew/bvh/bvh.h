// Bvh: one body, prepared once and updated with new vertices; the front door for a single mesh.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/build.h"
#include "sinew/bvh/traverse.h"
#include "sinew/bvh/wide.h"
#include "sinew/math/ray.h"

namespace sinew {

class Bvh {
 public:
  // New positions of all vertices, in the order given to build(). Copies what it needs. An error if
  // the count differs.
  Result<void> update(std::span<const vec3> positions);

  std::optional<Hit> closest_hit(const Ray& ray) const;
  bool any_hit(const Ray& ray) const;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const;
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const;

  const Box& box() const { return bvh_.box; }
  uint32_t triangle_count() const { return layout_.triangle_count; }

 private:
  friend Result<Bvh> build(std::span<const vec3>, std::span<const uvec3>, const BuildConfig&);
  Bvh() = default;
  Instance instance() const;
  Bvh8Layout layout_;
  Bvh8 bvh_;
};

// Builds over `triangles`, which index `positions`. Errors: an index out of range, more than 2^28
// triangles, a position that is not finite.
Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const BuildConfig& config = {});

}  // namespace sinew
