// Cameras: rays through pixels, and the camera that sees a whole box.
#include "sinew/render/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "sinew/base/check.h"

namespace sinew {
namespace {

// A frame that looks from `eye` along -back; `up` decides the roll unless it is parallel.
Affine camera_frame(vec3 eye, vec3 back, vec3 up) {
  const float length_back = length(back);
  const vec3 z = length_back > 0.0f ? back / length_back : vec3(0.0f, 0.0f, 1.0f);
  vec3 x = cross(up, z);
  if (!(dot(x, x) > 1e-12f * dot(up, up))) {
    x = cross(std::abs(z.z) < 0.9f ? vec3(0.0f, 0.0f, -1.0f) : vec3(1.0f, 0.0f, 0.0f), z);
  }
  x = normalize(x);
  return Affine(x, cross(z, x), z, eye);
}

}  // namespace

CameraRays::CameraRays(const CameraView& camera, uint32_t width, uint32_t height)
    : camera_(camera), center_(0.5f * vec2(width, height)) {
  const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
  pixel_ = 2.0f * half_height / static_cast<float>(height);
}

Ray CameraRays::operator()(float x, float y) const {
  const vec2 on_plane((x - center_.x) * pixel_, (center_.y - y) * pixel_);
  Ray ray;
  if (camera_.orthographic) {
    ray.origin = transform_point(camera_.to_world, vec3(on_plane, 0.0f));
    ray.direction = -camera_.to_world[2];
    ray.t_min = camera_.znear;
    return ray;
  }
  const vec3 local(on_plane, -1.0f);
  const float stretch = length(local);  // of the ray, per unit of depth
  ray.origin = camera_.to_world[3];
  ray.direction = transform_vector(camera_.to_world, local / stretch);
  ray.t_min = camera_.znear * stretch;
  return ray;
}

Ray camera_ray(const CameraView& camera, float x, float y, uint32_t width, uint32_t height) {
  return CameraRays(camera, width, height)(x, y);
}

mat4 clip_from_world(const CameraView& camera, float aspect) {
  constexpr float kNearest = 1e-4f;
  const float near = std::max(camera.znear, kNearest);
  const mat4 view(inverse_affine(camera.to_world));
  if (!camera.orthographic) return glm::infinitePerspective(camera.yfov, aspect, near) * view;
  mat4 projection(1.0f);
  projection[0][0] = 1.0f / (camera.ymag * aspect);
  projection[1][1] = 1.0f / camera.ymag;
  projection[2][2] = -1.0f;
  projection[3][2] = -1.0f - near;  // -1 on the near plane
  return projection * view;
}

CameraView scene_camera(const Scene& scene, const ScenePose& pose, uint32_t index) {
  SINEW_CHECK(index < scene.cameras.size() && pose.nodes.size() == scene.nodes.size());
  const Camera& camera = scene.cameras[index];
  CameraView view;
  view.orthographic = camera.orthographic;
  view.yfov = camera.yfov;
  view.ymag = camera.ymag;
  view.znear = camera.znear;
  const auto node = std::find_if(scene.nodes.begin(), scene.nodes.end(), [&](const Node& n) {
    return n.camera == static_cast<int32_t>(index);
  });
  if (node != scene.nodes.end()) {
    // A camera ignores the scale of the nodes above it.
    const Affine& m = pose.nodes[static_cast<size_t>(node - scene.nodes.begin())];
    view.to_world = camera_frame(m[3], m[2], m[1]);
  }
  return view;
}

CameraView look_at(vec3 eye, vec3 target, vec3 up, float yfov) {
  CameraView view;
  view.to_world = camera_frame(eye, eye - target, up);
  view.yfov = yfov;
  return view;
}

CameraView frame_box(const Box& box, vec3 direction, float yfov, float aspect) {
  constexpr float kMargin = 1.05f;
  CameraView view;
  view.yfov = yfov;
  const vec3 center = box.empty() ? vec3(0.0f) : box.center();
  const vec3 half = box.empty() ? vec3(1.0f) : 0.5f * box.extent();
  view.to_world = camera_frame(center, direction, vec3(0.0f, 1.0f, 0.0f));
  const float tan_y = std::tan(0.5f * yfov) / kMargin, tan_x = tan_y * aspect;

  // A corner at (x, y, z) from the centre, z towards the eye, is in view if the eye is at least
  // |x| / tan_x (and |y| / tan_y) further away than z.
  float distance = 0.0f;
  for (int i = 0; i < 8; ++i) {
    const vec3 corner =
        half * vec3(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
    const float x = std::abs(dot(corner, view.to_world[0]));
    const float y = std::abs(dot(corner, view.to_world[1]));
    const float z = dot(corner, view.to_world[2]);
    distance = std::max({distance, z + x / tan_x, z + y / tan_y});
  }
  if (!(distance > 0.0f)) distance = 1.0f;
  view.to_world[3] = center + view.to_world[2] * distance;
  return view;
}

}  // namespace sinew
