// Closest-hit and any-hit traversal of Bvh8 hierarchies for one ray. Included once per target.
#if defined(SINEW_BVH_RAY_TRAVERSAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_RAY_TRAVERSAL_INL_H_
#undef SINEW_BVH_RAY_TRAVERSAL_INL_H_
#else
#define SINEW_BVH_RAY_TRAVERSAL_INL_H_
#endif

#include <cstring>
#include <thread>
#include <type_traits>

#include "sinew/bvh/box_body.h"
#include "sinew/bvh/pack-inl.h"
#include "sinew/bvh/trace/ray_tests-inl.h"
#include "sinew/bvh/trace/traverse.h"
#include "sinew/bvh/update/visit.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

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

// Asks for the cache lines of what a child word stands for.
HWY_INLINE void prefetch_child(const Node8* nodes, const TrianglePacket* packets, uint32_t word) {
  const void* place = nodes + word;
  if (!is_inner_word(word)) {
    if (packets == nullptr || !is_leaf_word(word)) return;
    place = packets + leaf_first(word);
  }
  const char* line = static_cast<const char*>(place);
  for (int i = 0; i < 3; ++i) __builtin_prefetch(line + 64 * i);
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
  const D8u d;
  const auto last = static_cast<uint32_t>(31 - __builtin_clz(bits));
  const uint32_t word = node.child[last];
  bits ^= 1u << last;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const uint32_t part = bits >> i & ((1u << hn::Lanes(d)) - 1);
    store_lanes(d, hn::Load(d, node.child + i), part, top);
    top += __builtin_popcount(part);
  }
  return word;
}

// Two-level traversal: instances hang below top nodes, so both levels share one stack.
constexpr size_t kStackSize = 2 * kMaxDepth * (kWidth - 1) + kWidth;

// What a ray meets on its way is counted by policy, so that queries which count nothing hold no
// trace of it.
struct CountNothing {
  static constexpr bool kWaits = false;
  void node() {}
  void packet() {}
  void treelet() {}
};
struct CountSteps {
  static constexpr bool kWaits = true;  // for what other threads make, so that counts are exact
  TraversalCounts& counts;
  void node() { ++counts.nodes; }
  void packet() { ++counts.packets; }
  void treelet() { ++counts.treelets; }
};

// Least (t, object, primitive); the first hit may lie at t_max exactly.
HWY_INLINE bool is_closer(const Hit& hit, const Hit& than) {
  if (hit.t != than.t) return hit.t < than.t;
  if (hit.object != than.object) return hit.object < than.object;
  return hit.primitive < than.primitive;
}

// The sign that determinants of triangles which count must have, or 0.
HWY_INLINE float side_of(const Instance& instance, const QueryOptions& options) {
  if (!instance.single_sided || options.facing == Facing::any) return 0.0f;
  return options.facing == Facing::front ? 1.0f : -1.0f;
}

// Whether the query's filter is to be asked about hits of the instance.
HWY_INLINE bool is_asked(const Instance& instance, const QueryOptions& options) {
  return (instance.filtered || options.filter.of_all) && options.filter.accept != nullptr;
}

// A packet of the instance, packed into `room` if need be.
HWY_INLINE const TrianglePacket& packet_of(const Instance& instance, uint32_t index,
                                           TrianglePacket& room) {
  if (instance.packets != nullptr) return instance.packets[index];
  const PacketCorners& corners = instance.corners[index];
  pack_triangles(corners, instance.vertices + corners.place, room);
  return room;
}

// How wide a ray is in the space of an instance. Lengths there are those of its direction.
struct LocalFootprint {
  float width = 0.0f, spread = 0.0f;

  HWY_INLINE LocalFootprint(const RayFootprint& world, const Instance& instance,
                            const float* HWY_RESTRICT along, const vec3& direction)
      : width(world.width), spread(world.spread) {
    if (instance.in_place || width == 0.0f) return;
    const float local = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
    width *= std::sqrt(local / dot(direction, direction));
  }
};

