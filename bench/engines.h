// Those who take part in `sinew bench update`: each follows the same animation in its own way, and
// answers the same rays. Ours are worlds, one an update mode; Embree's are EmbreeWorlds.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/embree_calls.h"
#include "bench/embree_world.h"
#include "sinew/base/error.h"
#include "sinew/bvh/update/update.h"
#include "sinew/world/world.h"

namespace sinew::bench {

struct Engine {
  std::string name;                       // "sinew lazy", "embree refit"
  std::function<void(double time)> pose;  // seconds; all that must be done before rays come
  // Any number of rays; from all threads where they are more than 1024.
  std::function<void(std::span<const Ray>, std::span<Hit>)> closest;
  std::function<void(std::span<const Ray>, std::span<uint8_t>)> any;
};

// An animated scene and its engines.
class Arena {
 public:
  Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  Result<void> open(Scene scene, std::string name);
  Result<void> add_ours(UpdateMode mode);
  void add_embree(EmbreeMode mode);

  // The calls that Embree's engines use from now on; at first they take one ray a call.
  void use(EmbreeCall closest, EmbreeCall any) { closest_ = closest, any_ = any; }

  const Scene& scene() const { return scene_; }
  const std::string& name() const { return name_; }
  uint64_t triangles() const { return count(scene_).triangles; }
  std::span<const Engine> engines() const { return engines_; }
  const Engine* find(std::string_view name) const;
  // Our world of that engine; nullptr if it is none of ours.
  const World* world(std::string_view name) const;

  int clip() const { return clip_; }
  // Frames go through the clip at its frame rate, from its middle on, and begin again.
  double time_of(uint32_t frame) const;
  const ScenePose& pose_at(double time);  // sampled for the bench's own use

 private:
  struct Ours {
    std::string name;
    World world;
  };
  struct Theirs {
    EmbreeWorld world;
    ScenePose pose;
  };
  Scene scene_;
  std::string name_;
  int clip_ = kRestPose;
  ScenePose pose_;
  EmbreeCall closest_ = EmbreeCall::single, any_ = EmbreeCall::single;
  std::vector<std::unique_ptr<Ours>> ours_;
  std::vector<std::unique_ptr<Theirs>> theirs_;
  std::vector<Engine> engines_;
};

}  // namespace sinew::bench
