#include "sinew/motion/influences.h"

#include <algorithm>

namespace sinew {
namespace {

const SkinMotion* skin_of(const Motion& motion) {
  if (const auto* skin = std::get_if<SkinMotion>(&motion)) return skin;
  const auto* morph = std::get_if<MorphMotion>(&motion);
  return morph != nullptr && morph->skin.influences > 0 ? &morph->skin : nullptr;
}

}  // namespace

std::vector<JointWeight> joint_weights(const Motion& motion, uvec3 triangle, vec3 barycentrics) {
  std::vector<JointWeight> out;
  const SkinMotion* const skin = skin_of(motion);
  if (skin == nullptr) return out;
  for (int corner = 0; corner < 3; ++corner) {
    const size_t begin = size_t{triangle[corner]} * skin->influences;
    for (size_t k = begin; k < begin + skin->influences; ++k) {
      const float weight = barycentrics[corner] * skin->weights[k];
      if (!(weight > 0.0f)) continue;
      const auto same = std::ranges::find(out, uint32_t{skin->joints[k]}, &JointWeight::joint);
      if (same == out.end()) {
        out.push_back({skin->joints[k], weight});
      } else {
        same->weight += weight;
      }
    }
  }
  std::ranges::sort(out, [](const JointWeight& a, const JointWeight& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  return out;
}

}  // namespace sinew
