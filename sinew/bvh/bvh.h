// Bvh: one body, prepared once and updated with new vertices; the front door for a single mesh.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/trace/proximity.h"
#include "sinew/bvh/trace/traverse.h"
#include "sinew/bvh/update/choose.h"
#include "sinew/bvh/update/update_local.h"
#include "sinew/bvh/wide.h"
#include "sinew/math/ray.h"

namespace sinew {

class Bvh {
 public:
  Bvh(Bvh&&) noexcept;
  Bvh& operator=(Bvh&&) noexcept;
  ~Bvh();

  // New positions of all vertices, in the order given to build(); copied as far as later rays need
  // them. Triangles with a vertex that is not finite are not there until it is. An error, and
  // nothing changed, if the count differs. Updates must not overlap queries.
  Result<void> update(std::span<const vec3> positions);

  // The same where only some vertices differ from the last update: costs what has changed. An error
  // if the range goes beyond the vertices.
  Result<void> update(std::span<const vec3> positions, VertexRange changed);

  // The same without a copy: `positions` must stay as they are until the next update.
  Result<void> update_borrowed(std::span<const vec3> positions);

  // update() without touching what queries see: rays may be traced at the same time. flip() then
  // shows it, and must not overlap queries; without a stage() before it does nothing. Takes twice
  // the memory.
  Result<void> stage(std::span<const vec3> positions);
  void flip();

  // `automatic` unless said otherwise. All modes give the same hits; `lazy` is `hybrid` here, since
  // nothing but the vertices says where they are.
  void set_update_mode(UpdateMode mode);
  UpdateChoice choice() const;

  std::optional<Hit> closest_hit(const Ray& ray) const;
  bool any_hit(const Ray& ray) const;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    const QueryOptions& options = {}) const;
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit,
                const QueryOptions& options = {}) const;

  void all_hits(const Ray& ray, std::vector<Hit>& out, const QueryOptions& options = {}) const;
  std::optional<NearestPoint> nearest_point(
      vec3 from, float max_distance = std::numeric_limits<float>::infinity()) const;
  void triangles_in_box(const Box& box, std::vector<TriangleId>& out) const;

  // How much more a ray costs than in the tree as it was built: the expected cost (surface area
  // heuristic, over the tree down to its treelets) over that of the build. Above about 2 a new
  // build pays soon.
  double cost_ratio() const;

  const Box& box() const;
  uint32_t triangle_count() const;
  uint32_t treelet_count() const;
  uint32_t treelets_made() const;  // since the last update, by it or by rays
  size_t bytes() const;  // of nodes, packed triangles and treelets; not of borrowed vertices

 private:
  friend Result<Bvh> build(std::span<const vec3>, std::span<const uvec3>, const BuildConfig&);
  friend Result<Bvh> build(std::span<const vec3>, std::span<const uvec3>, const Tree&,
                           std::span<const float>);
  struct Impl;
  Bvh();
  std::unique_ptr<Impl> impl_;
};

// Builds over `triangles`, which index `positions`. Errors: an index out of range, more than 2^28
// triangles, a position that is not finite.
Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const BuildConfig& config = {});

// The same with a tree that the caller has, over the triangles in their order, such as one that was
// optimised for an animation. `areas` orders the children of eight-wide nodes (make_layout()); if
// empty, those of `positions`. Errors also: a tree that does not fit, a leaf of more than 32.
Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const Tree& tree, std::span<const float> areas = {});

}  // namespace sinew
