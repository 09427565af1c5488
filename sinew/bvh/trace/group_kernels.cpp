// Queries that trace rays in groups: rays of a span are sorted by the signs and the largest axis of
// their directions, and up to 64 of a kind go through the hierarchy together. Where few of them are
// left, each goes on alone. The hits have the same bits as those of rays traced one by one.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/trace/group_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <utility>

#include "sinew/bvh/trace/group_stack-inl.h"
#include "sinew/bvh/trace/query_kernels.h"
#include "sinew/bvh/trace/ray_group-inl.h"
#include "sinew/bvh/trace/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// So few rays a vector are tested one by one: it costs less than tests of mostly idle lanes. Where
// any hit is sought, that takes no branches.
constexpr uint32_t kSinglyPerVector = 3, kSinglyPerVectorAny = 12;

HWY_INLINE bool are_few(uint64_t rays, uint32_t per_vector = kSinglyPerVector) {
  const auto count = static_cast<uint32_t>(__builtin_popcountll(rays));
  return count <= per_vector * count_vectors(rays);
}

// `Lone` is GroupRay or FastGroupRay: how triangles are tested that few rays reach.
template <bool kAny, class Lone = GroupRay>
class GroupTraversal {
 public:
  GroupTraversal(const SceneView& scene, const QueryOptions& options, const Ray* rays)
      : scene_(scene), options_(options), rays_(rays) {}

  void run(RayGroup& group) {
    group.prepare();
    if (scene_.top == nullptr) {
      if (scene_.instance_count > 0) {
        visit_instance(scene_.instances[0], kNoChild, group, group.alive, 0);
      }
    } else {
      descend(scene_.top, nullptr, 0, group, group.alive, 0,
              [&](uint32_t word, uint64_t mask, size_t free) {
                const TopLeaf leaf = top_leaf(scene_, word);
                visit_instance(scene_.instances[leaf.instance], leaf.word, group, mask, free);
              });
    }
  }

 private:
  // Walks a tree of nodes with the rays of `mask`, front to back where the closest hit is sought,
  // and calls leaf(word, its rays, free part of the stack) for leaves.
  template <class Leaf>
  HWY_INLINE void descend(const Node8* nodes, const TrianglePacket* packets, uint32_t root,
                          RayGroup& group, uint64_t mask, const size_t base, const Leaf& leaf) {
    size_t top = base;
    GroupEntry now{mask, 0.0f, root}, held{};
    do {
      if (is_inner_word(now.word)) {
        push_children(nodes, packets, now.word, group, now.rays, top);
      } else {
        leaf(now.word, now.rays, top);
      }
    } while (take_next(nodes, packets, group, base, top, now, held));
  }

  // The next entry above `base` with rays that still seek a hit; false if there is none.
  HWY_INLINE bool pop(const RayGroup& group, size_t base, size_t& top, GroupEntry& out) const {
    while (top != base) {
      out = stack_.at(--top);
      out.rays &= group.alive;
      if (!kAny) out.rays = still_reach(group, out.rays, out.entry);
      if (out.rays != 0) return true;
    }
    return false;
  }

  // The same, but where any hit will do a node is held back while its cache lines come, and the one
  // that was held before it is visited. Not so leaves: what is soon done stays first.
  HWY_INLINE bool take_next(const Node8* nodes, const TrianglePacket* packets,
                            const RayGroup& group, size_t base, size_t& top, GroupEntry& now,
                            GroupEntry& held) const {
    while (pop(group, base, top, now)) {
      if (!kAny) return true;
      if (!is_inner_word(now.word) || top - base > kMostHeldOver) {
        if (top != base) prefetch_child(nodes, packets, stack_.at(top - 1).word);
        return true;
      }
      prefetch_child(nodes, packets, now.word);
      std::swap(now, held);
      now.rays &= group.alive;
      if (now.rays != 0) return true;
    }
    now = held;
    now.rays &= group.alive;
    held.rays = 0;
    return now.rays != 0;
  }

