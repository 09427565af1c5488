// What bounds an octree's nodes in every pose: its corners as vertices of a Motion, clustered by
// the nodes that they are under.
#include <limits>

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

// The blocks under each node of kBlockLevel and above: a range, because both are in Morton order.
struct NodeBlocks {
  std::vector<uint32_t> first, end;  // one a node
};

NodeBlocks blocks_of_nodes(const Svo& svo) {
  const uint32_t first_block = svo.first_block_node(), count = first_block + svo.block_count();
  NodeBlocks out{std::vector<uint32_t>(count), std::vector<uint32_t>(count)};
  for (uint32_t n = count; n-- > 0;) {
    const SvoNode& node = svo.nodes[n];
    const bool is_block = node.level == kBlockLevel;
    out.first[n] = is_block ? n - first_block : out.first[node.first];
    out.end[n] = is_block ? n - first_block + 1 : out.end[node.first + node.count - 1];
  }
  return out;
}

// One cluster a node of [begin, end).
ClusterBounds bounds_of(const Svo& svo, const Motion& motion, const NodeBlocks& blocks,
                        size_t begin, size_t end, const ClusterConfig& config) {
  std::vector<uint32_t> first{0}, vertices;
  for (size_t n = begin; n < end; ++n) {
    const uint32_t from = svo.blocks[blocks.first[n]].first_corner;
    const uint32_t to = svo.blocks[blocks.end[n]].first_corner;
    for (uint32_t corner = from; corner < to; ++corner) vertices.push_back(corner);
    first.push_back(static_cast<uint32_t>(vertices.size()));
  }
  return make_cluster_bounds(motion, {first, vertices}, config);
}

}  // namespace

SvoMotion make_svo_motion(const Svo& svo) {
  SvoMotion out;
  out.svo = &svo;
  out.sizes.resize(svo.morph_targets);
  out.upper_nodes = svo.first_block_node();
  const CornerVertices corners = decode(svo);
  const Motion motion = motion_of(svo, corners);
  const NodeBlocks blocks = blocks_of_nodes(svo);
  out.upper = bounds_of(svo, motion, blocks, 0, out.upper_nodes, {.most_pieces = 1});
  out.blocks = bounds_of(svo, motion, blocks, out.upper_nodes, blocks.first.size(), {});
  return out;
}

Motion SvoMotion::shape() const {
  static const vec3 kRest[1] = {vec3(0.0f)};
  SkinMotion skin;
  skin.influences = svo->joints > 0 ? kSvoInfluences : 0;
  skin.joint_count = svo->joints;
  if (svo->morph_targets > 0) return MorphMotion{kRest, sizes, skin};
  if (svo->joints > 0) return skin;
  return RigidMotion{};
}

}  // namespace sinew
