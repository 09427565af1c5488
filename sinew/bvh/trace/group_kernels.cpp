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

#include "sinew/bvh/trace/group_traversal-inl.h"
#include "sinew/bvh/trace/query_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

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
template <bool kAny, class Triangles, class Out, class Alone>
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
  GroupTraversal<kAny, Triangles> traversal_;
  const Out& out_;
  const Alone& alone_;
};

template <bool kAny, class Triangles, class Out, class Alone>
HWY_INLINE void trace_groups(const SceneView& scene, const Ray* rays, size_t count,
                             const QueryOptions& options, const Out& out, const Alone& alone) {
  GroupedSpan<kAny, Triangles, Out, Alone>(scene, rays, options, out, alone).trace(count);
}

void closest_hits_grouped_kernel(const SceneView& scene, const Ray* rays, Hit* hits, size_t count,
                                 const QueryOptions& options) {
  trace_groups<false, WatertightTriangles>(
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

template <class Triangles, class Setup>
void any_hits_in_groups(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                        const QueryOptions& options) {
  trace_groups<true, Triangles>(
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
  const auto trace = fast ? any_hits_in_groups<FastTriangles, FastSetup>
                          : any_hits_in_groups<WatertightTriangles, RaySetup>;
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
