// Embree as oracle and opponent: one triangle mesh, ROBUST, built or refit.
#pragma once

#include <embree3/rtcore.h>

#include <span>

#include "sinew/math/ray.h"

namespace sinew::bench {

enum class EmbreeMode {
  medium,  // built anew at every commit with medium quality
  refit,   // REFIT geometry; honoured because the scene's quality is LOW
};

class EmbreeScene {
 public:
  EmbreeScene(std::span<const vec3> positions, std::span<const uvec3> triangles, EmbreeMode mode);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // The vertices that the next commit takes up. Embree reads these very bytes.
  std::span<vec3> vertices();
  void commit();

  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const;
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const;

 private:
  RTCDevice device_;
  RTCScene scene_;
  RTCGeometry geometry_;
  vec3* vertices_ = nullptr;
  size_t vertex_count_;
};

}  // namespace sinew::bench
