#include "sinew/svo/thesis/thesis_voxels.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kGrain = 4096;  // voxels

// The skin of a motion; nullptr if it has none.
const SkinMotion* skin_of(const Motion& motion) {
  if (const auto* const skin = std::get_if<SkinMotion>(&motion)) return skin;
  const auto* const morph = std::get_if<MorphMotion>(&motion);
  return morph != nullptr && morph->skin.influences > 0 ? &morph->skin : nullptr;
}

std::span<const vec3> rest_of(const Motion& motion) {
  if (const auto* const rigid = std::get_if<RigidMotion>(&motion)) return rigid->rest;
  if (const auto* const skin = std::get_if<SkinMotion>(&motion)) return skin->rest;
  if (const auto* const morph = std::get_if<MorphMotion>(&motion)) return morph->rest;
  if (const auto* const keys = std::get_if<KeyframeMotion>(&motion)) {
    return keys->keys.first(keys->vertex_count);
  }
  return {};
}

ThesisWeights weights_at(const SkinMotion& skin, uvec3 triangle, vec3 barycentric) {
  ThesisMix mix;
  mix.clear();
  for (int k = 0; k < 3; ++k) {
    const size_t begin = size_t{triangle[k]} * skin.influences;
    for (size_t i = begin; i < begin + skin.influences; ++i) {
      mix.add(skin.joints[i], barycentric[k] * skin.weights[i]);
    }
  }
  return mix.mean();
}

// The voxel of some fragments, all of the same.
ThesisVoxel make_voxel(const VoxelGrid& grid, std::span<const VoxelFragment> fragments,
                       const SvoSource& source, const SkinMotion* skin) {
  const std::span<const vec3> rest = rest_of(source.motion);
  const vec3 center = grid.center(voxel_of(fragments.front().voxel));
  const VoxelFragment* nearest = &fragments.front();
  vec3 nearest_weights(1.0f, 0.0f, 0.0f);
  float least = std::numeric_limits<float>::infinity();
  for (const VoxelFragment& fragment : fragments) {
    if (fragment.triangle == kInside) continue;
    const uvec3 t = source.triangles[fragment.triangle];
    const vec3 w = nearest_on_triangle(center, rest[t.x], rest[t.y], rest[t.z]);
    const vec3 away = w.x * rest[t.x] + w.y * rest[t.y] + w.z * rest[t.z] - center;
    if (!(dot(away, away) < least)) continue;
    least = dot(away, away);
    nearest = &fragment;
    nearest_weights = w;
  }
  ThesisVoxel out{.voxel = nearest->voxel, .normal = nearest->normal, .color = nearest->color};
  if (nearest->triangle == kInside) return out;
  out.material = source.materials.empty() ? uint16_t{0} : source.materials[nearest->triangle];
  if (skin != nullptr) {
    out.skin = weights_at(*skin, source.triangles[nearest->triangle], nearest_weights);
  }
  return out;
}

}  // namespace

uint32_t joint_count(const Motion& motion) {
  const SkinMotion* const skin = skin_of(motion);
  return skin == nullptr ? 0 : skin->joint_count;
}

void ThesisMix::add(uint32_t joint, float weight) {
  if (!(weight > 0.0f)) return;
  for (uint32_t i = 0; i < count_; ++i) {
    if (joints_[i] != joint) continue;
    weights_[i] += weight;
    return;
  }
  if (count_ == kMost) return;  // what more there is cannot weigh much
  joints_[count_] = static_cast<uint16_t>(joint);
  weights_[count_++] = weight;
}

void ThesisMix::add(const ThesisWeights& weights, float share) {
  for (uint32_t k = 0; k < kSvoInfluences; ++k) add(weights.joints[k], share * weights.weights[k]);
}

ThesisWeights ThesisMix::mean() const {
  std::array<uint32_t, kMost> order;
  for (uint32_t i = 0; i < count_; ++i) order[i] = i;
  const uint32_t kept = std::min(count_, kSvoInfluences);
  std::partial_sort(order.begin(), order.begin() + kept, order.begin() + count_,
                    [&](uint32_t a, uint32_t b) {
                      if (weights_[a] != weights_[b]) return weights_[a] > weights_[b];
                      return joints_[a] < joints_[b];
                    });
  float sum = 0.0f;
  for (uint32_t k = 0; k < kept; ++k) sum += weights_[order[k]];
  ThesisWeights out;
  for (uint32_t k = 0; k < kept; ++k) {
    out.joints[k] = joints_[order[k]];
    out.weights[k] = weights_[order[k]] / sum;
  }
  return out;
}