  // Farthest first.
  HWY_INLINE void push_children(const Node8* nodes, const TrianglePacket* packets, uint32_t parent,
                                const RayGroup& group, uint64_t mask, size_t& top) {
    const Node8& node = nodes[parent];
    __builtin_prefetch(node.child);
    alignas(64) float entry[kWidth];
    const size_t first = top;
    const auto push = [&](const GroupEntry& next) {
      prefetch_child(nodes, packets, next.word);
      stack_.insert(first, top, next);
    };
    if constexpr (kAny) {
      if (are_few(mask, kSinglyPerVectorAny)) {
        ChildRays rays;
        test_boxes_singly(node, group, mask, rays);
        return stack_.push_met(top, node, rays);
      }
    } else if (are_few(mask)) {
      uint64_t rays[kWidth];
      for (uint32_t bits = test_boxes_singly(node, group, mask, rays, entry); bits != 0;
           bits &= bits - 1) {
        const auto child = static_cast<uint32_t>(__builtin_ctz(bits));
        push({rays[child], entry[child], node.child[child]});
      }
      return;
    }
    for (uint32_t bits = test_boxes(node, group, entry); bits != 0; bits &= bits - 1) {
      const auto child = static_cast<uint32_t>(__builtin_ctz(bits));
      GroupEntry next;
      next.rays = test_box<kAny>(node, child, group, mask, next.entry);
      if (next.rays == 0) continue;
      next.word = node.child[child];
      push(next);
    }
  }

  // `part` is the child word of a part of it, or kNoChild for all.
  void visit_instance(const Instance& instance, uint32_t part, RayGroup& group, uint64_t mask,
                      size_t base) {
    if (!options_.sees(instance)) return;
    if (instance.boxes != nullptr) {
      if (instance.boxes->root == kNoChild) return;
      if (instance.in_place) return visit_boxes(instance, group, mask, base);
      return visit_transformed(instance, kNoChild, group, mask, base);
    }
    uint32_t root = part != kNoChild ? part : instance.root;
    if (part == kNoChild && instance.body != nullptr) {
      VisitedBody& body = *instance.body;
      if (!is_ready(body) && !visit_upper(body)) return visit_alone(instance, group, mask);
      root = body.upper.load(std::memory_order_acquire);
    }
    if (root == kNoChild) return;
    if (instance.in_place) return visit_body(instance, root, group, mask, base);
    visit_transformed(instance, root, group, mask, base);
  }

  // Rays of a class in the object's space make a group of their own.
  HWY_NOINLINE void visit_transformed(const Instance& instance, uint32_t root, RayGroup& group,
                                      uint64_t mask, size_t base) {
    while (mask != 0) {
      RayGroup local;
      uint32_t from[kGroup], common = 0;
      for (uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<uint32_t>(__builtin_ctzll(rest));
        const Ray& ray = rays_[group.ray[i]];
        const vec3 origin = transform_point(instance.to_object, ray.origin);
        const vec4 direction(transform_vector(instance.to_object, ray.direction), 0.0f);
        const uint32_t kind = group_class(&direction.x);
        if (local.count == 0) common = kind;
        if (kind != common) continue;
        from[local.count] = i;
        local.set_hit(local.count, group.hit(i));
        local.add(&origin.x, &direction.x, group.t_min[i], group.t[i], group.ray[i]);
        mask &= ~(uint64_t{1} << i);
      }
      local.prepare();
      const uint64_t all = local.alive;
      if (instance.boxes != nullptr) {
        visit_boxes(instance, local, all, base);
      } else {
        visit_body(instance, root, local, all, base);
      }
      for (uint32_t k = 0; k < local.count; ++k) {
        group.set_hit(from[k], local.hit(k));
        if (!(local.alive >> k & 1)) group.alive &= ~(uint64_t{1} << from[k]);
      }
    }
    group.find_most_t();
  }

