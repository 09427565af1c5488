// The motion that a mesh has by its data.
#include "sinew/scene/mesh.h"

#include <algorithm>

namespace sinew {
namespace {

SkinMotion skin_of(const Mesh& mesh) {
  SkinMotion skin{mesh.positions, mesh.influences, mesh.joints, mesh.weights};
  if (!mesh.joints.empty()) skin.joint_count = *std::ranges::max_element(mesh.joints) + 1u;
  return skin;
}

}  // namespace

Motion motion_of(const Mesh& mesh, bool skinned) {
  const uint32_t vertices = static_cast<uint32_t>(mesh.positions.size());
  if (mesh.vertex_program) return FreeMotion{vertices};
  if (mesh.keys > 0) return KeyframeMotion{vertices, mesh.key_positions};
  const SkinMotion skin = skinned ? skin_of(mesh) : SkinMotion{};
  if (mesh.morph_targets > 0) return MorphMotion{mesh.positions, mesh.morph_positions, skin};
  if (skin.influences > 0) return skin;
  return RigidMotion{mesh.positions};
}

}  // namespace sinew
