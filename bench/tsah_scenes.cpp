#include "bench/tsah_scenes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "bench/copies.h"
#include "sinew/io/load.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

const std::array<TsahScene, 15> kScenes = {{
    {"cloth-20k", "study:cloth,triangles=20000", SceneMotion::deforming, false, true},
    {"fracture-60k", "study:fracture,triangles=60000", SceneMotion::scattering, false, true},
    {"robots", "bart/scene_robot/aff/Robot.aff", SceneMotion::rigid, true},
    {"kitchen", "bart/scene_kitchen/aff/kitchen.aff", SceneMotion::rigid, true},
    {"museum", "bart/scene_museum/aff/museum5.aff", SceneMotion::scattering, true},
    {"cloth", "study:cloth", SceneMotion::deforming},
    {"cell24", "study:cell24", SceneMotion::deforming},
    {"fracture", "study:fracture", SceneMotion::scattering},
    {"fracture-1600k", "study:fracture,triangles=1604000,pieces=1000", SceneMotion::scattering},
    {"soup", "study:soup", SceneMotion::scattering},
    {"twist", "study:twist", SceneMotion::deforming},
    {"creature", "study:creature", SceneMotion::moderate},
    {"herd", "study:herd,count=24,triangles=20000,terrain=500000", SceneMotion::moderate},
    {"drapes", "vertex-cache/cloth-drapes/base.obj+positions.pc2", SceneMotion::deforming, true},
    {"pigman", "skinned/pigman/pigman.glb", SceneMotion::moderate, true},
}};

// "study:fracture,triangles=20000" scatters as the fracture of the list does.
SceneMotion motion_of_study(std::string_view input) {
  const std::string_view study = input.substr(0, input.find(','));
  for (const TsahScene& scene : kScenes) {
    if (std::string_view(scene.input).substr(0, scene.input.find(',')) == study) {
      return scene.motion;
    }
  }
  return SceneMotion::unknown;
}

Result<Scene> load_scene(const std::string& input) {
  SINEW_TRY(Scene scene, load(input));
  if (!input.ends_with("/pigman.glb")) return scene;
  return copies_of(std::move(scene), 1, kPigManStrays);
}

}  // namespace

const char* name_of(SceneMotion motion) {
  constexpr const char* kNames[] = {"rigid", "moderate", "deforming", "scattering", "unknown"};
  return kNames[static_cast<size_t>(motion)];
}

std::span<const TsahScene> tsah_scenes() {
  return kScenes;
}

TsahScene find_tsah_scene(const std::string& name, const std::string& data) {
  const auto found = std::ranges::find(kScenes, name, &TsahScene::name);
  if (found == kScenes.end()) return {name, name, motion_of_study(name)};
  TsahScene scene = *found;
  if (scene.is_data) scene.input = data + "/" + scene.input;
  // The art piece has 1,024 triangles in the file, and 65,536 in T and in L.
  if (scene.name == "museum") scene.input = "aff:complexity=8," + scene.input;
  return scene;
}

Result<FlatClip> FlatClip::open(const TsahScene& scene) {
  FlatClip out;
  SINEW_TRY(Scene loaded, load_scene(scene.input));
  out.scene_ = std::make_unique<Scene>(std::move(loaded));
  if (count(*out.scene_).triangles == 0) {
    return fail(
        {ErrorKind::bad_input, scene.input, "", "it has no triangles", "name a scene with meshes"});
  }
  out.samplers_ = std::make_unique<Samplers>();
  SINEW_TRY(out.clip_, find_clip(*out.scene_, ""));
  if (out.scene_->cameras.empty()) out.bounds_ = animation_bounds(*out.scene_, out.clip_, 8);
  out.set(0.0);
  return out;
}

double FlatClip::time_of(double u) const {
  if (clip_ == kRestPose) return 0.0;
  const Clip& clip = scene_->clips[static_cast<size_t>(clip_)];
  return clip.start + u * (clip.end - clip.start);
}

void FlatClip::set(double u) {
  sample(*scene_, clip_, time_of(u), pose_);
  flatten(*scene_, pose_, flat_);
}

CameraView FlatClip::camera(float aspect) const {
  if (!scene_->cameras.empty()) return scene_camera(*scene_, pose_, 0);
  return frame_box(bounds_, vec3(0.5f, 0.35f, 1.0f), 0.8f, aspect);
}

void FlatClip::boxes(double u, std::span<Box> out) const {
  std::unique_ptr<Sampler> sampler;
  {
    const std::lock_guard lock(samplers_->mutex);
    if (!samplers_->free.empty()) {
      sampler = std::move(samplers_->free.back());
      samplers_->free.pop_back();
    }
  }
  if (!sampler) sampler = std::make_unique<Sampler>();
  sample(*scene_, clip_, time_of(u), sampler->pose);
  flatten(*scene_, sampler->pose, sampler->flat);
  triangle_boxes(sampler->flat.positions, sampler->flat.triangles, out);
  const std::lock_guard lock(samplers_->mutex);
  samplers_->free.push_back(std::move(sampler));
}

AnimatedBoxes FlatClip::animation(uint32_t frames) const {
  AnimatedBoxes out;
  out.primitive_count = triangle_count();
  for (uint32_t i = 0; i < frames; ++i) out.times.push_back(frame_at(i, frames));
  out.boxes = [this, frames](uint32_t frame, std::span<Box> boxes) {
    this->boxes(frame_at(frame, frames), boxes);
  };
  return out;
}

}  // namespace sinew::bench
