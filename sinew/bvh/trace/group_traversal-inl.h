// Closest-hit and any-hit traversal of Bvh8 hierarchies for a group of rays. Where few of them are
// left, each goes on alone. Included once per target.
#if defined(SINEW_BVH_GROUP_TRAVERSAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_GROUP_TRAVERSAL_INL_H_
#undef SINEW_BVH_GROUP_TRAVERSAL_INL_H_
#else
#define SINEW_BVH_GROUP_TRAVERSAL_INL_H_
#endif

#include <utility>

#include "sinew/bvh/trace/group_stack-inl.h"
#include "sinew/bvh/trace/group_triangles-inl.h"
#include "sinew/bvh/trace/ray_group-inl.h"
#include "sinew/bvh/trace/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// So few rays a vector are tested one by one: it costs less than tests of mostly idle lanes. Where
// any hit is sought, that takes no branches.
constexpr uint32_t kSinglyPerVector = 3, kSinglyPerVectorAny = 12;
// So few rays a vector are tested against packets rather than triangles.
constexpr uint32_t kFewPerVector = static_cast<uint32_t>(hn::MaxLanes(DG())) * 3 / 4;

HWY_INLINE bool are_few(uint64_t rays, uint32_t per_vector = kSinglyPerVector) {
  const auto count = static_cast<uint32_t>(__builtin_popcountll(rays));
  return count <= per_vector * count_vectors(rays);
}

// `Triangles` is how triangles are tested that few rays reach: see group_triangles-inl.h.
template <bool kAny, class Triangles = WatertightTriangles>
class GroupTraversal {
 public:
  GroupTraversal(const SceneView& scene, const QueryOptions& options, const Ray* rays)
      : scene_(scene), options_(options), rays_(rays) {}

  void run(RayGroup& group) {
    group.prepare<Triangles>();
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
      local.prepare<Triangles>();
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
      if (!is_closer(hit, group.hit(k)) || !accepts(instance, group, k, hit)) continue;
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
    const uint32_t first = leaf_first(word), count = leaf_packets(word);
    if (!kAny) __builtin_prefetch(&instance.primitives[first]);
    TrianglePacket room[kMaxLeafPackets];
    const TrianglePacket* const packets = packets_of(instance, first, count, room);
    if (are_few(mask, kFewPerVector)) {
      return visit_leaf_by_packets(instance, packets, first, count, side, group, mask);
    }
    for (uint32_t p = 0; p < count; ++p) {
      const PacketPrimitives& primitives = instance.primitives[first + p];
      for (uint32_t lane = 0; lane < kPacket; ++lane) {
        if (primitives[lane] == kNoPrimitive) break;
        test_triangle(packets[p], lane, group, mask, side,
                      [&](size_t i, uint32_t bits, auto t, auto v, auto w) {
                        take_hits(instance, primitives[lane], group, i, bits, t, v, w);
                      });
        if (kAny) mask &= group.alive;
      }
    }
    if (!kAny) group.find_most_t();
  }

  HWY_INLINE void visit_leaf_by_packets(const Instance& instance, const TrianglePacket* packets,
                                        uint32_t first, uint32_t count, float side, RayGroup& group,
                                        uint64_t mask) {
    const DG d;
    bool closer = false;
    while (mask != 0) {
      const FewRays few(mask);
      const auto rays = Triangles::lanes_of(group, few);
      uint32_t open = few.lanes();
      for (uint32_t p = 0; p < count && open != 0; ++p) {
        PacketHits<DG> hits;
        test_packet(d, packets[p], rays, load_each(group.t, few), side, hits);
        hits.bits &= open;
        if (hits.bits == 0) continue;
        take_hits(instance, first + p, few, hits, group, open);
        closer = true;
      }
    }
    if (!kAny && closer) group.find_most_t();
  }

  HWY_INLINE static const TrianglePacket* packets_of(const Instance& instance, uint32_t first,
                                                     uint32_t count, TrianglePacket* room) {
    if (instance.packets != nullptr) return instance.packets + first;
    for (uint32_t p = 0; p < count; ++p) {
      const PacketCorners& corners = instance.corners[first + p];
      pack_triangles(corners, instance.vertices + corners.place, room[p]);
    }
    return room;
  }

  // `open`: lanes of the rays that still seek a hit.
  HWY_INLINE void take_hits(const Instance& instance, uint32_t packet, const FewRays& few,
                            const PacketHits<DG>& hits, RayGroup& group, uint32_t& open) {
    for (uint32_t bits = hits.bits; bits != 0;) {
      const auto lane = static_cast<uint32_t>(__builtin_ctz(bits));
      const uint32_t k = few.ray_of(lane);
      bits &= bits - 1;
      if (!kAny || is_asked(instance, options_)) {
        const Hit hit{hits.t[lane], hits.v[lane], hits.w[lane],
                      instance.primitives[packet][lane % kLanesARay], instance.object};
        if (hit.primitive == kNoPrimitive || !is_closer(hit, group.hit(k))) continue;
        if (!accepts(instance, group, k, hit)) continue;
        if (!kAny) group.set_hit(k, hit);
      }
      if (kAny) {
        group.alive &= ~(uint64_t{1} << k);
        open &= ~FewRays::lanes_with(lane);
        bits &= open;
      }
    }
  }

  HWY_INLINE bool accepts(const Instance& instance, const RayGroup& group, uint32_t k,
                          const Hit& hit) const {
    return !is_asked(instance, options_) ||
           options_.filter.accept(options_.filter.context, options_.first_ray + group.ray[k], hit);
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

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
