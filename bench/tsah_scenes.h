// The scenes of `sinew bench tsah`: every one flattened to a single mesh whose vertices move, so
// that rigid parts take part in one tree, as in the tables of T (T-SAH 2015).
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/workload.h"
#include "sinew/base/error.h"
#include "sinew/bvh/frames/segments.h"
#include "sinew/render/camera.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew::bench {

// How much neighbours stay neighbours.
enum class SceneMotion : uint8_t {
  rigid,       // parts that move as they are
  moderate,    // characters: neighbours on the skin stay so
  deforming,   // one surface that bends far
  scattering,  // pieces that fly apart
  unknown,     // a scene of the user's
};
const char* name_of(SceneMotion motion);

struct TsahScene {
  std::string name;   // what --scene takes
  std::string input;  // what load() takes, below the data folder if `is_data`
  SceneMotion motion = SceneMotion::unknown;
  bool is_data = false;
  bool quick = false;  // measured where no scene is named
};

std::span<const TsahScene> tsah_scenes();

// A name of the list, or else a file or study scene as load() takes it. `data` is the folder of
// those scenes that are not ours.
TsahScene find_tsah_scene(const std::string& name, const std::string& data);

// A scene's first clip as one mesh. Frames are sampled from the clip itself at the time asked for:
// exact for joints and placements, linear between the keys of vertex caches.
class FlatClip {
 public:
  // An error if the scene has no triangles.
  static Result<FlatClip> open(const TsahScene& scene);

  std::span<const uvec3> triangles() const { return flat_.triangles; }
  uint32_t triangle_count() const { return static_cast<uint32_t>(flat_.triangles.size()); }
  bool moves() const { return clip_ != kRestPose; }

  // Moves the mesh to u in [0, 1] of the clip.
  void set(double u);
  const FlatScene& flat() const { return flat_; }
  // The scene's first camera as of set(), or one that sees the whole clip.
  CameraView camera(float aspect) const;

  // The boxes of the triangles at u, without moving the mesh; from any number of threads.
  void boxes(double u, std::span<Box> out) const;
  // `frames` evenly spread over the clip, first and last included; times are u. The clip must
  // outlive it.
  AnimatedBoxes animation(uint32_t frames) const;

 private:
  struct Sampler {
    ScenePose pose;
    FlatScene flat;
  };
  struct Samplers {  // that no thread uses at the moment
    std::mutex mutex;
    std::vector<std::unique_ptr<Sampler>> free;
  };
  double time_of(double u) const;

  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Samplers> samplers_;
  int clip_ = kRestPose;
  Box bounds_;  // of the whole clip
  ScenePose pose_;
  FlatScene flat_;
};

// u of frame i of `count`: evenly spread over [0, 1].
inline double frame_at(uint32_t i, uint32_t count) {
  return count < 2 ? 0.0 : double(i) / double(count - 1);
}

}  // namespace sinew::bench
