#include "bench/embree_calls.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "sinew/base/check.h"

namespace sinew::bench {
namespace {

constexpr uint32_t kStream = 256;  // rays a stream call gets, so that they stay in the L1 cache

using Float4 = float __attribute__((vector_size(16)));

void store(float* out, Float4 value) {
  std::memcpy(out, &value, sizeof(value));
}

// Four times four floats of consecutive structs become four of each member.
void transpose(const Float4 (&row)[4], float* const (&out)[4]) {
  const Float4 xy01 = __builtin_shufflevector(row[0], row[1], 0, 4, 1, 5);
  const Float4 xy23 = __builtin_shufflevector(row[2], row[3], 0, 4, 1, 5);
  const Float4 zw01 = __builtin_shufflevector(row[0], row[1], 2, 6, 3, 7);
  const Float4 zw23 = __builtin_shufflevector(row[2], row[3], 2, 6, 3, 7);
  store(out[0], __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5));
  store(out[1], __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7));
  store(out[2], __builtin_shufflevector(zw01, zw23, 0, 1, 4, 5));
  store(out[3], __builtin_shufflevector(zw01, zw23, 2, 3, 6, 7));
}

// Where the members of many rays, and of their hits, stand.
struct RayArrays {
  float *org_x, *org_y, *org_z, *tnear, *dir_x, *dir_y, *dir_z, *tfar;
};
struct HitArrays {
  const float *t, *u, *v;
  const uint32_t *primitive, *geometry, *instance;
};

// Carries over a multiple of four rays.
void load_rays(const Ray* rays, uint32_t count, const RayArrays& out) {
  for (uint32_t i = 0; i < count; i += 4) {
    Float4 first[4], second[4];
    for (uint32_t k = 0; k < 4; ++k) {
      std::memcpy(&first[k], &rays[i + k].origin, sizeof(Float4));
      std::memcpy(&second[k], &rays[i + k].direction, sizeof(Float4));
    }
    transpose(first, {out.org_x + i, out.org_y + i, out.org_z + i, out.tnear + i});
    transpose(second, {out.dir_x + i, out.dir_y + i, out.dir_z + i, out.tfar + i});
  }
}

void store_hits(const HitArrays& from, std::span<Hit> hits) {
  for (size_t i = 0; i < hits.size(); ++i) {
    if (from.geometry[i] == RTC_INVALID_GEOMETRY_ID) {
      hits[i] = Hit();
      continue;
    }
    const uint32_t instance = from.instance[i];
    hits[i] = {from.t[i], from.u[i], from.v[i], from.primitive[i],
               instance != RTC_INVALID_GEOMETRY_ID ? instance : from.geometry[i]};
  }
}

void store_occluded(const float* tfar, std::span<uint8_t> hit) {
  for (size_t i = 0; i < hit.size(); ++i) hit[i] = tfar[i] < 0.0f;
}

RTCIntersectContext make_context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

RTCRay embree_ray(const Ray& ray) {
  return {ray.origin.x,
          ray.origin.y,
          ray.origin.z,
          ray.t_min,
          ray.direction.x,
          ray.direction.y,
          ray.direction.z,
          0.0f,
          ray.t_max,
          0xffffffffu,
          0,
          0};
}

void closest_single(RTCScene scene, std::span<const Ray> rays, std::span<Hit> hits) {
  RTCIntersectContext context = make_context(false);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRayHit query;
    query.ray = embree_ray(rays[i]);
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &query);
    const RTCHit& hit = query.hit;
    store_hits({&query.ray.tfar, &hit.u, &hit.v, &hit.primID, &hit.geomID, &hit.instID[0]},
               hits.subspan(i, 1));
  }
}

void any_single(RTCScene scene, std::span<const Ray> rays, std::span<uint8_t> hit) {
  RTCIntersectContext context = make_context(false);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRay query = embree_ray(rays[i]);
    rtcOccluded1(scene, &context, &query);
    hit[i] = query.tfar < 0.0f;
  }
}

struct Packets8 {
  static constexpr uint32_t kLanes = 8;
  using RayType = RTCRay8;
  using RayHitType = RTCRayHit8;
  static constexpr auto intersect = rtcIntersect8;
  static constexpr auto occluded = rtcOccluded8;
};
struct Packets16 {
  static constexpr uint32_t kLanes = 16;
  using RayType = RTCRay16;
  using RayHitType = RTCRayHit16;
  static constexpr auto intersect = rtcIntersect16;
  static constexpr auto occluded = rtcOccluded16;
};

template <class RayType>
RayArrays arrays_of(RayType& ray) {
  return {ray.org_x, ray.org_y, ray.org_z, ray.tnear, ray.dir_x, ray.dir_y, ray.dir_z, ray.tfar};
}

