// Which camera looks: one of the file's, one given by numbers, or one that frames the animation.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "sinew/base/error.h"
#include "sinew/render/camera.h"

namespace sinew::app {

struct FileCamera {
  std::string name;  // or index; empty: the first if there is one, else an OrbitCamera
};
struct LookAtCamera {
  vec3 eye{0.0f};
  vec3 target{0.0f};
  float fov = 40.0f;  // degrees, vertical
};
// Looks at the middle of everything that the animation touches, from a distance that shows it all.
struct OrbitCamera {
  float azimuth = 35.0f;    // degrees around +Y; 0 looks from +Z, 90 from +X
  float elevation = 18.0f;  // degrees above the horizon
  float zoom = 1.0f;        // 2: from half the distance
};
using CameraChoice = std::variant<FileCamera, LookAtCamera, OrbitCamera>;

// "eye=1,2,3,target=0,1,0[,fov=40]", "orbit=35,18[,1.5]", else a camera of the file.
Result<CameraChoice> parse_camera(std::string_view text);

// The camera that `choice` means for this scene, ready for every frame.
class FrameCamera {
 public:
  // `aspect` is width / height. Errors: no such camera in the file, nothing to look at.
  static Result<FrameCamera> choose(const CameraChoice& choice, const Scene& scene, int clip,
                                    float aspect);
  CameraView view(const Scene& scene, const ScenePose& pose) const;

 private:
  int index_ = -1;  // of the scene's cameras; -1: fixed_
  CameraView fixed_;
};

}  // namespace sinew::app
