// Layers: what the ray through each pixel's centre meets first, apart from any light. They come
// from a pass of their own, so a picture may have any number of samples beside them.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/render/attributes.h"
#include "sinew/render/camera.h"
#include "sinew/render/texture.h"
#include "sinew/render/voxels/voxel_frame.h"
#include "sinew/world/world.h"

namespace sinew {

// Which layers are made, or written.
struct LayerChoice {
  bool color = true;  // the picture itself: render_frame makes it, trace_layers does not
  bool depth = true;
  bool normal = true;
  bool object = true;
  bool primitive = true;
  bool traversal = true;

  bool any_traced() const { return depth || normal || object || primitive || traversal; }
};

// One value a pixel, rows from the top; layers that were not chosen are empty.
struct FrameLayers {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<float> depth;         // along the camera's axis, metres; infinite: nothing is there
  std::vector<vec3> normal;         // world, unit, as shading has it, towards the eye; or zero
  std::vector<uint32_t> object;     // index in Scene::objects, after these in Scene::voxels, or
                                    // kNoObject
  std::vector<uint32_t> primitive;  // index of the triangle in its mesh, of the cell (then node) in
                                    // its octree, or kNoObject
  std::vector<uint32_t> traversal;  // steps of the ray: nodes and packets tested; what the
                                    // rasteriser draws takes none
};

// Buffers that live from frame to frame.
struct LayerScratch {
  AttributeTable attributes;
  TextureTable textures;
  VoxelFrame voxels;
  std::vector<Hit> hits;
};

// Fills the chosen layers of the world as `pose` has it (committed). Visibility is that of
// pictures: holes of masks and invisible texels are passed, a blended surface is met. Same bits for
// every thread count.
void trace_layers(const World& world, const Scene& scene, const ScenePose& pose,
                  const CameraView& camera, uint32_t width, uint32_t height,
                  const LayerChoice& choice, LayerScratch& scratch, FrameLayers& out,
                  const VoxelSettings& voxels = {});

}  // namespace sinew
