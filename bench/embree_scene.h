// Embree as oracle and opponent: meshes and instances in one scene, built once, refit or built anew
// at every commit.
// Based on: the Embree 3.13 manual. REFIT is honoured only where the scene's quality is LOW; such a
// scene has one hierarchy a geometry, and a commit touches only the geometries that changed.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "sinew/math/affine.h"
#include "sinew/math/ray.h"

namespace sinew::bench {

enum class EmbreeMode {
  medium,  // one hierarchy over everything, built anew at every commit
  refit,   // a hierarchy a geometry; those that changed are refit
  low,     // a hierarchy a geometry; those that changed are built anew with low quality
  high,    // one hierarchy with spatial splits over everything, built anew at every commit
};

struct EmbreeConfig {
  EmbreeMode mode = EmbreeMode::medium;
  bool robust = true;  // RTC_SCENE_FLAG_ROBUST: watertight, as our default is
};

// How a geometry follows the animation; Embree is told what is best for it.
enum class EmbreeMotion { still, deforms };

class EmbreeScene {
 public:
  explicit EmbreeScene(const EmbreeConfig& config);
  // One mesh that deforms, ROBUST, committed.
  EmbreeScene(std::span<const vec3> positions, std::span<const uvec3> triangles, EmbreeMode mode);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // Geometries are numbered in the order of these calls; hits name them. Positions are copied, the
  // triangles must outlive the scene.
  uint32_t add_mesh(std::span<const vec3> positions, std::span<const uvec3> triangles,
                    EmbreeMotion motion);
  uint32_t add_instance(uint32_t shape, const Affine& placement);
  // A mesh that only instances show; returns the number of the shape.
  uint32_t add_shape(std::span<const vec3> positions, std::span<const uvec3> triangles);

  // The vertices that the next commit takes up: asking for them says that they change. Embree reads
  // these very bytes.
  std::span<vec3> vertices(uint32_t geometry = 0);
  void place(uint32_t instance, const Affine& placement);
  void set_present(uint32_t geometry, bool present);
  void commit();

  // One ray a call (see embree_calls.h for the others).
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const;
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) const;

  RTCScene handle() const { return scene_; }
  // Bytes that Embree holds; vertices and indices are not among them.
  size_t bytes() const { return static_cast<size_t>(bytes_.load()); }

 private:
  struct Geometry {
    RTCGeometry handle = nullptr;
    std::vector<vec3> vertices;  // with one more, for Embree reads 16 bytes a vertex
    bool changed = false;
    bool present = true;
  };
  Geometry make_mesh(std::span<const vec3> positions, std::span<const uvec3> triangles,
                     RTCBuildQuality quality);
  uint32_t attach(Geometry geometry);
  EmbreeConfig config_;
  std::atomic<int64_t> bytes_ = 0;
  RTCDevice device_;
  RTCScene scene_;
  std::vector<Geometry> geometries_;
  std::vector<Geometry> shapes_;
  std::vector<RTCScene> shape_scenes_;
};

}  // namespace sinew::bench
