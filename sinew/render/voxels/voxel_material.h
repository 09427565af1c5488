// What materials say of voxels. Voxels have no texture coordinates: their colour holds the base
// colour's texture already, and other textures count with their mean.
#pragma once

#include <vector>

#include "sinew/render/gbuffer.h"
#include "sinew/svo/draw/visibility.h"

namespace sinew {

// As kernels read it: one material is a row of floats.
struct VoxelMaterial {
  vec3 dielectric{0.04f};  // reflectance of what is not metal, at normal incidence
  float specular = 1.0f;   // ... at grazing incidence
  vec3 emission{0.0f};
  float metallic = 0.0f;
  float roughness = 1.0f;
  float occlusion = 1.0f;
  float unlit = 0.0f;  // 1: shows its colour and nothing else
  float reserved = 0.0f;
};
static_assert(sizeof(VoxelMaterial) == 12 * sizeof(float));

// Replaces textures by their means, multiplied into the factors that they belong to. Of the base
// colour and normals, which voxels hold themselves, and of occlusion only the references go.
void fold_textures(const TextureTable& textures, Material& material);

// One a material of the scene. What transmits light is drawn as if it did not.
void list_voxel_materials(const Scene& scene, const TextureTable& textures,
                          std::vector<VoxelMaterial>& out);

// Normals that differ within a coarse voxel blur its highlight; `spread` is the length of their
// mean. Based on: M. Toksvig, "Mipmapping Normal Maps", 2005.
float widened_roughness(float roughness, float spread);

// How far a voxel's normal may face away from the viewer (its cosine) before the voxel counts as
// seen from behind. What is nearly in profile shades as seen from the front.
inline constexpr float kFromBehind = -0.3f;
// ... the least cosine that such a one is given: a voxel is too wide for all of it to gleam as
// surfaces do at grazing angles.
inline constexpr float kProfile = 0.15f;

// The voxel as rays through its pixel meet it; `diagonal` is that of the drawn voxel, deformed.
void resolve_voxel(const VoxelSample& voxel, float diagonal, const VoxelMaterial& material,
                   vec3 view, Surface& out);

}  // namespace sinew