// How wide a ray from (x, y, z) is where it may reach a detail first. Depends on nothing that the
// ray met before.
HWY_INLINE float width_at(const BoxDetail& detail, const LocalFootprint& ray, float x, float y,
                          float z) {
  const auto beyond = [&](int axis, float at) {
    const float before = detail.low[axis] - at, after = at - detail.high[axis];
    const float least = before > after ? before : after;
    return least > 0.0f ? least : 0.0f;
  };
  const float dx = beyond(0, x), dy = beyond(1, y), dz = beyond(2, z);
  return ray.width + ray.spread * std::sqrt(dx * dx + dy * dy + dz * dz);
}

// The finest level of a detail whose boxes are at least as wide as the ray, of those that are
// there.
HWY_INLINE uint32_t level_for(const BoxDetail& detail, float width) {
  uint32_t level = 0;
  for (float size = detail.size; level + 1 < kBoxLevels && size < width; size += size) ++level;
  return level > detail.finest ? level : detail.finest;
}

// The last level of a detail as a packet.
HWY_INLINE Node8 whole_packet(const BoxDetail& detail) {
  Node8 packet = empty_node();
  for (int axis = 0; axis < 3; ++axis) {
    packet.low[axis][0] = detail.low[axis];
    packet.high[axis][0] = detail.high[axis];
  }
  packet.child[0] = detail.whole;
  return packet;
}

// What a leaf word of the top tree means.
HWY_INLINE TopLeaf top_leaf(const SceneView& scene, uint32_t word) {
  const uint32_t index = word & ~kLeafBit;
  return scene.leaves != nullptr ? scene.leaves[index] : TopLeaf{index};
}

// One ray of a query. kAny stops at the first accepted hit.
template <bool kAny, class Setup, class Counter = CountNothing>
class Traversal {
 public:
  Traversal(const SceneView& scene, const QueryOptions& options, const Ray& ray, uint32_t index,
            Counter counter = {})
      : scene_(scene), options_(options), ray_(ray), index_(index), counter_(counter) {
    best_.t = ray.t_max;
  }

  Hit run() {
    if (!is_traceable(ray_)) return Hit();
    const Setup setup(&ray_.origin.x, &ray_.direction.x);
    if (scene_.top == nullptr) {
      if (scene_.instance_count > 0) {
        visit_instance(scene_.instances[0], kNoChild, setup, stack_);
      }
    } else {
      descend(scene_.top, nullptr, 0, setup, stack_, [&](uint32_t word, StackEntry* base) {
        const TopLeaf leaf = top_leaf(scene_, word);
        return visit_instance(scene_.instances[leaf.instance], leaf.word, setup, base);
      });
    }
    if (!best_) best_.t = std::numeric_limits<float>::infinity();
    return best_;
  }

  // Visits one instance, with what was found before.
  Hit resume(const Instance& instance, const Hit& best) {
    best_ = best;
    visit_instance(instance, kNoChild, Setup(&ray_.origin.x, &ray_.direction.x), stack_);
    return best_;
  }

  // Goes on below the child word `word` of an instance, with what was found before.
  Hit resume(const Instance& instance, uint32_t word, const Hit& best) {
    best_ = best;
    choose_side(instance);
    with_setup(instance, Setup(&ray_.origin.x, &ray_.direction.x),
               [&](const Setup& setup) { return descend_body(instance, word, setup, stack_); });
    return best_;
  }

 private:
  using StackEntry = std::conditional_t<kAny, AnyEntry, ClosestEntry>;

