#include "sinew/render/alpha.h"

#include <cmath>

#include "sinew/render/gbuffer.h"

namespace sinew {
namespace {

constexpr float kDepthUnit = 4096.0f;         // of optical depth, in powers of two
constexpr uint32_t kOpaqueDepth = 10 * 4096;  // 2^-10
constexpr float kInvisible = 0.5f / 255.0f;   // alpha below which a blend is a hole

// Opacity of the hit texel: 0 or 1 for masks.
float opacity(const Scene& scene, const Hit& hit) {
  const Mesh& mesh = scene.meshes[scene.objects[hit.object].mesh];
  const Material& material = scene.materials[mesh.material_of(hit.primitive)];
  if (material.alpha_mode == AlphaMode::opaque) return 1.0f;
  const float alpha = base_color(scene, mesh, hit).w;
  if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
  return alpha;
}

bool accept_visible(const void* context, uint32_t, const Hit& hit) {
  return opacity(*static_cast<const AlphaContext*>(context)->scene, hit) > kInvisible;
}

bool accept_shadow(const void* context, uint32_t ray, const Hit& hit) {
  const AlphaContext& alpha = *static_cast<const AlphaContext*>(context);
  const float left = 1.0f - opacity(*alpha.scene, hit);
  if (left >= 1.0f) return false;
  uint32_t& depth = alpha.optical_depth[ray];
  if (left <= 0x1p-10f) {
    depth = kOpaqueDepth;
  } else {
    depth += static_cast<uint32_t>(std::lround(-std::log2(left) * kDepthUnit));
  }
  return depth >= kOpaqueDepth;
}

}  // namespace

HitFilter visible_filter(const AlphaContext& context) {
  return {accept_visible, &context};
}
HitFilter shadow_filter(const AlphaContext& context) {
  return {accept_shadow, &context};
}

float transmittance(uint32_t optical_depth) {
  if (optical_depth >= kOpaqueDepth) return 0.0f;
  return optical_depth == 0 ? 1.0f : std::exp2(-static_cast<float>(optical_depth) / kDepthUnit);
}

}  // namespace sinew
