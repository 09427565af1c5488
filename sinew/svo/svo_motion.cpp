// What bounds an octree's blocks in every pose: its corners as vertices of a Motion, a cluster a
// block.
#include <numeric>

#include "sinew/svo/corners.h"
#include "sinew/svo/posed.h"

namespace sinew {
namespace {

// The corners of all blocks, decoded.
struct CornerVertices {
  std::vector<vec3> rest;
  std::vector<uint16_t> joints;
  std::vector<float> weights;
  std::vector<vec3> deltas;  // target-major
};

void decode_skin(const Svo& svo, uint32_t block, CornerVertices& out) {
  const SvoBlock &b = svo.blocks[block], &end = svo.blocks[block + 1];
  for (uint32_t i = b.first_corner; i < end.first_corner; ++i) {
    for (uint32_t k = 0; k < kSvoInfluences; ++k) {
      out.joints[i * kSvoInfluences + k] =
          svo.joint_palette[b.first_joint + svo.corner_joints[i][k]];
      out.weights[i * kSvoInfluences + k] = corner_weight(svo.corner_weights[i][k]);
    }
  }
}

void decode_targets(const Svo& svo, uint32_t block, CornerVertices& out) {
  const SvoBlock &b = svo.blocks[block], &end = svo.blocks[block + 1];
  const uint32_t count = end.first_corner - b.first_corner;
  for (uint32_t t = b.first_target; t < end.first_target; ++t) {
    const SvoTarget& target = svo.targets[t];
    vec3* const to = &out.deltas[target.target * out.rest.size() + b.first_corner];
    for (uint32_t i = 0; i < count; ++i) {
      to[i] = corner_delta(target.unit, svo.deltas[target.first_delta + i]);
    }
  }
}

CornerVertices decode(const Svo& svo) {
  CornerVertices out;
  const size_t count = svo.corner_places.size();
  out.rest.resize(count);
  if (svo.joints > 0) {
    out.joints.resize(count * kSvoInfluences);
    out.weights.resize(count * kSvoInfluences);
  }
  out.deltas.resize(count * svo.morph_targets, vec3(0.0f));
  for (uint32_t block = 0; block < svo.block_count(); ++block) {
    const SvoBlock& b = svo.blocks[block];
    for (uint32_t i = b.first_corner; i < svo.blocks[block + 1].first_corner; ++i) {
      out.rest[i] = corner_rest(svo.grid, b, svo.corner_places[i]);
    }
    if (svo.joints > 0) decode_skin(svo, block, out);
    decode_targets(svo, block, out);
  }
  return out;
}

Motion motion_of(const Svo& svo, const CornerVertices& corners) {
  SkinMotion skin{corners.rest, kSvoInfluences, corners.joints, corners.weights, svo.joints};
  if (svo.joints == 0) skin.influences = 0;
  if (svo.morph_targets > 0) return MorphMotion{corners.rest, corners.deltas, skin};
  if (svo.joints > 0) return skin;
  return RigidMotion{corners.rest};
}

}  // namespace

SvoMotion make_svo_motion(const Svo& svo) {
  SvoMotion out;
  out.svo = &svo;
  out.first_block = svo.first_block_node();
  out.no_deltas.resize(svo.morph_targets);
  const CornerVertices corners = decode(svo);
  std::vector<uint32_t> first, vertices(corners.rest.size());
  for (const SvoBlock& block : svo.blocks) first.push_back(block.first_corner);
  std::iota(vertices.begin(), vertices.end(), 0u);
  out.blocks = make_cluster_bounds(motion_of(svo, corners), {first, vertices});
  return out;
}

Motion SvoMotion::shape() const {
  static const vec3 kRest[1] = {vec3(0.0f)};
  SkinMotion skin;
  skin.influences = svo->joints > 0 ? kSvoInfluences : 0;
  skin.joint_count = svo->joints;
  if (svo->morph_targets > 0) return MorphMotion{kRest, no_deltas, skin};
  if (svo->joints > 0) return skin;
  return RigidMotion{};
}

}  // namespace sinew
