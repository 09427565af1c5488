// Every motion by hand numbers, and its pose's invariants.
#include "sinew/motion/motion.h"

#include <gtest/gtest.h>

#include <vector>

#include "motion/random_body.h"

namespace sinew {
namespace {

std::vector<vec3> all_positions(const Motion& motion, const Pose& pose) {
  std::vector<vec3> out(vertex_count(motion));
  positions(motion, pose, 0, out);
  return out;
}

const std::vector<vec3> kRest = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};

TEST(Motion, RigidStaysAtRestWhateverThePlacement) {
  Pose pose;
  pose.placement = trs({5, 6, 7}, glm::identity<quat>(), vec3(2));
  EXPECT_EQ(all_positions(RigidMotion{kRest}, pose), kRest);
}

// Joint 0 rests; joint 1 turns a quarter about z and moves by (10, 0, 0).
const std::vector<Affine> kJoints = {
    identity_affine(), Affine(vec3(0, 1, 0), vec3(-1, 0, 0), vec3(0, 0, 1), vec3(10, 0, 0))};
const std::vector<uint16_t> kIndices = {0, 1, 0, 1, 1, 0};
const std::vector<float> kWeights = {0.5f, 0.5f, 0.25f, 0.75f, 1.0f, 0.0f};

TEST(Motion, SkinBlendsItsJoints) {
  Pose pose;
  pose.joints = kJoints;
  const SkinMotion skin{kRest, 2, kIndices, kWeights, 2};
  // (1,0,0): joint 1 takes it to (10,1,0). (0,2,0): to (8,0,0). (0,0,3): to (10,0,3).
  EXPECT_EQ(all_positions(skin, pose),
            (std::vector<vec3>{{5.5f, 0.5f, 0.0f}, {6.0f, 0.5f, 0.0f}, {10.0f, 0.0f, 3.0f}}));
  EXPECT_EQ(local_map(skin, pose, 0),
            mat3(vec3(0.5f, 0.5f, 0), vec3(-0.5f, 0.5f, 0), vec3(0, 0, 1)));
}

// Target 0 lifts everything by 1 in z, target 1 stretches vertex 0 in x.
const std::vector<vec3> kDeltas = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1},
                                   {4, 0, 0}, {0, 0, 0}, {0, 0, 0}};
const std::vector<float> kMorphWeights = {2.0f, 0.25f};

TEST(Motion, MorphAddsWeightedDeltas) {
  Pose pose;
  pose.weights = kMorphWeights;
  const MorphMotion morph{kRest, kDeltas, {}};
  EXPECT_EQ(all_positions(morph, pose), (std::vector<vec3>{{2, 0, 2}, {0, 2, 2}, {0, 0, 5}}));
  EXPECT_EQ(local_map(morph, pose, 0), mat3(1.0f));
}

TEST(Motion, MorphComesBeforeSkin) {
  Pose pose;
  pose.weights = kMorphWeights;
  pose.joints = kJoints;
  const MorphMotion morph{kRest, kDeltas, {kRest, 2, kIndices, kWeights, 2}};
  // Morphed (2,0,2), which joint 1 takes to (10,2,2); half of each. And so on.
  EXPECT_EQ(all_positions(morph, pose),
            (std::vector<vec3>{{6, 1, 2}, {6.0f, 0.5f, 2.0f}, {10, 0, 5}}));
  EXPECT_EQ(local_map(morph, pose, 2), linear_part(kJoints[1]));
}

TEST(Motion, KeyframesAreLinearAndHitTheirKeys) {
  const std::vector<vec3> keys = {{0, 0, 0}, {1, 1, 1},          {4, 8, 0},
                                  {1, 1, 5}, {0.1f, 0.2f, 0.3f}, {7, 7, 7}};
  const KeyframeMotion motion{2, keys};
  Pose pose;
  pose.key_fraction = 0.25f;
  EXPECT_EQ(all_positions(motion, pose), (std::vector<vec3>{{1, 2, 0}, {1, 1, 2}}));
  pose.key = 2;
  pose.key_fraction = 0.0f;  // the last key
  EXPECT_EQ(all_positions(motion, pose), (std::vector<vec3>{keys[4], keys[5]}));
  pose.key = 1;
  pose.key_fraction = 1.0f;
  EXPECT_EQ(all_positions(motion, pose), (std::vector<vec3>{keys[4], keys[5]}));
}

