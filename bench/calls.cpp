#include "bench/calls.h"

#include "bench/embree_calls.h"
#include "sinew/base/parallel.h"

namespace sinew::bench {
namespace {

constexpr size_t kRaysPerTask = 1024;

Call our_call(const Bvh& bvh, const char* name, const QueryOptions& options) {
  return {name, [&bvh, options](auto rays, auto hits) { bvh.closest_hits(rays, hits, options); },
          [&bvh, options](auto rays, auto hit) { bvh.any_hits(rays, hit, options); }};
}

}  // namespace

const char* name_of(TriangleTest test) {
  return test == TriangleTest::robust ? "robust" : "fast";
}

std::vector<Call> our_calls(const Bvh& bvh, TriangleTest test) {
  std::vector<Call> calls;
  const Precision precision =
      test == TriangleTest::robust ? Precision::watertight : Precision::fast;
  calls.push_back(our_call(bvh, kOurSingle, {.grouping = Grouping::none, .precision = precision}));
  calls.push_back(our_call(bvh, kOurGroups, {.precision = precision}));
  return calls;
}

std::vector<Call> embree_calls(const EmbreeScene& scene) {
  std::vector<Call> calls;
  for (const EmbreeCall call : kEmbreeCalls) {
    calls.push_back(
        {std::string("embree ") + name_of(call),
         [&scene, call](auto rays, auto hits) { closest_hits(scene, call, rays, hits); },
         [&scene, call](auto rays, auto hit) { any_hits(scene, call, rays, hit); }});
  }
  return calls;
}

void trace_closest(const Call& call, std::span<const Ray> rays, std::span<Hit> hits) {
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    call.closest(rays.subspan(begin, end - begin), hits.subspan(begin, end - begin));
  });
}

void trace_any(const Call& call, std::span<const Ray> rays, std::span<uint8_t> hit) {
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    call.any(rays.subspan(begin, end - begin), hit.subspan(begin, end - begin));
  });
}

}  // namespace sinew::bench
