// Closest-hit and any-hit traversal of Bvh8 hierarchies for single rays, eight boxes and four
// triangles at a time.
// Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013;
// T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Differs: triangle tests take four lanes, and
// only lanes with a zero edge function are computed again in double.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/traverse_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <cmath>
#include <cstring>
#include <type_traits>

#include "sinew/base/check.h"
#include "sinew/bvh/traverse.h"
#include "sinew/bvh/visit.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D8 = hn::CappedTag<float, 8>;  // eight lanes, or four where registers are small
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;

// The far distance of a box is widened by this factor: the three roundings of (plane - origin) *
// reciprocal on the near and the far side (Ize 2013), and one for the factor itself.
constexpr float kRobust = 1.0f + 2.0f * 4.0f * 5.97e-8f;

// Components of a direction that are smaller count as this.
constexpr float kTiny = 1e-37f;

template <class D>
HWY_INLINE uint32_t mask_bits(D d, hn::Mask<D> mask) {
  uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0] & ((1u << hn::Lanes(d)) - 1u);
}

// Rays without a direction, or with a number that is not one, meet nothing.
HWY_INLINE bool is_traceable(const Ray& ray) {
  const D4 d;
  const V4 origin = hn::LoadU(d, &ray.origin.x);        // with t_min
  const V4 direction = hn::LoadU(d, &ray.direction.x);  // with t_max, which may be infinite
  const V4 limit = hn::Set(d, std::numeric_limits<float>::max());
  const uint32_t finite = mask_bits(d, hn::Le(hn::Abs(origin), limit)) &
                          (mask_bits(d, hn::Le(hn::Abs(direction), limit)) | 8u);
  const uint32_t large = mask_bits(d, hn::Ge(hn::Abs(direction), hn::Set(d, kTiny)));
  return finite == 15u && (large & 7u) != 0 && ray.t_min <= ray.t_max;
}

// kShearAxes[negative][kz]: kx and ky, which keep the winding.
constexpr uint8_t kShearAxes[2][3][2] = {{{1, 2}, {2, 0}, {0, 1}}, {{2, 1}, {0, 2}, {1, 0}}};

// What a ray costs once per space that it enters.
struct RaySetup {
  alignas(16) float origin[4];
  alignas(16) float reciprocal[4];      // of the direction; finite
  alignas(16) float far_reciprocal[4];  // widened by kRobust
  uint32_t near[3], far[3];  // rows of a node: the planes that the ray meets first and last
  uint32_t kx, ky, kz;       // axes; the direction is largest along kz (Woop 2013)
  float shear_x, shear_y, shear_z;

  // Without branches, for neighbours differ. Four floats of both are read, the last is ignored.
  RaySetup(const float* o, const float* d) {
    const D4 d4;
    const V4 tiny = hn::Set(d4, kTiny);
    const V4 direction = hn::LoadU(d4, d);
    const V4 size = hn::Abs(direction);
    // Tiny components are replaced: 0 * infinity would be NaN for origins on a box plane.
    const V4 safe = hn::IfThenElse(hn::Lt(size, tiny), hn::CopySign(tiny, direction), direction);
    const V4 inverse = hn::Div(hn::Set(d4, 1.0f), safe);
    hn::Store(inverse, d4, reciprocal);
    hn::Store(hn::Mul(inverse, hn::Set(d4, kRobust)), d4, far_reciprocal);
    hn::Store(hn::LoadU(d4, o), d4, origin);
    const uint32_t negative = mask_bits(d4, hn::Lt(safe, hn::Zero(d4)));
    for (uint32_t axis = 0; axis < 3; ++axis) {
      near[axis] = axis + 3 * (negative >> axis & 1);
      far[axis] = axis + 3 - 3 * (negative >> axis & 1);
    }
    const float x = std::fabs(d[0]), y = std::fabs(d[1]), z = std::fabs(d[2]);
    const uint32_t z_largest = static_cast<uint32_t>(z > x) & static_cast<uint32_t>(z > y);
    kz = z_largest << 1 | (static_cast<uint32_t>(y > x) & (z_largest ^ 1u));
    const uint8_t* axes = kShearAxes[negative >> kz & 1][kz];
    kx = axes[0];
    ky = axes[1];
    shear_z = reciprocal[kz];
    shear_x = d[kx] * shear_z;
    shear_y = d[ky] * shear_z;
  }
};