  void visit_body(const Instance& instance, uint32_t root, RayGroup& group, uint64_t mask,
                  size_t base) {
    const float side = side_of(instance, options_);
    descend(instance.nodes, instance.packets, root, group, mask, base,
            [&](uint32_t word, uint64_t rays, size_t& free) {
              if (is_leaf_word(word)) {
                visit_leaf(instance, word, side, group, rays);
              } else {
                visit_treelet(instance, treelet_of(word), group, rays, free);
              }
            });
  }

  HWY_NOINLINE void visit_boxes(const Instance& instance, RayGroup& group, uint64_t mask,
                                size_t base) {
    const BoxBody& body = *instance.boxes;
    descend(body.nodes, nullptr, body.root, group, mask, base,
            [&](uint32_t word, uint64_t rays, size_t& free) {
              if (is_leaf_word(word)) return visit_box_leaf(instance, word, group, rays);
              visit_box_treelet(instance, treelet_of(word), group, rays, free);
            });
  }

  // Of ray i of the group at the detail.
  HWY_INLINE float width_of(const Instance& instance, const BoxDetail& detail,
                            const RayGroup& group, uint32_t i) const {
    const float along[3] = {group.direction[0][i], group.direction[1][i], group.direction[2][i]};
    const LocalFootprint local(options_.footprint, instance, along, rays_[group.ray[i]].direction);
    return width_at(detail, local, group.origin[0][i], group.origin[1][i], group.origin[2][i]);
  }

  HWY_NOINLINE void wish_for_narrowest(const Instance& instance, const BoxDetail& detail,
                                       const RayGroup& group, uint64_t mask) const {
    float least = std::numeric_limits<float>::infinity();
    for (; mask != 0 && least > 0.0f; mask &= mask - 1) {
      const auto i = static_cast<uint32_t>(__builtin_ctzll(mask));
      least = std::min(least, width_of(instance, detail, group, i));
    }
    wish_for(*instance.boxes, detail, least);
  }

  HWY_INLINE void visit_box_treelet(const Instance& instance, uint32_t treelet, RayGroup& group,
                                    uint64_t mask, size_t& top) {
    const BoxBody& body = *instance.boxes;
    bool made = false;
    if (treelet < body.parts) {
      return stack_.push(top, {mask, 0.0f, visit_box_part(body, treelet, made)});
    }
    const uint32_t index = treelet - body.parts;
    const BoxDetail& detail = body.details[index];
    const RayFootprint& footprint = options_.footprint;
    uint64_t levels[kBoxLevels] = {};
    if (body.wishes != nullptr) wish_for_narrowest(instance, detail, group, mask);
    if (footprint.width == 0.0f && footprint.spread == 0.0f) {
      levels[detail.finest] = mask;
    } else {
      for (uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<uint32_t>(__builtin_ctzll(rest));
        const uint32_t level = level_for(detail, width_of(instance, detail, group, i));
        levels[level] |= uint64_t{1} << i;
      }
    }
    for (uint32_t l = 0; l + 1 < kBoxLevels; ++l) {
      if (levels[l] == 0) continue;
      stack_.push(top, {levels[l], 0.0f, visit_box_detail(body, index, l, made)});
    }
    if (levels[kBoxLevels - 1] != 0) {
      visit_box_packet(instance, whole_packet(detail), group, levels[kBoxLevels - 1]);
      if (!kAny) group.find_most_t();
    }
  }

  HWY_INLINE void visit_box_leaf(const Instance& instance, uint32_t word, RayGroup& group,
                                 uint64_t mask) {
    const uint32_t first = leaf_first(word), end = first + leaf_packets(word);
    for (uint32_t p = first; p != end && mask != 0; ++p) {
      visit_box_packet(instance, instance.boxes->nodes[p], group, mask);
      if (kAny) mask &= group.alive;
    }
    if (!kAny) group.find_most_t();
  }

