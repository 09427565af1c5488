#include "bench/engines.h"

#include <cmath>

#include "sinew/base/parallel.h"

namespace sinew::bench {
namespace {

// As in World's queries.
size_t rays_per_task(size_t count) {
  return count <= 256 ? 32 : count <= 1024 ? 256 : 1024;
}

const char* engine_name(UpdateMode mode) {
  switch (mode) {
    case UpdateMode::automatic:
      return "sinew auto";
    case UpdateMode::full:
      return "sinew full";
    case UpdateMode::hybrid:
      return "sinew hybrid";
    case UpdateMode::lazy:
      return "sinew lazy";
  }
  return "";
}

const char* engine_name(EmbreeMode mode) {
  switch (mode) {
    case EmbreeMode::medium:
      return "embree medium rebuild";
    case EmbreeMode::refit:
      return "embree refit";
    case EmbreeMode::low:
      return "embree low rebuild";
    case EmbreeMode::high:
      return "embree high rebuild";
  }
  return "";
}

}  // namespace

Result<void> Arena::open(Scene scene, std::string name) {
  scene_ = std::move(scene);
  name_ = std::move(name);
  SINEW_TRY(clip_, find_clip(scene_, ""));
  return {};
}

Result<void> Arena::add_ours(UpdateMode mode) {
  SINEW_TRY(World world, prepare(scene_));
  world.set_update_mode(mode);
  ours_.push_back(std::make_unique<Ours>(Ours{engine_name(mode), std::move(world)}));
  World* const w = &ours_.back()->world;
  engines_.push_back({engine_name(mode), [w](double time) { (void)w->set_time(time); },
                      [w](auto rays, auto hits) { w->closest_hits(rays, hits); },
                      [w](auto rays, auto hit) { w->any_hits(rays, hit); }});
  return {};
}

void Arena::add_embree(EmbreeMode mode) {
  sample(scene_, clip_, time_of(0), pose_);
  theirs_.push_back(
      std::unique_ptr<Theirs>(new Theirs{EmbreeWorld(scene_, clip_, pose_, {.mode = mode}), {}}));
  Theirs* const t = theirs_.back().get();
  const auto closest = [this, t](std::span<const Ray> rays, std::span<Hit> hits) {
    parallel_for(rays.size(), rays_per_task(rays.size()), [&](size_t begin, size_t end) {
      closest_hits(t->world.scene(), closest_, rays.subspan(begin, end - begin),
                   hits.subspan(begin, end - begin));
    });
  };
  const auto any = [this, t](std::span<const Ray> rays, std::span<uint8_t> hit) {
    parallel_for(rays.size(), rays_per_task(rays.size()), [&](size_t begin, size_t end) {
      any_hits(t->world.scene(), any_, rays.subspan(begin, end - begin),
               hit.subspan(begin, end - begin));
    });
  };
  const auto pose = [this, t](double time) {
    sample(scene_, clip_, time, t->pose);
    t->world.update(t->pose);
  };
  engines_.push_back({engine_name(mode), pose, closest, any});
}

const Engine* Arena::find(std::string_view name) const {
  for (const Engine& engine : engines_) {
    if (engine.name == name) return &engine;
  }
  return nullptr;
}

const World* Arena::world(std::string_view name) const {
  for (const auto& ours : ours_) {
    if (ours->name == name) return &ours->world;
  }
  return nullptr;
}

double Arena::time_of(uint32_t frame) const {
  if (clip_ == kRestPose) return 0.0;
  const Clip& clip = scene_.clips[clip_];
  const double length = clip.end - clip.start;
  if (!(length > 0.0)) return clip.start;
  const double fps = scene_.default_fps > 0.0 ? scene_.default_fps : 24.0;
  return clip.start + std::fmod(0.5 * length + frame / fps, length);
}

const ScenePose& Arena::pose_at(double time) {
  sample(scene_, clip_, time, pose_);
  return pose_;
}

}  // namespace sinew::bench
