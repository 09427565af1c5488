// The camera of one frame, and rays through its pixels.
#pragma once

#include <optional>

#include "sinew/math/affine.h"
#include "sinew/math/box.h"
#include "sinew/math/ray.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct CameraView {
  Affine to_world = identity_affine();  // looks along -Z, +Y up; columns of unit length
  bool orthographic = false;
  float yfov = 0.8f;  // radians
  float ymag = 1.0f;  // orthographic: half height
  float znear = 0.0f;
};

// Makes the rays of one camera and image size; x and y in pixels from the upper left corner of the
// image, pixel centres at .5. Directions have unit length.
class CameraRays {
 public:
  CameraRays(const CameraView& camera, uint32_t width, uint32_t height);
  Ray operator()(float x, float y) const;

  // How wide the ray of a whole pixel is at the eye, and by how much it widens in a metre there.
  float pixel_width() const { return camera_.orthographic ? pixel_ : 0.0f; }
  float pixel_spread() const { return camera_.orthographic ? 0.0f : pixel_; }

 private:
  CameraView camera_;
  float pixel_ = 0.0f;  // size on the plane one unit before the eye
  vec2 center_{0.0f};
};

// The same for a single ray: x and y in pixels from the upper left corner of a width x height
// image; pixel centres at .5.
Ray camera_ray(const CameraView& camera, float x, float y, uint32_t width, uint32_t height);

// The scene's camera `index` as the pose places it.
CameraView scene_camera(const Scene& scene, const ScenePose& pose, uint32_t index);

// World to clip space as glm's projections give it: x and y are the screen in [-w, w], y up.
// Without a far plane; a camera without a near plane gets a very near one.
mat4 clip_from_world(const CameraView& camera, float aspect);

CameraView look_at(vec3 eye, vec3 target, vec3 up, float yfov);

// Sees the whole box from the given direction (from the box towards the eye), with a small margin.
CameraView frame_box(const Box& box, vec3 direction, float yfov, float aspect);

}  // namespace sinew