  // Few rays one by one against eight boxes, many against one box after another.
  HWY_INLINE void visit_box_packet(const Instance& instance, const Node8& packet, RayGroup& group,
                                   uint64_t mask) {
    __builtin_prefetch(packet.child);
    if (are_few(mask)) {
      for (; mask != 0; mask &= mask - 1) {
        const auto k = static_cast<uint32_t>(__builtin_ctzll(mask));
        visit_boxes_singly(instance, packet, group, k);
      }
      return;
    }
    alignas(64) float entry[kWidth];
    for (uint32_t bits = test_boxes(packet, group, entry); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<uint32_t>(__builtin_ctz(bits));
      test_box_hits(packet, lane, group, mask, [&](size_t i, uint32_t rays, auto t) {
        const auto zero = hn::Zero(DG());
        take_hits(instance, packet.child[lane], group, i, rays, t, zero, zero);
      });
      if (kAny) mask &= group.alive;
    }
  }

  HWY_INLINE void visit_boxes_singly(const Instance& instance, const Node8& packet, RayGroup& group,
                                     uint32_t k) {
    alignas(64) float entry[kWidth];
    for (uint32_t bits = test_boxes(packet, group, k, entry); bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      const Hit hit{entry[lane] + 0.0f, 0.0f, 0.0f, packet.child[lane], instance.object};
      if (!is_closer(hit, group.hit(k))) continue;
      if (is_asked(instance, options_) &&
          !options_.filter.accept(options_.filter.context, options_.first_ray + group.ray[k],
                                  hit)) {
        continue;
      }
      if (kAny) {
        group.alive &= ~(uint64_t{1} << k);
        return;
      }
      group.set_hit(k, hit);
    }
  }

  HWY_NOINLINE void visit_treelet(const Instance& instance, uint32_t treelet, RayGroup& group,
                                  uint64_t mask, size_t& top) {
    VisitedBody& body = *instance.body;
    uint32_t word = std::atomic_ref(body.bvh->links[treelet]).load(std::memory_order_acquire);
    if (word >= kBeingMade) word = sinew::visit_treelet(body, treelet);
    if (word == kNoChild) return resume_alone(instance, treelet_word(treelet), group, mask);
    stack_.push(top, {mask, 0.0f, word});
  }

  HWY_INLINE void visit_leaf(const Instance& instance, uint32_t word, float side, RayGroup& group,
                             uint64_t mask) {
    const uint32_t first = leaf_first(word), end = first + leaf_packets(word);
    if (are_few(mask)) {
      return visit_leaf_singly(instance, first, end, side, group, mask);
    }
    TrianglePacket room;
    for (uint32_t p = first; p != end; ++p) {
      const PacketPrimitives& primitives = instance.primitives[p];
      const TrianglePacket& packet = packet_of(instance, p, room);
      for (uint32_t lane = 0; lane < kPacket; ++lane) {
        if (primitives[lane] == kNoPrimitive) break;
        test_triangle(packet, lane, group, mask, side,
                      [&](size_t i, uint32_t bits, auto t, auto v, auto w) {
                        take_hits(instance, primitives[lane], group, i, bits, t, v, w);
                      });
        if (kAny) mask &= group.alive;
      }
    }
    if (!kAny) group.find_most_t();
  }

