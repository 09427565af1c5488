// Ray queries over a two-level hierarchy: a top tree over instances, a Bvh8 in each.
// Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2013;
// T. Ize, "Robust BVH Ray Traversal", JCGT 2013.
// Closest hit is the least (t, object, primitive): the same whatever the tree and the order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/wide.h"
#include "sinew/math/affine.h"
#include "sinew/math/ray.h"

namespace sinew {

struct BoxBody;      // box_body.h
struct VisitedBody;  // visit.h

// One object in the world: views only.
struct Instance {
  const Node8* nodes = nullptr;
  const TrianglePacket* packets = nullptr;       // null: packed from corners when tested
  const PacketCorners* corners = nullptr;        // of every packet
  const vec3* vertices = nullptr;                // that they refer to
  const PacketPrimitives* primitives = nullptr;  // of every packet
  uint32_t root = kNoChild;                      // child word; unused if there is a `body`
  VisitedBody* body = nullptr;           // makes what a ray visits first; null: everything is made
  const BoxBody* boxes = nullptr;        // then it has these and no triangles
  Affine to_object = identity_affine();  // world -> object; rays go through it unless `in_place`
  uint32_t object = 0;                   // Hit::object
  uint32_t mask = 0xffffffffu;           // rays see it if (mask & query mask) != 0
  bool in_place = true;                  // the object's space is the world's
  bool filtered = false;                 // ask the query's filter about its hits
  bool single_sided = false;             // the query's `facing` counts for it
  Affine placement = identity_affine();  // object -> world; rays do not need it
};

// A leaf of a top tree that reaches into instances.
struct TopLeaf {
  uint32_t instance = 0;
  uint32_t word = kNoChild;  // child word of a part of it; kNoChild: all of it
};

// The top tree's leaves are child words kLeafBit | index of a TopLeaf, or of an instance if there
// are no TopLeafs. Without nodes there must be at most one instance, and no TopLeafs.
struct SceneView {
  const Node8* top = nullptr;
  const Instance* instances = nullptr;
  uint32_t instance_count = 0;
  const TopLeaf* leaves = nullptr;
};

// Asked about each candidate hit of instances that are `filtered`; false rejects it (a hole in an
// alpha-masked leaf). Called in no particular order; must be safe to call from several threads.
struct HitFilter {
  bool (*accept)(const void* context, uint32_t ray, const Hit& hit) = nullptr;
  const void* context = nullptr;
  bool of_all = false;  // asked about the hits of all instances
};

// Which side of a single-sided object's triangles counts. Their front is where they are seen
// counter-clockwise. Rays of sight want `front`; rays from a surface to a light want `back`, for
// light that comes in at a front leaves such a ray through the back.
enum class Facing : uint8_t { any, front, back };

// How the rays of a span go through the hierarchy. The hits have the same bits either way.
enum class Grouping : uint8_t {
  automatic,  // rays with like directions together, where a span has them and they begin close
              // to each other
  none,       // each for itself
};

// How carefully rays are tested. Rays in groups are always watertight where the closest hit is
// sought.
enum class Precision : uint8_t {
  watertight,  // no ray slips through between triangles that share an edge
  fast,        // rays that meet an edge, or a box's side, within rounding may miss
};

// How wide the rays of a span are, in the world: what is finer need not be looked at. At its
// origin, and by how much it grows in a unit of length. 0: the finest there is.
struct RayFootprint {
  float width = 0.0f;
  float spread = 0.0f;
};

struct QueryOptions {
  uint32_t mask = 0xffffffffu;
  Facing facing = Facing::any;
  Grouping grouping = Grouping::automatic;
  Precision precision = Precision::watertight;
  HitFilter filter = {};
  uint32_t first_ray = 0;  // what the filter is told for rays[0]
  RayFootprint footprint = {};
  std::span<const uint8_t> hidden{};  // by object: 1: rays pass it; objects beyond it are met

  // Whether the rays may meet anything of the instance.
  bool sees(const Instance& instance) const {
    return (instance.mask & mask) != 0 &&
           (instance.object >= hidden.size() || hidden[instance.object] == 0);
  }
};

// hits[i] = the closest hit of rays[i], or a Hit that is false. Sizes must agree. Rays with a
// direction of zero (below 1e-37), and with numbers that are not finite (but for t_max), hit
// nothing. Spans are fastest if neighbours in them are neighbours in space: tiles of 8x8 pixels.
void closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                  const QueryOptions& options = {});

// Every hit along the ray, sorted by (t, object, primitive).
void all_hits(const SceneView& scene, const Ray& ray, std::vector<Hit>& out,
              const QueryOptions& options = {});

// What one ray cost.
struct TraversalCounts {
  uint32_t nodes = 0;     // whose eight boxes were tested, of the top tree too
  uint32_t packets = 0;   // of four triangles, tested
  uint32_t treelets = 0;  // met before they were made

  uint32_t steps() const { return nodes + packets; }
};
static_assert(sizeof(TraversalCounts) == 12);

// closest_hits, the same hits, that also says what each ray cost. Each ray goes alone and is slower
// by the counting.
void count_closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                        std::span<TraversalCounts> counts, const QueryOptions& options = {});

// hit[i] = 1 if rays[i] meets anything, else 0. Sizes must agree.
void any_hits(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
              const QueryOptions& options = {});

// Which instruction set the kernels run on here: "AVX3", "AVX2", "SSE4" ...
const char* kernel_target();

}  // namespace sinew