// Bit i is set if the ray meets child i's box within [t_min, t_max]; entry[i] is where.
HWY_INLINE uint32_t test_boxes(const Node8& node, const RaySetup& ray, float t_min, float t_max,
                               float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;  // three rows of low planes, then three of high ones
  const float* near_x = planes[ray.near[0]];
  const float* near_y = planes[ray.near[1]];
  const float* near_z = planes[ray.near[2]];
  const float* far_x = planes[ray.far[0]];
  const float* far_y = planes[ray.far[1]];
  const float* far_z = planes[ray.far[2]];
  const auto ox = hn::Set(d, ray.origin[0]), oy = hn::Set(d, ray.origin[1]),
             oz = hn::Set(d, ray.origin[2]);
  const auto rx = hn::Set(d, ray.reciprocal[0]), ry = hn::Set(d, ray.reciprocal[1]),
             rz = hn::Set(d, ray.reciprocal[2]);
  const auto fx = hn::Set(d, ray.far_reciprocal[0]), fy = hn::Set(d, ray.far_reciprocal[1]),
             fz = hn::Set(d, ray.far_reciprocal[2]);
  uint32_t bits = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const auto nx = hn::Mul(hn::Sub(hn::Load(d, near_x + i), ox), rx);
    const auto ny = hn::Mul(hn::Sub(hn::Load(d, near_y + i), oy), ry);
    const auto nz = hn::Mul(hn::Sub(hn::Load(d, near_z + i), oz), rz);
    const auto lx = hn::Mul(hn::Sub(hn::Load(d, far_x + i), ox), fx);
    const auto ly = hn::Mul(hn::Sub(hn::Load(d, far_y + i), oy), fy);
    const auto lz = hn::Mul(hn::Sub(hn::Load(d, far_z + i), oz), fz);
    const auto near = hn::Max(hn::Max(nx, ny), hn::Max(nz, hn::Set(d, t_min)));
    const auto far = hn::Min(hn::Min(lx, ly), hn::Min(lz, hn::Set(d, t_max)));
    hn::Store(near, d, entry + i);
    bits |= mask_bits(d, hn::Le(near, far)) << i;
  }
  return bits;
}

struct PacketHits {
  uint32_t bits;                       // lanes whose triangle is met within [t_min, t_max]
  alignas(16) float t[4], v[4], w[4];  // distance; weights of the second and third corner
};

// Edge functions again in double, where float arithmetic gave zero.
HWY_NOINLINE void exact_edges(const V4 (&x)[3], const V4 (&y)[3], V4 (&e)[3]) {
  const D4 d;
  alignas(16) float sx[3][4], sy[3][4], se[4];
  for (int c = 0; c < 3; ++c) {
    hn::Store(x[c], d, sx[c]);
    hn::Store(y[c], d, sy[c]);
  }
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 2) % 3, b = (i + 1) % 3;
    hn::Store(e[i], d, se);
    for (int lane = 0; lane < 4; ++lane) {
      if (se[lane] != 0) continue;
      se[lane] = static_cast<float>(double{sx[a][lane]} * double{sy[b][lane]} -
                                    double{sy[a][lane]} * double{sx[b][lane]});
    }
    e[i] = hn::Load(d, se);
  }
}

// `side` is 0, or the sign that the determinant must have: 1 for front faces, -1 for back faces.
HWY_INLINE void test_packet(const TrianglePacket& packet, const RaySetup& ray, float t_min,
                            float t_max, float side, PacketHits& out) {
  const D4 d;
  const V4 zero = hn::Zero(d);
  const V4 shear_x = hn::Set(d, ray.shear_x), shear_y = hn::Set(d, ray.shear_y);
  V4 x[3], y[3], z[3];
  for (int corner = 0; corner < 3; ++corner) {
    const auto& v = packet.v[corner];
    z[corner] = hn::Sub(hn::Load(d, v[ray.kz]), hn::Set(d, ray.origin[ray.kz]));
    x[corner] = hn::Sub(hn::Sub(hn::Load(d, v[ray.kx]), hn::Set(d, ray.origin[ray.kx])),
                        hn::Mul(shear_x, z[corner]));
    y[corner] = hn::Sub(hn::Sub(hn::Load(d, v[ray.ky]), hn::Set(d, ray.origin[ray.ky])),
                        hn::Mul(shear_y, z[corner]));
  }
  V4 e[3];  // edge functions: e[i] belongs to the edge opposite corner i
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 2) % 3, b = (i + 1) % 3;
    e[i] = hn::Sub(hn::Mul(x[a], y[b]), hn::Mul(y[a], x[b]));
  }
  const auto any_zero = hn::Or(hn::Or(hn::Eq(e[0], zero), hn::Eq(e[1], zero)), hn::Eq(e[2], zero));
  if (HWY_UNLIKELY(!hn::AllFalse(d, any_zero))) exact_edges(x, y, e);
  const V4 least = hn::Min(hn::Min(e[0], e[1]), e[2]);
  const V4 most = hn::Max(hn::Max(e[0], e[1]), e[2]);
  const V4 det = hn::Add(hn::Add(e[0], e[1]), e[2]);
  auto hit = hn::And(hn::Or(hn::Ge(least, zero), hn::Le(most, zero)), hn::Ne(det, zero));
  out.bits = 0;
  if (hn::AllFalse(d, hit)) return;
  const V4 shear_z = hn::Set(d, ray.shear_z);
  const V4 scaled = hn::Mul(
      shear_z, hn::Add(hn::Add(hn::Mul(e[0], z[0]), hn::Mul(e[1], z[1])), hn::Mul(e[2], z[2])));
  const V4 t = hn::Div(scaled, det);
  hit = hn::And(hit, hn::And(hn::Ge(t, hn::Set(d, t_min)), hn::Le(t, hn::Set(d, t_max))));
  hit = hn::And(hit, hn::Ge(hn::Mul(det, hn::Set(d, side)), zero));
  out.bits = mask_bits(d, hit);
  if (out.bits == 0) return;
  hn::Store(t, d, out.t);
  hn::Store(hn::Div(e[1], det), d, out.v);
  hn::Store(hn::Div(e[2], det), d, out.w);
}

