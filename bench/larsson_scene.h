// The scenes and rays of L's tables.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/larsson_engines.h"
#include "sinew/base/error.h"
#include "sinew/render/camera.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew::bench {

// A scene as bodies in world space: one an object. Those that deform move; the others stay where
// the clip's first frame has them. A vertex cache gets a hierarchy a key, everything else one for
// its first shape.
class TableScene {
 public:
  // The first clip counts. An error if the scene has no clip, camera, light or number of frames, or
  // if nothing deforms.
  static Result<TableScene> make(const std::string& input);

  // Brings the bodies to a frame, counted from 1.
  void set_frame(uint32_t frame);

  uint32_t frame_count() const { return static_cast<uint32_t>(scene_.default_frames); }
  const std::string& name() const { return scene_.name; }
  const std::vector<BodyInput>& bodies() const { return bodies_; }
  FrameInput frame() const { return {positions_, keys_}; }
  CameraView camera() const { return scene_camera(scene_, pose_, 0); }
  std::vector<vec3> lights() const;  // positions
  uint64_t moving_triangles() const;
  uint64_t largest_moving_body() const;  // triangles

  // Whether the triangle mirrors: what its material reflects head on, sharply.
  bool mirrors(uint32_t body, uint32_t triangle) const;
  // Unit or zero.
  vec3 normal(uint32_t body, uint32_t triangle) const;

 private:
  void add_body(uint32_t object);

  Scene scene_;
  ScenePose pose_;
  std::vector<BodyInput> bodies_;
  std::vector<std::vector<vec3>> positions_;  // world; one a body
  std::vector<float> keys_;                   // where each body is among its keys
};

// The rays of one picture, in the order they are traced.
struct TableRays {
  std::vector<Ray> primary;
  std::vector<Ray> shadow;             // from what primary rays hit
  std::vector<Ray> reflection;         // from mirrors among it
  std::vector<Ray> reflection_shadow;  // from what those hit
};

// One primary ray for each step x step pixels, through their middle. The engine, which must be in
// the scene's frame, finds where the other rays begin: a shadow ray to each light that is in front
// of the surface, and a reflection about the triangle's own normal.
void make_rays(const TableScene& scene, TableEngine& engine, uint32_t width, uint32_t height,
               uint32_t step, TableRays& out);

}  // namespace sinew::bench
