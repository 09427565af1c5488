// Moves the corners of blocks, four lanes a corner as in motion/skin.h.
#include "sinew/svo/posed.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/motion/skin.h"
#include "sinew/svo/corners.h"

namespace sinew {
namespace {

bool finite(const Affine& m) {
  const vec3 sum = m[0] + m[1] + m[2] + m[3];
  return std::isfinite(sum.x + sum.y + sum.z);
}

uint32_t begin_of(const Svo& svo, uint32_t block) {
  return svo.blocks[block].first_corner;
}
uint32_t count_of(const Svo& svo, uint32_t block) {
  return svo.blocks[block + 1].first_corner - svo.blocks[block].first_corner;
}

void place_at_rest(const Svo& svo, uint32_t block, std::span<vec3> out) {
  const SvoBlock& b = svo.blocks[block];
  for (size_t i = 0; i < out.size(); ++i) {
    out[i] = corner_rest(svo.grid, b, svo.corner_places[b.first_corner + i]);
  }
}

// As MorphMotion does: target by target, those of weight 0 skipped.
void add_targets(const Svo& svo, uint32_t block, const Pose& pose, std::span<vec3> out) {
  const uint32_t end = svo.blocks[block + 1].first_target;
  for (uint32_t t = svo.blocks[block].first_target; t < end; ++t) {
    const SvoTarget& target = svo.targets[t];
    const float weight = pose.weights[target.target];
    if (weight == 0.0f) continue;
    for (size_t i = 0; i < out.size(); ++i) {
      out[i] += weight * corner_delta(target.unit, svo.deltas[target.first_delta + i]);
    }
  }
}

Float4 cross(Float4 a, Float4 b) {
  const Float4 a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3);
  const Float4 a_zxy = __builtin_shufflevector(a, a, 2, 0, 1, 3);
  const Float4 b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
  const Float4 b_zxy = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  return a_yzx * b_zxy - a_zxy * b_yzx;
}

mat3 cofactor(const PackedAffine& m) {
  const Float4 y = __builtin_shufflevector(m.a, m.b, 3, 4, 5, 5);
  const Float4 z = __builtin_shufflevector(m.b, m.c, 2, 3, 4, 4);
  const Float4 columns[3] = {cross(y, z), cross(z, m.a), cross(m.a, y)};
  mat3 out;
  for (int c = 0; c < 3; ++c) std::memcpy(&out[c], &columns[c], sizeof out[c]);
  return out;
}

// As SkinMotion does: all influences in their order, from zero.
void skin(const Svo& svo, uint32_t block, const Pose& pose, std::span<vec3> positions,
          std::span<mat3> cofactors) {
  const SvoBlock& b = svo.blocks[block];
  const uint16_t* const palette = svo.joint_palette.data() + b.first_joint;
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto& joints = svo.corner_joints[b.first_corner + i];
    const auto& weights = svo.corner_weights[b.first_corner + i];
    PackedAffine sum;
    for (uint32_t k = 0; k < kSvoInfluences; ++k) {
      const float weight = corner_weight(weights[k]);
      const float* const joint = &pose.joints[palette[joints[k]]][0].x;
      sum.a += weight * load4(joint);
      sum.b += weight * load4(joint + 4);
      sum.c += weight * load4(joint + 8);
    }
    positions[i] = transform_point(sum, positions[i]);
    cofactors[i] = cofactor(sum);
  }
}

// Weights of the eight corners for a point at `local`.
template <class T>
T trilinear(const T (&at)[8], vec3 local) {
  const auto mix = [](const T& a, const T& b, float t) { return a + t * (b - a); };
  const T z0 = mix(mix(at[0], at[1], local.x), mix(at[2], at[3], local.x), local.y);
  const T z1 = mix(mix(at[4], at[5], local.x), mix(at[6], at[7], local.x), local.y);
  return mix(z0, z1, local.z);
}

}  // namespace

bool pose_fits(const Svo& svo, const Pose& pose) {
  return pose.joints.size() >= svo.joints && pose.weights.size() == svo.morph_targets &&
         std::ranges::all_of(pose.joints.first(svo.joints), finite) &&
         std::ranges::all_of(pose.weights, [](float w) { return std::isfinite(w); });
}