// A child word and where the ray enters its box, as one number that orders like the latter: entries
// are not negative. Any hit needs no order, so there an entry is the word alone.
using ClosestEntry = uint64_t;
using AnyEntry = uint32_t;

HWY_INLINE ClosestEntry make_entry(float entry, uint32_t word) {
  uint32_t bits;
  std::memcpy(&bits, &entry, sizeof(bits));
  return ClosestEntry{bits} << 32 | word;
}
HWY_INLINE float entry_distance(ClosestEntry e) {
  const auto bits = static_cast<uint32_t>(e >> 32);
  float entry;
  std::memcpy(&entry, &bits, sizeof(entry));
  return entry;
}
HWY_INLINE void order(ClosestEntry& a, ClosestEntry& b) {
  const ClosestEntry low = a < b ? a : b;
  b = a < b ? b : a;
  a = low;
}

// The nearest of the children in `bits` (not 0) is returned, the others are pushed, farthest first.
HWY_INLINE uint32_t push_others(const Node8& node, const float* entry, uint32_t bits,
                                ClosestEntry*& top) {
  const auto take = [&] {
    const int lane = __builtin_ctz(bits);
    bits &= bits - 1;
    return make_entry(entry[lane], node.child[lane]);
  };
  ClosestEntry a = take();
  if (bits == 0) return static_cast<uint32_t>(a);
  ClosestEntry b = take();
  order(a, b);
  if (bits == 0) {
    *top++ = b;
    return static_cast<uint32_t>(a);
  }
  ClosestEntry c = take();
  order(b, c);
  order(a, b);
  ClosestEntry* const first = top;
  top[0] = c;
  top[1] = b;
  top[2] = a;
  top += 3;
  while (bits != 0) {
    const ClosestEntry next = take();
    ClosestEntry* place = top++;
    while (place > first && *(place - 1) < next) {
      *place = *(place - 1);
      --place;
    }
    *place = next;
  }
  return static_cast<uint32_t>(*--top);
}

// The last child in `bits` (not 0) is returned, the others are pushed. Writes up to eight entries.
HWY_INLINE uint32_t push_others(const Node8& node, const float*, uint32_t bits, AnyEntry*& top) {
  const hn::CappedTag<uint32_t, 8> d;
  const auto last = static_cast<uint32_t>(31 - __builtin_clz(bits));
  const uint32_t word = node.child[last];
  bits ^= 1u << last;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const auto part = static_cast<uint8_t>(bits >> i & ((1u << hn::Lanes(d)) - 1));
    hn::StoreU(hn::Compress(hn::Load(d, node.child + i), hn::LoadMaskBits(d, &part)), d, top);
    top += __builtin_popcount(part);
  }
  return word;
}

// Two-level traversal: instances hang below top nodes, so both levels share one stack.
constexpr size_t kStackSize = 2 * kMaxDepth * (kWidth - 1) + kWidth;

// What a ray meets on its way is counted by policy, so that queries which count nothing hold no
// trace of it.
struct CountNothing {
  void node() {}
  void packet() {}
};
struct CountSteps {
  TraversalCounts& counts;
  void node() { ++counts.nodes; }
  void packet() { ++counts.packets; }
};

