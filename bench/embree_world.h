// Embree's side of an animated scene, as well as we can make it: what is still is never touched,
// what moves rigidly is an instance, and what deforms is written by our own motions, in parallel,
// straight into Embree's vertex buffers (in world space), before they are refit or built anew.
#pragma once

#include <vector>

#include "bench/embree_scene.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew::bench {

class EmbreeWorld {
 public:
  // Hits name the index in scene.objects. The scene must outlive the world.
  EmbreeWorld(const Scene& scene, int clip, const ScenePose& pose, const EmbreeConfig& config);

  void update(const ScenePose& pose);

  const EmbreeScene& scene() const { return embree_; }

 private:
  struct Chunk {  // of an object's vertices
    uint32_t object;
    uint32_t first;
    uint32_t count;
  };
  void add_object(uint32_t object, bool still, const ScenePose& pose);
  void deform(const ScenePose& pose);

  EmbreeScene embree_;
  std::vector<Motion> motions_;            // one an object
  std::vector<const Mesh*> meshes_;        // the same
  std::vector<uint32_t> shape_of_;         // instances: which shape; kNoShape for others
  std::vector<uint32_t> deforming_;        // objects
  std::vector<Chunk> chunks_;              // of them
  std::vector<std::span<vec3>> vertices_;  // one an object; as of the last update
};

}  // namespace sinew::bench
