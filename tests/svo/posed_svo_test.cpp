// Poses of octrees: corners bit for bit as the Motion of their decoded values moves them, and boxes
// that contain them.
#include "sinew/svo/posed.h"

#include <gtest/gtest.h>

#include "sinew/svo/corners.h"
#include "svo/skinned_shape.h"

namespace sinew {
namespace {

using test::SkinnedShape;

SkinnedShape twisted_body(bool targets) {
  SkinnedShape body;
  body.shape = test::sphere(3);
  body.shape.positions = test::twisted(body.shape.positions, 1.0f);
  body.follow_along(vec3(0.5f, -0.2f, 0.6f), 6);
  if (!targets) return body;
  std::vector<vec3> bulge, shift, none(body.shape.positions.size(), vec3(0.0f));
  for (const vec3 p : body.shape.positions) {
    bulge.push_back(p.x > 0.2f ? 0.4f * p : vec3(0.0f));
    shift.push_back(vec3(0.1f, 0.0f, -0.2f * p.y));
  }
  for (const auto& target : {bulge, none, shift}) body.add_target(target);
  return body;
}

// The block's corners as vertices of a motion.
struct DecodedBlock {
  std::vector<vec3> rest, deltas;
  std::vector<uint16_t> joints;
  std::vector<float> weights;
  uint32_t joint_count;

  DecodedBlock(const Svo& svo, uint32_t b) : joint_count(svo.joints) {
    const SvoBlock &block = svo.blocks[b], &next = svo.blocks[b + 1];
    const uint32_t count = next.first_corner - block.first_corner;
    deltas.resize(size_t{count} * svo.morph_targets, vec3(0.0f));
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t corner = block.first_corner + i;
      rest.push_back(corner_rest(svo.grid, block, svo.corner_places[corner]));
      for (uint32_t k = 0; k < kSvoInfluences; ++k) {
        joints.push_back(svo.joint_palette[block.first_joint + svo.corner_joints[corner][k]]);
        weights.push_back(corner_weight(svo.corner_weights[corner][k]));
      }
      for (uint32_t t = block.first_target; t < next.first_target; ++t) {
        const SvoTarget& target = svo.targets[t];
        const auto& d = svo.deltas[target.first_delta + i];
        deltas[target.target * count + i] = target.unit * vec3(d[0], d[1], d[2]);
      }
    }
  }
  Motion motion() const {
    const SkinMotion skin{rest, kSvoInfluences, joints, weights, joint_count};
    if (deltas.empty()) return skin;
    return MorphMotion{rest, deltas, skin};
  }
};

void expect_block_as_motion(const Svo& svo, const PosedSvo& posed, const Pose& pose, uint32_t b) {
  const DecodedBlock decoded(svo, b);
  const Motion motion = decoded.motion();
  std::vector<vec3> expected(decoded.rest.size());
  positions(motion, pose, 0, expected);
  const PosedBlock block = posed.block(b);
  ASSERT_EQ(block.positions.size(), expected.size());
  ASSERT_EQ(block.cofactors.size(), expected.size());
  for (uint32_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(block.positions[i], expected[i]);
    const mat3 map = local_map(motion, pose, i);
    const mat3 cofactor = sinew::cofactor(Affine(map[0], map[1], map[2], vec3(0.0f)));
    ASSERT_EQ(block.cofactors[i], cofactor);
  }
}

TEST(PosedSvo, CornersAreTheirMotionsAndBoxesContainThem) {
  for (const bool targets : {false, true}) {
    SkinnedShape body = twisted_body(targets);
    const Svo svo = *make_svo(*body.voxelized(150), body.source());
    ASSERT_EQ(validate(svo), "");
    EXPECT_EQ(svo.morph_targets, targets ? 3u : 0u);
    const SvoMotion motion = make_svo_motion(svo);
    PosedSvo posed;
    const uint32_t seed = 2718;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    for (int round = 0; round < 1000; ++round) {
      const std::vector<Affine> joints = test::random_joints(body.joint_count, random);
      float weights[3];
      for (float& w : weights) w = random.uniform() < 0.3f ? 0.0f : random.uniform(-2.0f, 2.0f);
      Pose pose;
      pose.joints = joints;
      if (targets) pose.weights = weights;
      ASSERT_TRUE(pose_fits(svo, pose));
      posed.set_pose(motion, pose);
      const uint32_t first = svo.first_block_node();
      std::vector<Box> exact(first + svo.block_count());
      for (uint32_t b = 0; b < svo.block_count(); ++b) {
        EXPECT_FALSE(posed.is_made(b));
        posed.make_block(b);
        if (round < 20) expect_block_as_motion(svo, posed, pose, b);
        for (const vec3 p : posed.block(b).positions) exact[first + b].extend(p);
      }
      for (uint32_t n = first; n-- > 0;) {
        const SvoNode& node = svo.nodes[n];
        for (uint32_t c = 0; c < node.count; ++c) exact[n].extend(exact[node.first + c]);
      }
      for (uint32_t n = 0; n < exact.size(); ++n) {
        ASSERT_TRUE(posed.bounds(n).contains(exact[n])) << "round " << round << " node " << n;
      }
    }
  }
}

TEST(PosedSvo, PosesThatDoNotFit) {
  SkinnedShape body = twisted_body(true);
  const Svo svo = *make_svo(*body.voxelized(40), body.source());
  std::vector<Affine> joints(6, identity_affine());
  std::vector<float> weights(3, 0.0f);
  Pose pose;
  pose.joints = joints;
  pose.weights = weights;
  EXPECT_TRUE(pose_fits(svo, pose));
  pose.weights = std::span(weights).first(2);
  EXPECT_FALSE(pose_fits(svo, pose));
  pose.weights = weights;
  pose.joints = std::span(joints).first(5);
  EXPECT_FALSE(pose_fits(svo, pose));
  pose.joints = joints;
  joints[4][2].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(pose_fits(svo, pose));
}

// At rest every corner stays where it is, but for the rounding of weights.
TEST(PosedSvo, TheRestPoseIsTheRest) {
  SkinnedShape body = twisted_body(false);
  const Svo svo = *make_svo(*body.voxelized(100), body.source());
  const SvoMotion motion = make_svo_motion(svo);
  const std::vector<Affine> joints(6, identity_affine());
  Pose pose;
  pose.joints = joints;
  PosedSvo posed;
  posed.set_pose(motion, pose);
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    posed.make_block(b);
    const SvoBlock& block = svo.blocks[b];
    for (uint32_t i = 0; i < posed.block(b).positions.size(); ++i) {
      const vec3 rest = corner_rest(svo.grid, block, svo.corner_places[block.first_corner + i]);
      EXPECT_LT(length(posed.block(b).positions[i] - rest), 2e-6f);
    }
  }
}

}  // namespace
}  // namespace sinew
