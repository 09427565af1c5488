// The voxel objects of a frame: poses, shadow maps, which voxel is in front in each pixel, and the
// light that these send to the eye.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/render/gbuffer.h"
#include "sinew/render/voxels/kept_voxels.h"
#include "sinew/render/voxels/voxel_settings.h"
#include "sinew/render/voxels/voxel_shade.h"
#include "sinew/render/voxels/voxel_shadows.h"
#include "sinew/scene/image.h"
#include "sinew/world/voxel_bodies.h"

namespace sinew {

// One pass over an image of voxels and what lies behind them.
struct VoxelPass {
  const VoxelLighting& lighting;
  const Visibility& visibility;
  VoxelFetch fetch;
  uint32_t width = 0, height = 0;    // of the camera's whole image
  uint32_t step = 1;                 // how many of its pixels a pixel of the pass is wide
  vec2 offset{0.5f};                 // of the pass's rays in its pixels
  bool transparent = false;          // nothing behind the voxels, alpha 0
  float share = 1.0f;                // of the pass in the picture
  bool first = true;                 // else adds to what is there
  const KeptVoxels* kept = nullptr;  // then voxels are fetched from there
};

// Shades every pixel of the pass, each voxel that several pixels of a tile show once. `out` has the
// size of the visibility. In parallel; the same bits for any number of threads.
void shade_pass(const VoxelPass& pass, Image& out);

class VoxelOpponents;

class VoxelFrame {
 public:
  VoxelFrame();
  ~VoxelFrame();

  // Makes the tables that depend on the scene alone; it must outlive them.
  void bind(const Scene& scene, const TextureTable& textures);

  // Begins a frame of what the world shows, until its next commit: what comes and goes of octrees
  // (svo/file/stream.h), and their poses. All of it is drawn until choose() says otherwise. Of
  // octrees that are to settle, shadow maps show everything, and drawn pictures what fits: it is
  // there afterwards. Must not overlap queries of the world; nor must draw() and set_shadows().
  void begin(const World& world, const VoxelSettings& settings);
  // The same of a scene that is in no world: poses its octrees. Nothing can be traced.
  void begin(const Scene& scene, const ScenePose& pose, const VoxelSettings& settings);
  // Draws shadow maps, or none: then voxels let all light through, as maps have it.
  void set_shadows(std::span<const ShadingLight> lights, bool maps);
  // Whether there are voxels in this frame.
  bool any() const { return !bodies_.instances().empty(); }
  // Whether octrees of the scene have materials that are mirrors: not what merely gleams.
  bool has_mirrors() const { return mirrors_; }

  // Chooses which objects draw() draws, and which camera rays find (see is_traced()). The rays of a
  // picture see all of them, but for those of the camera.
  void choose(const CameraView& camera, uint32_t width, uint32_t height, uint32_t step, bool rays);
  // Whether draw() draws anything.
  bool rasters() const { return !drawn_.empty(); }
  // By object of the world: what camera rays pass because it is drawn, and all voxels.
  std::span<const uint8_t> drawn() const { return hidden_drawn_; }
  std::span<const uint8_t> all() const { return hidden_all_; }

  // From here on, until the next frame, draw() draws pictures in parts where their voxels do not
  // fit into memory, so that they are those of the whole octrees. They are shaded by shade() alone.
  void allow_parts() { in_parts_ = true; }

  // Finds which voxels are in front, as camera_raster_view() sees them.
  void draw(const CameraView& camera, uint32_t width, uint32_t height, uint32_t step, vec2 offset);
  const Visibility& visibility() const { return visibility_; }
  std::span<const VoxelShadowMap> shadows() const { return shadows_.maps(); }
  std::span<const VoxelMaterial> materials() const { return materials_; }
  std::span<const VoxelInstance> instances() const { return bodies_.instances(); }

  // Fetches what draw() has found, if it was not in parts.
  void fetch(std::span<const VisibilityKey> keys, VoxelBatch& out) const;

  // Shades what draw() has found. `lighting` says the materials and shadows of this frame.
  void shade(const VoxelPass& pass, Image& out);

  // Where the ray through this pixel meets the voxel in front: the ray's t; infinite if none is.
  float t_of(size_t pixel, const Ray& ray) const;
  // The voxel in front, as a surface for rays. There must be one. Its Hit::object is the world's.
  void resolve(size_t pixel, const Ray& ray, const RayCone& cone, Surface& out) const;
  // The voxel that a ray has met in the world: the same surface.
  void resolve(const World& world, const Hit& hit, const Ray& ray, const RayCone& cone,
               Surface& out) const;

  const VoxelStats& stats() const { return stats_; }

 private:
  void draw_all();
  void split();
  VoxelSample sample(VisibilityKey key) const;
  void resolve(const VoxelSample& voxel, const Ray& ray, const RayCone& cone, Surface& out) const;
  template <class Draw>
  void draw_settled(const Draw& draw);
  template <class Draw, class Keep>
  bool draw_in_parts(const Draw& draw, const Keep& keep);

  const Scene* scene_ = nullptr;
  const World* world_ = nullptr;  // null: the octrees are posed here
  VoxelBodies bodies_;
  std::vector<VoxelInstance> drawn_;     // by the rasteriser
  std::vector<uint32_t> drawn_objects_;  // one a drawn instance
  std::vector<uint8_t> hidden_drawn_, hidden_all_;
  std::vector<uint8_t> traced_;  // one an instance
  std::vector<VoxelMaterial> materials_;
  bool mirrors_ = false;
  uint32_t first_object_ = 0;  // of the world: what bodies_.objects() count from
  VoxelShadows shadows_;
  VoxelSettings settings_;
  RasterScratchPtr scratch_ = make_raster_scratch();
  std::unique_ptr<VoxelOpponents> opponents_;  // once they are asked for
  RasterView view_;
  Visibility visibility_;
  bool in_parts_ = false;
  bool keeps_ = false;  // what is seen is in kept_
  KeptVoxels kept_;
  VoxelStats stats_;
};

}  // namespace sinew