TEST(Motion, FreeIsWhatThePoseGives) {
  Pose pose;
  pose.positions = kRest;
  EXPECT_EQ(all_positions(FreeMotion{3}, pose), kRest);
}

TEST(Motion, OnlyRigidDoesNotDeform) {
  EXPECT_FALSE(deforms(RigidMotion{kRest}));
  EXPECT_TRUE(deforms(SkinMotion{}));
  EXPECT_TRUE(deforms(MorphMotion{}));
  EXPECT_TRUE(deforms(KeyframeMotion{}));
  EXPECT_TRUE(deforms(FreeMotion{}));
}

TEST(Motion, BoundsOfNothingAreEmpty) {
  const test::RandomBody body(1, 10, 2);
  for (const Motion& motion : body.motions()) {
    EXPECT_TRUE(bounds(motion, body.pose, {}).empty());
    positions(motion, body.pose, 10, {});  // an empty range at the end is allowed
  }
}

TEST(PoseFits, AcceptsWhatTheMotionNeeds) {
  const test::RandomBody body(2, 10, 4);
  for (const Motion& motion : body.motions()) EXPECT_TRUE(pose_fits(motion, body.pose));
}

TEST(PoseFits, RejectsEachMismatch) {
  const test::RandomBody body(3, 10, 4);
  const auto [rigid, skin, morph, both, keyframes, free] = body.motions();
  Pose pose = body.pose;
  pose.joints = pose.joints.first(body.kJoints - 1);
  EXPECT_FALSE(pose_fits(skin, pose));
  EXPECT_FALSE(pose_fits(both, pose));
  EXPECT_TRUE(pose_fits(morph, pose));
  pose = body.pose;
  pose.weights = pose.weights.first(1);
  EXPECT_FALSE(pose_fits(morph, pose));
  EXPECT_FALSE(pose_fits(both, pose));
  EXPECT_TRUE(pose_fits(skin, pose));
  pose = body.pose;
  pose.positions = pose.positions.first(9);
  EXPECT_FALSE(pose_fits(free, pose));
  EXPECT_TRUE(pose_fits(rigid, pose));
}

TEST(PoseFits, KeyAndFractionMustLieInTheCache) {
  const test::RandomBody body(4, 10, 1);
  const Motion motion = body.motions()[4];
  const auto fits = [&](uint32_t key, float fraction) {
    Pose pose;
    pose.key = key;
    pose.key_fraction = fraction;
    return pose_fits(motion, pose);
  };
  EXPECT_TRUE(fits(body.kKeys - 2, 1.0f));
  EXPECT_TRUE(fits(body.kKeys - 1, 0.0f));
  EXPECT_FALSE(fits(body.kKeys - 1, 0.5f));
  EXPECT_FALSE(fits(body.kKeys, 0.0f));
  EXPECT_FALSE(fits(0xffffffffu, 0.0f));
  EXPECT_FALSE(fits(0, -0.1f));
  EXPECT_FALSE(fits(0, 1.1f));
  EXPECT_FALSE(fits(0, std::numeric_limits<float>::quiet_NaN()));
}

TEST(ValidateMotion, FindsEachFault) {
  const test::RandomBody body(5, 10, 4);
  for (const Motion& motion : body.motions()) EXPECT_EQ(validate(motion), "");

  SkinMotion skin = body.skin();
  skin.joint_count = 1;
  EXPECT_NE(validate(skin), "");
  EXPECT_NE(validate(MorphMotion{body.rest, body.deltas, skin}), "");
  skin = body.skin();
  skin.weights = skin.weights.first(39);
  EXPECT_NE(validate(skin), "");
  skin = body.skin();
  skin.influences = 3;
  EXPECT_NE(validate(skin), "");
  skin.influences = 0;
  EXPECT_NE(validate(skin), "");

  const std::span<const vec3> points(body.deltas);
  EXPECT_NE(validate(MorphMotion{body.rest, points.first(11), {}}), "");
  EXPECT_NE(validate(MorphMotion{{}, points, {}}), "");
  EXPECT_NE(validate(KeyframeMotion{10, points.first(11)}), "");
  EXPECT_NE(validate(KeyframeMotion{10, {}}), "");
  EXPECT_NE(validate(KeyframeMotion{0, points}), "");
}

}  // namespace
}  // namespace sinew