  HWY_INLINE void visit_leaf_singly(const Instance& instance, uint32_t first, uint32_t end,
                                    float side, RayGroup& group, uint64_t mask) {
    bool closer = false;
    TrianglePacket room;
    for (; mask != 0; mask &= mask - 1) {
      const auto k = static_cast<uint32_t>(__builtin_ctzll(mask));
      const Lone ray(group, k);
      for (uint32_t p = first; p != end; ++p) {
        PacketHits hits;
        test_packet(packet_of(instance, p, room), ray, group.t_min[k], group.t[k], side, hits);
        for (uint32_t bits = hits.bits; bits != 0; bits &= bits - 1) {
          const int lane = __builtin_ctz(bits);
          const Hit hit{hits.t[lane], hits.v[lane], hits.w[lane], instance.primitives[p][lane],
                        instance.object};
          if (hit.primitive == kNoPrimitive || !is_closer(hit, group.hit(k))) continue;
          if (is_asked(instance, options_) &&
              !options_.filter.accept(options_.filter.context, options_.first_ray + group.ray[k],
                                      hit)) {
            continue;
          }
          if (kAny) {
            group.alive &= ~(uint64_t{1} << k);
            p = end - 1;
            break;
          }
          group.set_hit(k, hit);
          closer = true;
        }
      }
    }
    if (closer) group.find_most_t();
  }

  // Hits of one triangle by the rays of one vector, the first of which is ray i of the group.
  template <class V>
  HWY_INLINE void take_hits(const Instance& instance, uint32_t primitive, RayGroup& group, size_t i,
                            uint32_t bits, V t, V v, V w) {
    if (HWY_UNLIKELY(is_asked(instance, options_))) {
      return filter_hits(instance, primitive, group, i, bits, t, v, w);
    }
    if constexpr (kAny) {
      group.alive &= ~(uint64_t{bits} << i);
    } else {
      const DG d;
      const DGu du;
      const auto best = hn::Load(d, group.t + i);
      const auto same_t = hn::Eq(t, best);
      if (HWY_UNLIKELY((mask_bits(d, same_t) & bits) != 0)) {
        // Of equal ones the least (object, primitive): rare, so ray by ray.
        return choose_hits(instance, primitive, group, i, bits, t, v, w);
      }
      const auto mask = load_mask(d, bits);
      const auto mask_u = load_mask(du, bits);
      hn::BlendedStore(t, mask, d, group.t + i);
      hn::BlendedStore(v, mask, d, group.v + i);
      hn::BlendedStore(w, mask, d, group.w + i);
      hn::BlendedStore(hn::Set(du, primitive), mask_u, du, group.primitive + i);
      hn::BlendedStore(hn::Set(du, instance.object), mask_u, du, group.object + i);
    }
  }

  template <class V>
  HWY_NOINLINE void choose_hits(const Instance& instance, uint32_t primitive, RayGroup& group,
                                size_t i, uint32_t bits, V t, V v, V w) {
    each_hit(instance, primitive, group, i, bits, t, v, w,
             [](uint32_t, const Hit&) { return true; });
  }
  template <class V>
  HWY_NOINLINE void filter_hits(const Instance& instance, uint32_t primitive, RayGroup& group,
                                size_t i, uint32_t bits, V t, V v, V w) {
    each_hit(instance, primitive, group, i, bits, t, v, w, [&](uint32_t ray, const Hit& hit) {
      return options_.filter.accept(options_.filter.context, options_.first_ray + ray, hit);
    });
  }
  template <class V, class Accept>
  HWY_INLINE void each_hit(const Instance& instance, uint32_t primitive, RayGroup& group, size_t i,
                           uint32_t bits, V t, V v, V w, const Accept& accept) {
    const DG d;
    alignas(64) float ts[kGroup], vs[kGroup], ws[kGroup];
    hn::Store(t, d, ts);
    hn::Store(v, d, vs);
    hn::Store(w, d, ws);
    for (; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<uint32_t>(__builtin_ctz(bits));
      const uint32_t k = static_cast<uint32_t>(i) + lane;
      const Hit hit{ts[lane], vs[lane], ws[lane], primitive, instance.object};
      if (!is_closer(hit, group.hit(k)) || !accept(group.ray[k], hit)) continue;
      if (kAny) group.alive &= ~(uint64_t{1} << k);
      if (!kAny) group.set_hit(k, hit);
    }
  }