void PosedSvo::set_pose(const SvoMotion& motion, const Pose& pose) {
  const Svo& svo = *motion.svo;
  SINEW_DCHECK(sinew::pose_fits(svo, pose));
  // Another motion may come to lie where one was.
  const bool same = motion_ == &motion && made_.size() == svo.block_count() &&
                    positions_.size() == svo.corner_places.size() &&
                    cofactors_.size() == (svo.joints > 0 ? svo.corner_places.size() : 0);
  if (!same) {
    made_.assign(svo.block_count(), 0);
    positions_ = Buffer<vec3>(svo.corner_places.size());
    cofactors_ = Buffer<mat3>(svo.joints > 0 ? svo.corner_places.size() : 0);
    boxes_ = Buffer<Box>(motion.first_block + svo.block_count());
    boxes_state_ = std::make_unique<std::atomic<uint64_t>>(0);
    epoch_ = 0;
  }
  motion_ = &motion;
  pose_ = pose;
  // What nothing moves is made once for all poses.
  if (epoch_ > 0 && svo.joints == 0 && svo.morph_targets == 0) return;
  if (++epoch_ == 0) {
    std::ranges::fill(made_, 0);
    boxes_state_->store(0);
    epoch_ = 1;
  }
}

Box PosedSvo::block_bounds(uint32_t block) const {
  Box box;
  derive_bounds(motion_->blocks, motion_->shape(), pose_, block, std::span(&box, 1));
  return box;
}

// The whole's, by the regions of its joints: no block is asked.
Box PosedSvo::root_bounds() const {
  Box box = derive_body_bounds(motion_->blocks, motion_->shape(), pose_);
  if (motion_->first_block > 0) return box;
  const Box block = block_bounds(0);  // the root is a block
  return {glm::max(box.min, block.min), glm::min(box.max, block.max)};
}

// The slow way to what fill_boxes() writes.
Box PosedSvo::union_below(uint32_t node) const {
  if (node >= motion_->first_block) return block_bounds(node - motion_->first_block);
  const SvoNode& parent = svo().nodes[node];
  Box box;
  for (uint32_t c = 0; c < parent.count; ++c) box.extend(union_below(parent.first + c));
  return box;
}

void PosedSvo::fill_boxes() const {
  const uint32_t first = motion_->first_block;
  derive_bounds(motion_->blocks, motion_->shape(), pose_, 0,
                {boxes_.data() + first, boxes_.size() - first});
  for (uint32_t node = first; node-- > 0;) {
    const SvoNode& parent = svo().nodes[node];
    boxes_[node] = {};
    for (uint32_t c = 0; c < parent.count; ++c) boxes_[node].extend(boxes_[parent.first + c]);
  }
}

Box PosedSvo::bounds(uint32_t node) const {
  if (node == 0) return root_bounds();
  const uint64_t filling = uint64_t{epoch_} * 2, filled = filling + 1;
  uint64_t state = boxes_state_->load(std::memory_order_acquire);
  if (state == filled) return boxes_[node];
  // Nobody waits for who fills them.
  if (state == filling) return union_below(node);
  if (!boxes_state_->compare_exchange_strong(state, filling)) return union_below(node);
  fill_boxes();
  boxes_state_->store(filled, std::memory_order_release);
  return boxes_[node];
}

void PosedSvo::make_block(uint32_t block) {
  if (is_made(block)) return;
  const Svo& svo = *motion_->svo;
  const size_t first = begin_of(svo, block), count = count_of(svo, block);
  const std::span<vec3> positions(positions_.data() + first, count);
  place_at_rest(svo, block, positions);
  if (svo.morph_targets > 0) add_targets(svo, block, pose_, positions);
  if (svo.joints > 0) skin(svo, block, pose_, positions, {cofactors_.data() + first, count});
  made_[block] = epoch_;
}

PosedBlock PosedSvo::block(uint32_t block) const {
  SINEW_DCHECK(is_made(block));
  const Svo& svo = *motion_->svo;
  const size_t first = begin_of(svo, block), count = count_of(svo, block);
  PosedBlock out{{positions_.data() + first, count}, {}};
  if (svo.joints > 0) out.cofactors = {cofactors_.data() + first, count};
  return out;
}

uint32_t PosedSvo::blocks_made() const {
  return static_cast<uint32_t>(std::ranges::count(made_, epoch_));
}

vec3 map_point(const SvoCell& cell, const PosedBlock& block, vec3 local) {
  vec3 at[8];
  for (int k = 0; k < 8; ++k) at[k] = block.positions[cell.corner[k]];
  return trilinear(at, local);
}

mat3 map_normals(const SvoCell& cell, const PosedBlock& block, vec3 local) {
  if (block.cofactors.empty()) return mat3(1.0f);
  mat3 at[8];
  for (int k = 0; k < 8; ++k) at[k] = block.cofactors[cell.corner[k]];
  return trilinear(at, local);
}

}  // namespace sinew
