#include "sinew/render/ray_filter.h"

#include <algorithm>
#include <cmath>

#include "sinew/render/gbuffer.h"

namespace sinew {
namespace {

constexpr float kDepthUnit = 4096.0f;         // of optical depth, in powers of two
constexpr uint32_t kOpaqueDepth = 10 * 4096;  // 2^-10
constexpr float kInvisible = 0.5f / 255.0f;   // alpha below which a blend is a hole

const Mesh& mesh_of(const Scene& scene, const Hit& hit) {
  return scene.meshes[scene.objects[hit.object].mesh];
}

// Whether the hit texel is a hole in its surface.
bool is_hole(const Scene& scene, const Material& material, const Hit& hit) {
  if (material.alpha_mode == AlphaMode::opaque) return false;
  const float alpha = base_color(scene, mesh_of(scene, hit), hit).w;
  return material.alpha_mode == AlphaMode::mask ? alpha < material.alpha_cutoff
                                                : alpha <= kInvisible;
}

bool lets_light_through(const Material& material) {
  return material.alpha_mode == AlphaMode::blend || material.transmission > 0.0f;
}

uint32_t depth_of(float transparency) {
  if (transparency <= 0x1p-10f) return kOpaqueDepth;
  return static_cast<uint32_t>(std::lround(-std::log2(std::min(transparency, 1.0f)) * kDepthUnit));
}

bool is_opaque(uvec3 depth) {
  return std::min({depth.x, depth.y, depth.z}) >= kOpaqueDepth;
}

// Whether the direction runs against the front of the hit triangle. Mirrored placements turn the
// winding round (glTF 2.0, section 3.7.4).
bool meets_front(const FilterContext& context, const Hit& hit, vec3 direction) {
  const std::array<vec3, 3> p = context.world->triangle(hit.object, hit.primitive);
  const Affine placement = context.world->placement(hit.object);
  const float cosine = dot(cofactor(placement) * cross(p[1] - p[0], p[2] - p[0]), direction);
  return (context.world->mirrored(hit.object) ? -cosine : cosine) <= 0.0f;
}

const Material& material_of(const Scene& scene, const Hit& hit) {
  return scene.materials[mesh_of(scene, hit).material_of(hit.primitive)];
}

// Voxels are opaque, and have no sides.
bool is_voxel(const FilterContext& context, const Hit& hit) {
  return hit.object >= context.scene->objects.size();
}

bool accept_visible(const void* context, uint32_t ray, const Hit& hit) {
  const auto& c = *static_cast<const FilterContext*>(context);
  if (is_voxel(c, hit)) return true;
  const Material& material = material_of(*c.scene, hit);
  if (!material.has_back() && !meets_front(c, hit, c.rays[ray].direction)) return false;
  return !is_hole(*c.scene, material, hit);
}

bool accept_shadow(const void* context, uint32_t ray, const Hit& hit) {
  const auto& c = *static_cast<const FilterContext*>(context);
  if (is_voxel(c, hit)) return true;
  const Material& material = material_of(*c.scene, hit);
  if (!material.has_back() && !meets_front(c, hit, -c.rays[ray].direction)) return false;
  if (is_hole(*c.scene, material, hit)) return false;
  if (!lets_light_through(material)) return true;
  const vec3 left = transparency(*c.scene, *c.textures, mesh_of(*c.scene, hit), hit);
  uvec3& depth = c.optical_depth[ray];
  for (int channel = 0; channel < 3; ++channel) {
    depth[channel] = std::min(depth[channel] + depth_of(left[channel]), kOpaqueDepth);
  }
  return is_opaque(depth);
}

}  // namespace

bool needs_filter(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
    return m.alpha_mode != AlphaMode::opaque || !m.has_back() || m.transmission > 0.0f;
  });
}

HitFilter visible_filter(const FilterContext& context) {
  return {accept_visible, &context};
}
HitFilter shadow_filter(const FilterContext& context) {
  return {accept_shadow, &context};
}

vec3 transmittance(uvec3 optical_depth) {
  if (optical_depth == uvec3(0u)) return vec3(1.0f);
  vec3 left(0.0f);
  for (int channel = 0; channel < 3; ++channel) {
    const uint32_t depth = optical_depth[channel];
    if (depth < kOpaqueDepth) left[channel] = std::exp2(-static_cast<float>(depth) / kDepthUnit);
  }
  return left;
}

}  // namespace sinew