std::vector<ThesisVoxel> make_thesis_voxels(const VoxelSurface& surface, const SvoSource& source) {
  const std::vector<VoxelFragment>& fragments = surface.fragments;
  std::vector<size_t> first;  // fragment of each voxel, and the end
  first.reserve(surface.voxels + 1);
  for (size_t i = 0; i < fragments.size(); ++i) {
    if (i == 0 || fragments[i].voxel != fragments[i - 1].voxel) first.push_back(i);
  }
  first.push_back(fragments.size());
  const SkinMotion* const skin = skin_of(source.motion);
  std::vector<ThesisVoxel> out(first.size() - 1);
  parallel_for(out.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      out[v] =
          make_voxel(surface.grid, {&fragments[first[v]], first[v + 1] - first[v]}, source, skin);
    }
  });
  return out;
}

namespace {

ThesisWeights lattice_weights(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
                              vec3 local) {
  ThesisMix mix;
  mix.clear();
  for (uint32_t k = 0; k < 8 && svo.joints > 0; ++k) {
    const float share = (k & 1 ? local.x : 1.0f - local.x) * (k & 2 ? local.y : 1.0f - local.y) *
                        (k & 4 ? local.z : 1.0f - local.z) / 65535.0f;
    const size_t corner = block.first_corner + cell.corner[k];
    for (uint32_t i = 0; i < kSvoInfluences; ++i) {
      mix.add(svo.joint_palette[block.first_joint + svo.corner_joints[corner][i]],
              share * static_cast<float>(svo.corner_weights[corner][i]));
    }
  }
  return mix.mean();
}

void add_cell(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
              std::vector<ThesisVoxel>& out) {
  const uint32_t place = cell.place;
  const uvec3 first = kBlockSide * uvec3(block.x, block.y, block.z) +
                      kCellSide * uvec3(place & 7, place >> 3 & 7, place >> 6);
  const uint64_t* mask = &svo.bricks[block.first_brick + cell.first_brick];
  for (uint32_t b = 0; b < 8; ++b) {
    if (!(cell.bricks >> b & 1)) continue;
    for (uint64_t rest = *mask++; rest != 0; rest &= rest - 1) {
      const VoxelCode code = 64 * b + static_cast<uint32_t>(std::countr_zero(rest));
      const uvec3 in = place_of(code).min;
      const VoxelAttributes looks = voxel_attributes(svo, block, cell, code);
      out.push_back({.voxel = morton_of(first + in),
                     .skin = lattice_weights(svo, block, cell, (vec3(in) + 0.5f) / 8.0f),
                     .normal = pack_normal(looks.normal),
                     .color = pack_color(looks.color),
                     .material = cell.material});
    }
  }
}

}  // namespace

std::vector<ThesisVoxel> make_thesis_voxels(const Svo& svo) {
  std::vector<ThesisVoxel> out;
  out.reserve(svo.voxel_count());
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    for (uint32_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      add_cell(svo, svo.blocks[b], svo.cells[c], out);
    }
  }
  std::ranges::stable_sort(out, {}, &ThesisVoxel::voxel);
  const auto same = [](const ThesisVoxel& a, const ThesisVoxel& b) { return a.voxel == b.voxel; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

vec3 thesis_point(const ThesisWeights& skin, std::span<const Affine> joints, vec3 p) {
  if (joints.empty()) return p;
  Affine sum(0.0f);
  for (uint32_t k = 0; k < kSvoInfluences; ++k) sum += skin.weights[k] * joints[skin.joints[k]];
  return transform_point(sum, p);
}

vec3 nearest_on_triangle(vec3 p, vec3 a, vec3 b, vec3 c) {
  const vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0f && d2 <= 0.0f) return {1.0f, 0.0f, 0.0f};
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0f && d4 <= d3) return {0.0f, 1.0f, 0.0f};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) {
    const float v = d1 / (d1 - d3);
    return {1.0f - v, v, 0.0f};
  }
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0f && d5 <= d6) return {0.0f, 0.0f, 1.0f};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) {
    const float w = d2 / (d2 - d6);
    return {1.0f - w, 0.0f, w};
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0f, 1.0f - w, w};
  }
  const float scale = 1.0f / (va + vb + vc);
  return {1.0f - (vb + vc) * scale, vb * scale, vc * scale};
}

}  // namespace sinew