  // Walks a tree of nodes, front to back where the closest hit is sought, and calls leaf(word, free
  // part of the stack) for leaves; stops when it returns true.
  template <class Leaf>
  HWY_INLINE bool descend(const Node8* nodes, const TrianglePacket* packets, uint32_t root,
                          const Setup& setup, StackEntry* const base, const Leaf& leaf) {
    // The leaf may push child words that take its place.
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
          // Pays where the hit sought is not the first that is found.
          if (!kAny && (bits & (bits - 1)) != 0) {
            prefetch_child(nodes, packets, static_cast<uint32_t>(*(top - 1)));
          }
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
  bool is_too_far(ClosestEntry e) const { return entry_distance(e) > best_.t * kReach; }

  // `part` is the child word of a part of it, or kNoChild for all.
  bool visit_instance(const Instance& instance, uint32_t part, const Setup& world,
                      StackEntry* base) {
    if (!options_.sees(instance)) return false;
    if (instance.boxes != nullptr) return visit_boxes(instance, world, base);
    choose_side(instance);
    return with_setup(instance, world, [&](const Setup& setup) {
      uint32_t root = part != kNoChild ? part : instance.root;
      if (part == kNoChild && instance.body != nullptr) {
        VisitedBody& body = *instance.body;
        if (!is_ready(body) && !visit_upper(body)) {
          if (!Counter::kWaits) return look_through_body(instance, setup);
          while (!is_ready(body)) std::this_thread::yield();
        }
        root = body.upper.load(std::memory_order_acquire);
      }
      return root != kNoChild && descend_body(instance, root, setup, base);
    });
  }

  // Calls with(setup of the ray in the instance's space).
  template <class With>
  HWY_INLINE bool with_setup(const Instance& instance, const Setup& world, const With& with) {
    if (instance.in_place) return with(world);
    const vec4 origin(transform_point(instance.to_object, ray_.origin), 0.0f);
    const vec4 direction(transform_vector(instance.to_object, ray_.direction), 0.0f);
    return with(Setup(&origin.x, &direction.x));
  }

  HWY_NOINLINE bool visit_boxes(const Instance& instance, const Setup& world, StackEntry* base) {
    const BoxBody& body = *instance.boxes;
    const vec3 along =
        instance.in_place ? ray_.direction : transform_vector(instance.to_object, ray_.direction);
    const LocalFootprint footprint(options_.footprint, instance, &along.x, ray_.direction);
    return body.root != kNoChild && with_setup(instance, world, [&](const Setup& setup) {
             return descend(
                 body.nodes, nullptr, body.root, setup, base, [&](uint32_t word, StackEntry*& top) {
                   if (is_leaf_word(word)) return visit_box_leaf(instance, word, setup);
                   return visit_box_treelet(instance, treelet_of(word), footprint, setup, top);
                 });
           });
  }

  HWY_INLINE bool visit_box_leaf(const Instance& instance, uint32_t word, const Setup& setup) {
    const uint32_t first = leaf_first(word), end = first + leaf_packets(word);
    for (uint32_t p = first; p != end; ++p) {
      if (visit_box_packet(instance, instance.boxes->nodes[p], setup)) return true;
    }
    return false;
  }

  HWY_INLINE bool visit_box_treelet(const Instance& instance, uint32_t treelet,
                                    const LocalFootprint& footprint, const Setup& setup,
                                    StackEntry*& top) {
    const BoxBody& body = *instance.boxes;
    bool made = false;
    uint32_t word;
    if (treelet < body.parts) {
      word = visit_box_part(body, treelet, made);
    } else {
      const BoxDetail& detail = body.details[treelet - body.parts];
      const float width =
          width_at(detail, footprint, setup.origin[0], setup.origin[1], setup.origin[2]);
      if (body.wishes != nullptr) wish_for(body, detail, width);
      const uint32_t level = level_for(detail, width);
      if (level + 1 == kBoxLevels) return visit_box_packet(instance, whole_packet(detail), setup);
      word = visit_box_detail(body, treelet - body.parts, level, made);
    }
    if (made) counter_.treelet();
    if (is_leaf_word(word)) return visit_box_leaf(instance, word, setup);
    if constexpr (kAny) {
      *top++ = word;
    } else {
      *top++ = make_entry(0.0f, word);
    }
    return false;
  }

  HWY_INLINE bool visit_box_packet(const Instance& instance, const Node8& packet,
                                   const Setup& setup) {
    alignas(64) float entry[kWidth];
    counter_.packet();
    __builtin_prefetch(packet.child);
    for (uint32_t bits = test_boxes(packet, setup, ray_.t_min, best_.t, entry); bits != 0;
         bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      // + 0: not -0, which a minimum may or may not choose.
      const Hit hit{entry[lane] + 0.0f, 0.0f, 0.0f, packet.child[lane], instance.object};
      if (!is_closer(hit, best_)) continue;
      if (is_asked(instance, options_) &&
          !options_.filter.accept(options_.filter.context, index_, hit)) {
        continue;
      }
      best_ = hit;
      if (kAny) return true;
    }
    return false;
  }

  void choose_side(const Instance& instance) { side_ = side_of(instance, options_); }

  HWY_NOINLINE bool descend_body(const Instance& instance, uint32_t root, const Setup& setup,
                                 StackEntry* base) {
    return descend(
        instance.nodes, instance.packets, root, setup, base, [&](uint32_t word, StackEntry* free) {
          return is_leaf_word(word) ? visit_leaf(instance, word, setup)
                                    : visit_treelet(instance, treelet_of(word), setup, free);
        });
  }

  HWY_INLINE bool visit_leaf(const Instance& instance, uint32_t word, const Setup& setup) {
    const uint32_t first = leaf_first(word), end = first + leaf_packets(word);
    TrianglePacket room;
    for (uint32_t p = first; p != end; ++p) {
      if (visit_packet(instance, packet_of(instance, p, room), p, setup)) return true;
    }
    return false;
  }

  HWY_NOINLINE bool visit_treelet(const Instance& instance, uint32_t treelet, const Setup& setup,
                                  StackEntry* base) {
    VisitedBody& body = *instance.body;
    uint32_t word = std::atomic_ref(body.bvh->links[treelet]).load(std::memory_order_acquire);
    if (word >= kBeingMade) {
      word = sinew::visit_treelet(body, treelet);
      while (Counter::kWaits && word == kNoChild) {
        std::this_thread::yield();
        word = sinew::visit_treelet(body, treelet);
      }
      if (word == kNoChild) return look_through_treelet(instance, treelet, setup);
      counter_.treelet();
    }
    return descend(instance.nodes, instance.packets, word, setup, base,
                   [&](uint32_t leaf, StackEntry*) { return visit_leaf(instance, leaf, setup); });
  }

  // Another thread makes the upper tree: all treelets, one after another.
  HWY_NOINLINE bool look_through_body(const Instance& instance, const Setup& setup) {
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
                                         const Setup& setup) {
    TreeletPackets packets;
    look_at_packets(*instance.body, treelet, packets);
    const Treelet& t = instance.body->layout->treelets[treelet];
    for (uint32_t p = 0; p < t.packet_count; ++p) {
      if (visit_packet(instance, packets[p], t.first_packet + p, setup)) return true;
    }
    return false;
  }

  HWY_INLINE bool visit_packet(const Instance& instance, const TrianglePacket& packet,
                               uint32_t index, const Setup& setup) {
    const D4 d;
    PacketHits<D4> hits;
    counter_.packet();
    __builtin_prefetch(&instance.primitives[index]);
    test_packet(d, packet, lanes_of(setup, ray_.t_min), hn::Set(d, best_.t), side_, hits);
    for (uint32_t bits = hits.bits; bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      const Hit hit{hits.t[lane], hits.v[lane], hits.w[lane], instance.primitives[index][lane],
                    instance.object};
      if (hit.primitive == kNoPrimitive || !is_closer(hit, best_)) continue;
      if (is_asked(instance, options_) &&
          !options_.filter.accept(options_.filter.context, index_, hit)) {
        continue;
      }
      best_ = hit;
      if (kAny) return true;
    }
    return false;
  }

  const SceneView& scene_;
  const QueryOptions& options_;
  const Ray& ray_;
  const uint32_t index_;
  [[no_unique_address]] Counter counter_;
  Hit best_;
  float side_ = 0.0f;
  StackEntry stack_[kStackSize];
};

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