// One ray of a query. kAny stops at the first accepted hit.
template <bool kAny, class Counter = CountNothing>
class Traversal {
 public:
  Traversal(const SceneView& scene, const QueryOptions& options, const Ray& ray, uint32_t index,
            Counter counter = {})
      : scene_(scene), options_(options), ray_(ray), index_(index), counter_(counter) {
    best_.t = ray.t_max;
  }

  Hit run() {
    if (!is_traceable(ray_)) return Hit();
    const RaySetup setup(&ray_.origin.x, &ray_.direction.x);
    if (scene_.top == nullptr) {
      if (scene_.instance_count > 0) visit_leaf_of_top({0}, setup, stack_);
    } else {
      descend(scene_.top, 0, setup, stack_, [&](uint32_t word, StackEntry* base) {
        const uint32_t index = word & ~kLeafBit;
        return visit_leaf_of_top(scene_.leaves != nullptr ? scene_.leaves[index] : TopLeaf{index},
                                 setup, base);
      });
    }
    if (!best_) best_.t = std::numeric_limits<float>::infinity();
    return best_;
  }

 private:
  using StackEntry = std::conditional_t<kAny, AnyEntry, ClosestEntry>;

  // Walks a tree of nodes, front to back where the closest hit is sought, and calls leaf(word, free
  // part of the stack) for leaves; stops when it returns true.
  template <class Leaf>
  HWY_INLINE bool descend(const Node8* nodes, uint32_t root, const RaySetup& setup,
                          StackEntry* const base, const Leaf& leaf) {
    StackEntry* top = base;
    uint32_t word = root;
    alignas(64) float entry[kWidth];
    for (;;) {
      if (!is_inner_word(word)) {
        if (leaf(word, top)) return true;
      } else {
        const Node8& node = nodes[word];
        __builtin_prefetch(node.child);  // a cache line that the boxes do not touch
        counter_.node();
        const uint32_t bits = test_boxes(node, setup, ray_.t_min, best_.t, entry);
        if (bits != 0) {
          word = push_others(node, entry, bits, top);
          continue;
        }
      }
      do {
        if (top == base) return false;
        --top;
      } while (is_too_far(*top));
      word = static_cast<uint32_t>(*top);
    }
  }

  bool is_too_far(AnyEntry) const { return false; }
  bool is_too_far(ClosestEntry e) const { return entry_distance(e) > best_.t * kRobust; }

  bool visit_leaf_of_top(const TopLeaf& leaf, const RaySetup& world, StackEntry* base) {
    const Instance& instance = scene_.instances[leaf.instance];
    if ((instance.mask & options_.mask) == 0) return false;
    if (instance.in_place) return visit_body(instance, leaf.word, world, base);
    const vec4 origin(transform_point(instance.to_object, ray_.origin), 0.0f);
    const vec4 direction(transform_vector(instance.to_object, ray_.direction), 0.0f);
    return visit_body(instance, leaf.word, RaySetup(&origin.x, &direction.x), base);
  }

  // `part` is the child word of a part of the body, or kNoChild for all of it.
  bool visit_body(const Instance& instance, uint32_t part, const RaySetup& setup,
                  StackEntry* base) {
    side_ = 0.0f;
    if (instance.single_sided && options_.facing != Facing::any) {
      side_ = options_.facing == Facing::front ? 1.0f : -1.0f;
    }
    uint32_t root = part != kNoChild ? part : instance.root;
    if (part == kNoChild && instance.body != nullptr) {
      VisitedBody& body = *instance.body;
      if (!is_ready(body) && !visit_upper(body)) return look_through_body(instance, setup);
      root = body.upper.load(std::memory_order_acquire);
    }
    if (root == kNoChild) return false;
    return descend(instance.nodes, root, setup, base, [&](uint32_t word, StackEntry* free) {
      return is_leaf_word(word) ? visit_leaf(instance, word, setup)
                                : visit_treelet(instance, treelet_of(word), setup, free);
    });
  }

  HWY_INLINE bool visit_leaf(const Instance& instance, uint32_t word, const RaySetup& setup) {
    const uint32_t first = leaf_first(word), end = first + leaf_packets(word);
    for (uint32_t p = first; p != end; ++p) {
      if (visit_packet(instance, instance.packets[p], p, setup)) return true;
    }
    return false;
  }

