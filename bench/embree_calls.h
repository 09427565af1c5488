// Every way in which Embree 3 takes rays: one a call, packets of 8 and 16, and streams.
// Rays come in and hits go out in our own compact form, for both opponents alike; they are carried
// over in registers, a few cycles a ray.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "bench/embree_scene.h"
#include "sinew/math/ray.h"

namespace sinew::bench {

enum class EmbreeCall : uint8_t {
  single,            // rtcIntersect1, rtcOccluded1
  packet8,           // rtcIntersect8, rtcOccluded8
  packet16,          // rtcIntersect16, rtcOccluded16
  packet8_coherent,  // the same with RTC_INTERSECT_CONTEXT_FLAG_COHERENT
  packet16_coherent,
  stream,           // rtcIntersect1M, rtcOccluded1M
  stream_coherent,  // rtcIntersectNp, rtcOccludedNp, with the flag
};
inline constexpr std::array kEmbreeCalls = {
    EmbreeCall::single,           EmbreeCall::packet8,           EmbreeCall::packet16,
    EmbreeCall::packet8_coherent, EmbreeCall::packet16_coherent, EmbreeCall::stream,
    EmbreeCall::stream_coherent};
const char* name_of(EmbreeCall call);

// In the calling thread. Hit::object is the number of the geometry or instance.
void closest_hits(const EmbreeScene& scene, EmbreeCall call, std::span<const Ray> rays,
                  std::span<Hit> hits);
void any_hits(const EmbreeScene& scene, EmbreeCall call, std::span<const Ray> rays,
              std::span<uint8_t> hit);

}  // namespace sinew::bench