  // What another thread is making is looked through for each ray.
  HWY_NOINLINE void visit_alone(const Instance& instance, RayGroup& group, uint64_t mask) {
    each_alone(group, mask, [&](Traversal<kAny, RaySetup>& ray, const Hit& best) {
      return ray.resume(instance, best);
    });
  }
  HWY_NOINLINE void resume_alone(const Instance& instance, uint32_t word, RayGroup& group,
                                 uint64_t mask) {
    each_alone(group, mask, [&](Traversal<kAny, RaySetup>& ray, const Hit& best) {
      return ray.resume(instance, word, best);
    });
  }
  template <class Trace>
  HWY_INLINE void each_alone(RayGroup& group, uint64_t mask, const Trace& trace) {
    for (; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<uint32_t>(__builtin_ctzll(mask));
      const uint32_t index = group.ray[i];
      Traversal<kAny, RaySetup> ray(scene_, options_, rays_[index], options_.first_ray + index);
      const Hit hit = trace(ray, group.hit(i));
      if (kAny && hit) group.alive &= ~(uint64_t{1} << i);
      if (!kAny) group.set_hit(i, hit);
    }
    group.find_most_t();
  }

  const SceneView& scene_;
  const QueryOptions& options_;
  const Ray* const rays_;
  GroupStack<kAny> stack_;
};

// Rays of a span are sorted this many at a time.
constexpr uint32_t kBlock = 2048;
constexpr uint32_t kRuns = kBlock / kGroup;

struct SortedBlock {
  uint16_t order[kBlock];
  uint32_t first[kGroupClasses + 2] = {};  // of every class in `order`; the last are untraceable

  // Without the runs of kGroup rays whose bits in `done` are set.
  HWY_INLINE SortedBlock(const Ray* rays, uint32_t count, uint32_t done) {
    uint8_t kind[kBlock];
    uint32_t next[kGroupClasses + 1] = {};
    const auto each = [&](const auto& visit) {
      for (uint32_t begin = 0; begin < count; begin += kGroup) {
        if (done >> (begin / kGroup) & 1) continue;
        for (uint32_t i = begin; i < std::min(begin + kGroup, count); ++i) visit(i);
      }
    };
    each([&](uint32_t i) {
      kind[i] = static_cast<uint8_t>(is_traceable(rays[i]) ? group_class(&rays[i].direction.x)
                                                           : kGroupClasses);
      ++next[kind[i]];
    });
    for (uint32_t k = 0; k <= kGroupClasses; ++k) {
      first[k + 1] = first[k] + next[k];
      next[k] = first[k];
    }
    each([&](uint32_t i) { order[next[kind[i]]++] = static_cast<uint16_t>(i); });
  }
};

// Fewer rays of a class are traced one by one.
constexpr uint32_t kLeastGroup = 4;

// Traces groups of a span and calls out(group) for each, and alone(index of the ray) for rays that
// are in none.
template <bool kAny, class Lone, class Out, class Alone>
class GroupedSpan {
 public:
  HWY_INLINE GroupedSpan(const SceneView& scene, const Ray* rays, const QueryOptions& options,
                         const Out& out, const Alone& alone)
      : rays_(rays), traversal_(scene, options, rays), out_(out), alone_(alone) {}

  HWY_INLINE void trace(size_t count) {
    for (size_t begin = 0; begin < count; begin += kBlock) {
      const auto end = static_cast<uint32_t>(std::min(count, begin + kBlock));
      const auto from = static_cast<uint32_t>(begin);
      // Where any hit will do, the larger groups of a sorted block are worth more.
      const uint32_t done = kAny ? 0 : trace_runs(from, end);
      const uint32_t runs = (end - from + kGroup - 1) / kGroup;
      if (static_cast<uint32_t>(__builtin_popcount(done)) != runs) trace_rest(from, end, done);
    }
  }

 private:
  // Neighbours that make a group as they stand; returns which runs did.
  HWY_INLINE uint32_t trace_runs(uint32_t begin, uint32_t end) {
    uint32_t done = 0;
    for (uint32_t run = 0; begin + (run + 1) * kGroup <= end; ++run) {
      RayGroup group;
      const uint32_t first = begin + run * kGroup;
      if (!group.add_run(rays_ + first, first)) continue;
      trace(group);
      done |= 1u << run;
    }
    return done;
  }

