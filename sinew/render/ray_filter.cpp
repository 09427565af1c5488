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

// Opacity of the hit texel: 0 or 1 for masks.
float opacity(const Scene& scene, const Material& material, const Hit& hit) {
  if (material.alpha_mode == AlphaMode::opaque) return 1.0f;
  const float alpha = base_color(scene, mesh_of(scene, hit), hit).w;
  if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
  return alpha;
}

// Whether the direction runs against the front of the hit triangle. Mirrored placements turn the
// winding round (glTF 2.0, section 3.7.4).
bool meets_front(const FilterContext& context, const Hit& hit, vec3 direction) {
  const std::span<const vec3> p = context.world->positions(hit.object);
  const uvec3 t = mesh_of(*context.scene, hit).triangles[hit.primitive];
  const Affine placement = context.world->placement(hit.object);
  const float cosine =
      dot(cofactor(placement) * cross(p[t.y] - p[t.x], p[t.z] - p[t.x]), direction);
  return (context.world->mirrored(hit.object) ? -cosine : cosine) <= 0.0f;
}

const Material& material_of(const Scene& scene, const Hit& hit) {
  return scene.materials[mesh_of(scene, hit).material_of(hit.primitive)];
}

bool accept_visible(const void* context, uint32_t ray, const Hit& hit) {
  const auto& c = *static_cast<const FilterContext*>(context);
  const Material& material = material_of(*c.scene, hit);
  if (!material.double_sided && !meets_front(c, hit, c.rays[ray].direction)) return false;
  return opacity(*c.scene, material, hit) > kInvisible;
}

bool accept_shadow(const void* context, uint32_t ray, const Hit& hit) {
  const auto& c = *static_cast<const FilterContext*>(context);
  const Material& material = material_of(*c.scene, hit);
  if (!material.double_sided && !meets_front(c, hit, -c.rays[ray].direction)) return false;
  const float left = 1.0f - opacity(*c.scene, material, hit);
  if (left >= 1.0f) return false;
  uint32_t& depth = c.optical_depth[ray];
  if (left <= 0x1p-10f) {
    depth = kOpaqueDepth;
  } else {
    depth += static_cast<uint32_t>(std::lround(-std::log2(left) * kDepthUnit));
  }
  return depth >= kOpaqueDepth;
}

}  // namespace

bool needs_filter(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
    return m.alpha_mode != AlphaMode::opaque || !m.double_sided;
  });
}

HitFilter visible_filter(const FilterContext& context) {
  return {accept_visible, &context};
}
HitFilter shadow_filter(const FilterContext& context) {
  return {accept_shadow, &context};
}

float transmittance(uint32_t optical_depth) {
  if (optical_depth >= kOpaqueDepth) return 0.0f;
  return optical_depth == 0 ? 1.0f : std::exp2(-static_cast<float>(optical_depth) / kDepthUnit);
}

}  // namespace sinew