  HWY_NOINLINE bool visit_treelet(const Instance& instance, uint32_t treelet, const RaySetup& setup,
                                  StackEntry* base) {
    VisitedBody& body = *instance.body;
    uint32_t word = std::atomic_ref(body.bvh->links[treelet]).load(std::memory_order_acquire);
    if (word >= kBeingMade) word = sinew::visit_treelet(body, treelet);
    if (word == kNoChild) return look_through_treelet(instance, treelet, setup);
    return descend(instance.nodes, word, setup, base,
                   [&](uint32_t leaf, StackEntry*) { return visit_leaf(instance, leaf, setup); });
  }

  // Another thread makes the upper tree: all treelets, one after another.
  HWY_NOINLINE bool look_through_body(const Instance& instance, const RaySetup& setup) {
    Node8 node = empty_node();
    alignas(64) float entry[kWidth];
    for (uint32_t t = 0; t < instance.body->layout->treelets.size(); ++t) {
      set_lane_box(node, 0, look_at_box(*instance.body, t));
      if (test_boxes(node, setup, ray_.t_min, best_.t, entry) == 0) continue;
      if (look_through_treelet(instance, t, setup)) return true;
    }
    return false;
  }

  // Another thread makes the treelet: all its packets, from a copy.
  HWY_NOINLINE bool look_through_treelet(const Instance& instance, uint32_t treelet,
                                         const RaySetup& setup) {
    TreeletPackets packets;
    look_at_packets(*instance.body, treelet, packets);
    const Treelet& t = instance.body->layout->treelets[treelet];
    for (uint32_t p = 0; p < t.packet_count; ++p) {
      if (visit_packet(instance, packets[p], t.first_packet + p, setup)) return true;
    }
    return false;
  }

  HWY_INLINE bool visit_packet(const Instance& instance, const TrianglePacket& packet,
                               uint32_t index, const RaySetup& setup) {
    PacketHits hits;
    counter_.packet();
    __builtin_prefetch(&instance.primitives[index]);
    test_packet(packet, setup, ray_.t_min, best_.t, side_, hits);
    for (uint32_t bits = hits.bits; bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      const Hit hit{hits.t[lane], hits.v[lane], hits.w[lane], instance.primitives[index][lane],
                    instance.object};
      if (hit.primitive == kNoPrimitive || !closer(hit)) continue;
      if ((instance.filtered || options_.filter.of_all) && options_.filter.accept != nullptr &&
          !options_.filter.accept(options_.filter.context, index_, hit)) {
        continue;
      }
      best_ = hit;
      if (kAny) return true;
    }
    return false;
  }

  // Least (t, object, primitive); the first hit may lie at t_max exactly.
  bool closer(const Hit& hit) const {
    if (hit.t != best_.t) return hit.t < best_.t;
    if (hit.object != best_.object) return hit.object < best_.object;
    return hit.primitive < best_.primitive;
  }

  const SceneView& scene_;
  const QueryOptions& options_;
  const Ray ray_;
  const uint32_t index_;
  [[no_unique_address]] Counter counter_;
  Hit best_;
  float side_ = 0.0f;
  StackEntry stack_[kStackSize];
};

void closest_hits_kernel(const SceneView& scene, const Ray* rays, Hit* hits, size_t count,
                         const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    hits[i] =
        Traversal<false>(scene, options, rays[i], options.first_ray + static_cast<uint32_t>(i))
            .run();
  }
}

void count_closest_hits_kernel(const SceneView& scene, const Ray* rays, Hit* hits,
                               TraversalCounts* counts, size_t count, const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    counts[i] = {};
    hits[i] = Traversal<false, CountSteps>(scene, options, rays[i],
                                           options.first_ray + static_cast<uint32_t>(i),
                                           CountSteps{counts[i]})
                  .run();
  }
}

void any_hits_kernel(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                     const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    hit[i] = static_cast<bool>(
        Traversal<true>(scene, options, rays[i], options.first_ray + static_cast<uint32_t>(i))
            .run());
  }
}

const char* target_name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(closest_hits_kernel);
HWY_EXPORT(count_closest_hits_kernel);
HWY_EXPORT(any_hits_kernel);
HWY_EXPORT(target_name);

void closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                  const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hits.size());
  HWY_DYNAMIC_DISPATCH(closest_hits_kernel)
  (scene, rays.data(), hits.data(), rays.size(), options);
}

void count_closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                        std::span<TraversalCounts> counts, const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hits.size() && rays.size() == counts.size());
  HWY_DYNAMIC_DISPATCH(count_closest_hits_kernel)
  (scene, rays.data(), hits.data(), counts.data(), rays.size(), options);
}

void any_hits(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
              const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hit.size());
  HWY_DYNAMIC_DISPATCH(any_hits_kernel)(scene, rays.data(), hit.data(), rays.size(), options);
}

const char* kernel_target() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace sinew
#endif
