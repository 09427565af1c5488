#include "bench/embree_scene.h"

#include <algorithm>

#include "bench/embree_calls.h"
#include "sinew/base/check.h"

namespace sinew::bench {
namespace {

bool count_bytes(void* counter, ssize_t bytes, bool) {
  static_cast<std::atomic<int64_t>*>(counter)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

bool is_dynamic(EmbreeMode mode) {
  return mode == EmbreeMode::refit || mode == EmbreeMode::low;
}

RTCBuildQuality scene_quality(EmbreeMode mode) {
  if (is_dynamic(mode)) return RTC_BUILD_QUALITY_LOW;
  return mode == EmbreeMode::high ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
}

RTCSceneFlags scene_flags(const EmbreeConfig& config) {
  int flags = RTC_SCENE_FLAG_NONE;
  if (config.robust) flags |= RTC_SCENE_FLAG_ROBUST;
  if (is_dynamic(config.mode)) flags |= RTC_SCENE_FLAG_DYNAMIC;
  return static_cast<RTCSceneFlags>(flags);
}

RTCBuildQuality geometry_quality(EmbreeMode mode, EmbreeMotion motion) {
  if (motion == EmbreeMotion::still || !is_dynamic(mode)) return RTC_BUILD_QUALITY_MEDIUM;
  return mode == EmbreeMode::refit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW;
}

void set_placement(RTCGeometry instance, const Affine& placement) {
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &placement[0].x);
}

}  // namespace

EmbreeScene::EmbreeScene(const EmbreeConfig& config)
    : config_(config), device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
  rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, &bytes_);
  rtcSetSceneFlags(scene_, scene_flags(config));
  rtcSetSceneBuildQuality(scene_, scene_quality(config.mode));
}

EmbreeScene::EmbreeScene(std::span<const vec3> positions, std::span<const uvec3> triangles,
                         EmbreeMode mode)
    : EmbreeScene(EmbreeConfig{.mode = mode}) {
  add_mesh(positions, triangles, EmbreeMotion::deforms);
  commit();
}

EmbreeScene::~EmbreeScene() {
  for (const Geometry& geometry : geometries_) rtcReleaseGeometry(geometry.handle);
  for (const Geometry& shape : shapes_) rtcReleaseGeometry(shape.handle);
  rtcReleaseScene(scene_);
  for (const RTCScene shape : shape_scenes_) rtcReleaseScene(shape);
  rtcReleaseDevice(device_);
}

EmbreeScene::Geometry EmbreeScene::make_mesh(std::span<const vec3> positions,
                                             std::span<const uvec3> triangles,
                                             RTCBuildQuality quality) {
  Geometry out;
  out.handle = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryBuildQuality(out.handle, quality);
  out.vertices.resize(positions.size() + 1);
  std::ranges::copy(positions, out.vertices.begin());
  rtcSetSharedGeometryBuffer(out.handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             out.vertices.data(), 0, sizeof(vec3), positions.size());
  rtcSetSharedGeometryBuffer(out.handle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             triangles.data(), 0, sizeof(uvec3), triangles.size());
  rtcCommitGeometry(out.handle);
  return out;
}

uint32_t EmbreeScene::attach(Geometry geometry) {
  const auto number = static_cast<uint32_t>(geometries_.size());
  rtcAttachGeometryByID(scene_, geometry.handle, number);
  geometries_.push_back(std::move(geometry));
  return number;
}

uint32_t EmbreeScene::add_mesh(std::span<const vec3> positions, std::span<const uvec3> triangles,
                               EmbreeMotion motion) {
  return attach(make_mesh(positions, triangles, geometry_quality(config_.mode, motion)));
}

uint32_t EmbreeScene::add_shape(std::span<const vec3> positions, std::span<const uvec3> triangles) {
  Geometry mesh = make_mesh(positions, triangles, RTC_BUILD_QUALITY_MEDIUM);
  const RTCScene scene = rtcNewScene(device_);
  rtcSetSceneFlags(scene, config_.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  rtcAttachGeometry(scene, mesh.handle);
  rtcCommitScene(scene);
  shapes_.push_back(std::move(mesh));
  shape_scenes_.push_back(scene);
  return static_cast<uint32_t>(shapes_.size() - 1);
}

uint32_t EmbreeScene::add_instance(uint32_t shape, const Affine& placement) {
  SINEW_CHECK(shape < shapes_.size());
  Geometry instance;
  instance.handle = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance.handle, shape_scenes_[shape]);
  set_placement(instance.handle, placement);
  rtcCommitGeometry(instance.handle);
  return attach(std::move(instance));
}

std::span<vec3> EmbreeScene::vertices(uint32_t geometry) {
  Geometry& mesh = geometries_[geometry];
  mesh.changed = true;
  return std::span(mesh.vertices).first(mesh.vertices.size() - 1);
}

void EmbreeScene::place(uint32_t instance, const Affine& placement) {
  set_placement(geometries_[instance].handle, placement);
  geometries_[instance].changed = true;
}

void EmbreeScene::set_present(uint32_t geometry, bool present) {
  Geometry& which = geometries_[geometry];
  if (which.present == present) return;
  which.present = present;
  present ? rtcEnableGeometry(which.handle) : rtcDisableGeometry(which.handle);
}

void EmbreeScene::commit() {
  for (Geometry& geometry : geometries_) {
    if (!geometry.changed) continue;
    geometry.changed = false;
    if (!geometry.vertices.empty()) {
      rtcUpdateGeometryBuffer(geometry.handle, RTC_BUFFER_TYPE_VERTEX, 0);
    }
    rtcCommitGeometry(geometry.handle);
  }
  rtcCommitScene(scene_);
}

void EmbreeScene::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
  bench::closest_hits(*this, EmbreeCall::single, rays, hits);
}

void EmbreeScene::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const {
  bench::any_hits(*this, EmbreeCall::single, rays, hit);
}

}  // namespace sinew::bench
