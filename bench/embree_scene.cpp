#include "bench/embree_scene.h"

#include <algorithm>
#include <limits>

namespace sinew::bench {

EmbreeScene::EmbreeScene(std::span<const vec3> positions, std::span<const uvec3> triangles,
                         EmbreeMode mode)
    : device_(rtcNewDevice(nullptr)),
      scene_(rtcNewScene(device_)),
      geometry_(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE)),
      vertex_count_(positions.size()) {
  const bool refit = mode == EmbreeMode::refit;
  rtcSetSceneFlags(
      scene_, refit ? static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC)
                    : RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_, refit ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  rtcSetGeometryBuildQuality(geometry_, refit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_MEDIUM);
  vertices_ = static_cast<vec3*>(rtcSetNewGeometryBuffer(
      geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), positions.size()));
  auto* const indices = static_cast<uvec3*>(rtcSetNewGeometryBuffer(
      geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), triangles.size()));
  std::copy(positions.begin(), positions.end(), vertices_);
  std::copy(triangles.begin(), triangles.end(), indices);
  rtcCommitGeometry(geometry_);
  rtcAttachGeometry(scene_, geometry_);
  rtcCommitScene(scene_);
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseGeometry(geometry_);
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

std::span<vec3> EmbreeScene::vertices() {
  return {vertices_, vertex_count_};
}

void EmbreeScene::commit() {
  rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry_);
  rtcCommitScene(scene_);
}

static RTCRay embree_ray(const Ray& ray) {
  RTCRay out;
  out.org_x = ray.origin.x;
  out.org_y = ray.origin.y;
  out.org_z = ray.origin.z;
  out.tnear = ray.t_min;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.time = 0;
  out.tfar = ray.t_max;
  out.mask = 0xffffffffu;
  out.id = 0;
  out.flags = 0;
  return out;
}

void EmbreeScene::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRayHit query;
    query.ray = embree_ray(rays[i]);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    hits[i] = Hit();
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    hits[i] = {query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID, 0};
  }
}

void EmbreeScene::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRay query = embree_ray(rays[i]);
    rtcOccluded1(scene_, &context, &query);
    hit[i] = query.tfar < 0;
  }
}

}  // namespace sinew::bench