  HWY_INLINE void trace_rest(uint32_t begin, uint32_t end, uint32_t done) {
    const SortedBlock block(rays_ + begin, end - begin, done);
    for (uint32_t kind = 0; kind < kGroupClasses; ++kind) {
      for (uint32_t i = block.first[kind]; i < block.first[kind + 1];) {
        const uint32_t last = std::min(i + kGroup, block.first[kind + 1]);
        if (last - i < kLeastGroup) {
          for (; i < last; ++i) alone_(begin + block.order[i]);
          break;
        }
        RayGroup group;
        for (; i < last; ++i) {
          const uint32_t index = begin + block.order[i];
          const Ray& ray = rays_[index];
          group.add(&ray.origin.x, &ray.direction.x, ray.t_min, ray.t_max, index);
        }
        trace(group);
      }
    }
    for (uint32_t i = block.first[kGroupClasses]; i < block.first[kGroupClasses + 1]; ++i) {
      alone_(begin + block.order[i]);
    }
  }

  HWY_NOINLINE void trace(RayGroup& group) {
    group.clear_hits();
    traversal_.run(group);
    out_(group);
  }

  static_assert(kRuns <= 32, "bits of a mask");
  const Ray* const rays_;
  GroupTraversal<kAny, Lone> traversal_;
  const Out& out_;
  const Alone& alone_;
};

template <bool kAny, class Lone, class Out, class Alone>
HWY_INLINE void trace_groups(const SceneView& scene, const Ray* rays, size_t count,
                             const QueryOptions& options, const Out& out, const Alone& alone) {
  GroupedSpan<kAny, Lone, Out, Alone>(scene, rays, options, out, alone).trace(count);
}

void closest_hits_grouped_kernel(const SceneView& scene, const Ray* rays, Hit* hits, size_t count,
                                 const QueryOptions& options) {
  trace_groups<false, GroupRay>(
      scene, rays, count, options,
      [&](RayGroup& group) {
        group.finish();
        for (uint32_t i = 0; i < group.count; ++i) hits[group.ray[i]] = group.hit(i);
      },
      [&](uint32_t ray) {
        hits[ray] =
            Traversal<false, RaySetup>(scene, options, rays[ray], options.first_ray + ray).run();
      });
}

template <class Lone, class Setup>
void any_hits_in_groups(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                        const QueryOptions& options) {
  trace_groups<true, Lone>(
      scene, rays, count, options,
      [&](const RayGroup& group) {
        for (uint32_t i = 0; i < group.count; ++i) hit[group.ray[i]] = !(group.alive >> i & 1);
      },
      [&](uint32_t ray) {
        hit[ray] = static_cast<bool>(
            Traversal<true, Setup>(scene, options, rays[ray], options.first_ray + ray).run());
      });
}

void any_hits_grouped_kernel(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                             const QueryOptions& options) {
  const bool fast = options.precision == Precision::fast;
  const auto trace =
      fast ? any_hits_in_groups<FastGroupRay, FastSetup> : any_hits_in_groups<GroupRay, RaySetup>;
  trace(scene, rays, hit, count, options);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(closest_hits_grouped_kernel);
HWY_EXPORT(any_hits_grouped_kernel);

void closest_hits_grouped(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                          const QueryOptions& options) {
  HWY_DYNAMIC_DISPATCH(closest_hits_grouped_kernel)
  (scene, rays.data(), hits.data(), rays.size(), options);
}

void any_hits_grouped(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
                      const QueryOptions& options) {
  HWY_DYNAMIC_DISPATCH(any_hits_grouped_kernel)
  (scene, rays.data(), hit.data(), rays.size(), options);
}

}  // namespace sinew
#endif
