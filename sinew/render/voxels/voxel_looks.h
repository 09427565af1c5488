// How a mesh at rest looks to the voxeliser: base colours and normals as gbuffer.h defines them,
// with textures averaged over about a voxel. What else materials say of a surface is left to them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/render/texture.h"
#include "sinew/render/voxels/voxel_look_kernels.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/make/voxelize.h"

namespace sinew {

// Mip maps of the images that looks read, made only of those whose texels are smaller than voxels.
class LookTextures {
 public:
  explicit LookTextures(const Scene& scene)
      : scene_(&scene), colors_(scene.images.size()), data_(scene.images.size()) {}

  // Makes what the mesh needs with voxels of this side (object space). Must not overlap other
  // calls.
  void prepare(const Mesh& mesh, float voxel);

  // The level, 0 is the image itself; the coarsest one there is, if there are not so many.
  const Image8* color(const TextureRef& texture, uint32_t level) const {
    return find(colors_, texture, level);
  }
  const Image8* data(const TextureRef& texture, uint32_t level) const {
    return find(data_, texture, level);
  }

 private:
  static const Image8* find(std::span<const MipMap> maps, const TextureRef& texture,
                            uint32_t level);
  void use(std::vector<MipMap>& maps, const TextureRef& texture, bool srgb, bool smaller);

  const Scene* scene_;
  std::vector<MipMap> colors_, data_;  // one a Scene::images
};

// Which level of the texture has texels about as large as voxels, on this triangle.
uint32_t texture_level(const Scene& scene, const Mesh& mesh, const TextureRef& texture,
                       uint32_t triangle, float voxel);

// Looks of one mesh; a LookFunction can be made of it. The scene and the textures must outlive it.
class MeshLooks {
 public:
  MeshLooks(const Scene& scene, const Mesh& mesh, const LookTextures& textures);

  void operator()(const SurfaceBatch& batch) const;

  // Packed, of the materials without their textures, by numbers of triangles: what fills solids.
  uint16_t mean_color() const;

 private:
  LookTriangle triangle_of(uint32_t triangle, float voxel) const;
  LookTexture texture_of(const TextureRef& texture, bool color, uint32_t triangle,
                         float voxel) const;
  void set_normals(uint32_t triangle, float voxel, LookTriangle& out) const;

  const Scene* scene_;
  const Mesh* mesh_;
  const LookTextures* textures_;
  std::vector<vec3> computed_normals_;  // one a vertex, if the mesh has none
};

}  // namespace sinew