template <class RayType, size_t kLanes>
void set_constant(RayType& ray, int (&valid)[kLanes]) {
  std::ranges::fill(ray.time, 0.0f);
  std::ranges::fill(ray.mask, 0xffffffffu);
  std::ranges::fill(ray.id, 0u);
  std::ranges::fill(ray.flags, 0u);
  std::ranges::fill(valid, -1);
}

// Calls take(first, count, rays) for packets of kLanes rays; the last is filled up with copies of
// its first ray, and its `valid` words say so.
template <uint32_t kLanes>
void for_each_packet(std::span<const Ray> rays, int (&valid)[kLanes], const auto& take) {
  size_t i = 0;
  for (; i + kLanes <= rays.size(); i += kLanes) take(i, kLanes, rays.data() + i);
  if (i == rays.size()) return;
  const auto count = static_cast<uint32_t>(rays.size() - i);
  std::array<Ray, kLanes> last;
  last.fill(rays[i]);
  std::copy_n(rays.begin() + static_cast<std::ptrdiff_t>(i), count, last.begin());
  std::fill(valid + count, valid + kLanes, 0);
  take(i, count, last.data());
}

template <class Packets>
void closest_packets(RTCScene scene, bool coherent, std::span<const Ray> rays,
                     std::span<Hit> hits) {
  constexpr uint32_t kLanes = Packets::kLanes;
  RTCIntersectContext context = make_context(coherent);
  alignas(64) int valid[kLanes];
  typename Packets::RayHitType query;
  set_constant(query.ray, valid);
  for_each_packet<kLanes>(rays, valid, [&](size_t first, uint32_t count, const Ray* from) {
    load_rays(from, kLanes, arrays_of(query.ray));
    std::ranges::fill(query.hit.geomID, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(query.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
    Packets::intersect(valid, scene, &context, &query);
    store_hits({query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID, query.hit.geomID,
                query.hit.instID[0]},
               hits.subspan(first, count));
  });
}

template <class Packets>
void any_packets(RTCScene scene, bool coherent, std::span<const Ray> rays, std::span<uint8_t> hit) {
  constexpr uint32_t kLanes = Packets::kLanes;
  RTCIntersectContext context = make_context(coherent);
  alignas(64) int valid[kLanes];
  typename Packets::RayType query;
  set_constant(query, valid);
  for_each_packet<kLanes>(rays, valid, [&](size_t first, uint32_t count, const Ray* from) {
    load_rays(from, kLanes, arrays_of(query));
    Packets::occluded(valid, scene, &context, &query);
    store_occluded(query.tfar, hit.subspan(first, count));
  });
}

// Streams as arrays of structs.
void closest_stream(RTCScene scene, std::span<const Ray> rays, std::span<Hit> hits) {
  RTCIntersectContext context = make_context(false);
  std::array<RTCRayHit, kStream> queries;
  for (size_t first = 0; first < rays.size(); first += kStream) {
    const size_t count = std::min<size_t>(kStream, rays.size() - first);
    for (size_t i = 0; i < count; ++i) {
      queries[i].ray = embree_ray(rays[first + i]);
      queries[i].hit.geomID = queries[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene, &context, queries.data(), static_cast<unsigned>(count),
                   sizeof(RTCRayHit));
    for (size_t i = 0; i < count; ++i) {
      const RTCHit& hit = queries[i].hit;
      store_hits({&queries[i].ray.tfar, &hit.u, &hit.v, &hit.primID, &hit.geomID, &hit.instID[0]},
                 hits.subspan(first + i, 1));
    }
  }
}

void any_stream(RTCScene scene, std::span<const Ray> rays, std::span<uint8_t> hit) {
  RTCIntersectContext context = make_context(false);
  std::array<RTCRay, kStream> queries;
  for (size_t first = 0; first < rays.size(); first += kStream) {
    const size_t count = std::min<size_t>(kStream, rays.size() - first);
    for (size_t i = 0; i < count; ++i) queries[i] = embree_ray(rays[first + i]);
    rtcOccluded1M(scene, &context, queries.data(), static_cast<unsigned>(count), sizeof(RTCRay));
    for (size_t i = 0; i < count; ++i) hit[first + i] = queries[i].tfar < 0.0f;
  }
}

// Streams as structs of arrays, which Embree prefers for coherent rays.
struct StreamArrays {
  alignas(64) float ray[8][kStream];
  alignas(64) float time[kStream];
  alignas(64) uint32_t mask[kStream], id[kStream], flags[kStream];
  alignas(64) float normal[3][kStream], u[kStream], v[kStream];
  alignas(64) uint32_t primitive[kStream], geometry[kStream], instance[kStream];

  StreamArrays() {
    std::ranges::fill(time, 0.0f);
    std::ranges::fill(mask, 0xffffffffu);
    std::ranges::fill(id, 0u);
    std::ranges::fill(flags, 0u);
  }
  RayArrays arrays() { return {ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], ray[6], ray[7]}; }
  RTCRayNp rays() {
    return {ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], ray[6], time, ray[7], mask, id, flags};
  }
  RTCRayHitNp queries() {
    return {rays(), {normal[0], normal[1], normal[2], u, v, primitive, geometry, {instance}}};
  }
};

// Calls take(first, count) with the arrays holding these rays.
void for_each_stream(std::span<const Ray> rays, StreamArrays& arrays, const auto& take) {
  for (size_t first = 0; first < rays.size(); first += kStream) {
    const size_t count = std::min<size_t>(kStream, rays.size() - first);
    const auto whole = static_cast<uint32_t>(count / 4 * 4);
    RayArrays out = arrays.arrays();
    load_rays(rays.data() + first, whole, out);
    if (whole < count) {
      std::array<Ray, 4> last;
      last.fill(rays[first + whole]);
      std::copy_n(rays.data() + first + whole, count - whole, last.begin());
      for (float** part : {&out.org_x, &out.org_y, &out.org_z, &out.tnear, &out.dir_x, &out.dir_y,
                           &out.dir_z, &out.tfar}) {
        *part += whole;
      }
      load_rays(last.data(), 4, out);
    }
    take(first, static_cast<unsigned>(count));
  }
}

void closest_stream_coherent(RTCScene scene, std::span<const Ray> rays, std::span<Hit> hits) {
  RTCIntersectContext context = make_context(true);
  StreamArrays arrays;
  const RTCRayHitNp queries = arrays.queries();
  for_each_stream(rays, arrays, [&](size_t first, unsigned count) {
    std::ranges::fill(arrays.geometry, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(arrays.instance, RTC_INVALID_GEOMETRY_ID);
    rtcIntersectNp(scene, &context, &queries, count);
    store_hits(
        {arrays.ray[7], arrays.u, arrays.v, arrays.primitive, arrays.geometry, arrays.instance},
        hits.subspan(first, count));
  });
}

void any_stream_coherent(RTCScene scene, std::span<const Ray> rays, std::span<uint8_t> hit) {
  RTCIntersectContext context = make_context(true);
  StreamArrays arrays;
  const RTCRayNp queries = arrays.rays();
  for_each_stream(rays, arrays, [&](size_t first, unsigned count) {
    rtcOccludedNp(scene, &context, &queries, count);
    store_occluded(arrays.ray[7], hit.subspan(first, count));
  });
}

}  // namespace

const char* name_of(EmbreeCall call) {
  constexpr const char* kNames[] = {
      "1", "8", "16", "8 coherent", "16 coherent", "stream", "stream coherent"};
  return kNames[static_cast<size_t>(call)];
}

void closest_hits(const EmbreeScene& scene, EmbreeCall call, std::span<const Ray> rays,
                  std::span<Hit> hits) {
  SINEW_CHECK(rays.size() == hits.size());
  const RTCScene s = scene.handle();
  switch (call) {
    case EmbreeCall::single:
      return closest_single(s, rays, hits);
    case EmbreeCall::packet8:
    case EmbreeCall::packet8_coherent:
      return closest_packets<Packets8>(s, call == EmbreeCall::packet8_coherent, rays, hits);
    case EmbreeCall::packet16:
    case EmbreeCall::packet16_coherent:
      return closest_packets<Packets16>(s, call == EmbreeCall::packet16_coherent, rays, hits);
    case EmbreeCall::stream:
      return closest_stream(s, rays, hits);
    case EmbreeCall::stream_coherent:
      return closest_stream_coherent(s, rays, hits);
  }
}

void any_hits(const EmbreeScene& scene, EmbreeCall call, std::span<const Ray> rays,
              std::span<uint8_t> hit) {
  SINEW_CHECK(rays.size() == hit.size());
  const RTCScene s = scene.handle();
  switch (call) {
    case EmbreeCall::single:
      return any_single(s, rays, hit);
    case EmbreeCall::packet8:
    case EmbreeCall::packet8_coherent:
      return any_packets<Packets8>(s, call == EmbreeCall::packet8_coherent, rays, hit);
    case EmbreeCall::packet16:
    case EmbreeCall::packet16_coherent:
      return any_packets<Packets16>(s, call == EmbreeCall::packet16_coherent, rays, hit);
    case EmbreeCall::stream:
      return any_stream(s, rays, hit);
    case EmbreeCall::stream_coherent:
      return any_stream_coherent(s, rays, hit);
  }
}

}  // namespace sinew::bench
