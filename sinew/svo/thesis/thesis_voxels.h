// Voxels with joints and weights of their own, as the thesis has them: what both of its methods
// (thesis.h, thesis_corners.h) are made from.
// Based on: D. Bautembach, "Animated Sparse Voxel Octrees", Hamburg 2011, section 3.3.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/affine.h"
#include "sinew/svo/make/fragments.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {

// Joints of positive weight first, heaviest first; unused ones have joint 0 and weight 0. Weights
// sum to 1, or are all 0 where nothing skins.
struct ThesisWeights {
  std::array<uint16_t, kSvoInfluences> joints{};
  std::array<float, kSvoInfluences> weights{};
};

struct ThesisVoxel {
  VoxelMorton voxel = 0;
  ThesisWeights skin{};
  uint16_t normal = 0;  // see pack_normal
  uint16_t color = 0;   // see pack_color
  uint16_t material = 0;
};

// Means of weights: joints are summed up, then the heaviest four are kept and made to sum to 1.
class ThesisMix {
 public:
  void clear() { count_ = 0; }
  void add(const ThesisWeights& weights, float share);
  void add(uint32_t joint, float weight);
  ThesisWeights mean() const;

 private:
  // Eight corners or children, or three vertices of as many influences as a file may have.
  static constexpr uint32_t kMost = 64;
  uint32_t count_ = 0;
  std::array<uint16_t, kMost> joints_;
  std::array<float, kMost> weights_;
};

// One voxel for each different one of the surface, in Morton order. Attributes are of the triangle
// nearest to the voxel's centre, weights of its point nearest to it. Morph targets rest: the thesis
// has none.
std::vector<ThesisVoxel> make_thesis_voxels(const VoxelSurface& surface, const SvoSource& source);

// The same from an octree, whose source is not known: weights are those of the skin lattice at the
// voxel's centre. Where copies of a cell hold the same voxel, that of the first one.
std::vector<ThesisVoxel> make_thesis_voxels(const Svo& svo);

// sum_k weight_k * joints[joint_k] * (p, 1); p itself if there are no joints.
vec3 thesis_point(const ThesisWeights& skin, std::span<const Affine> joints, vec3 p);

// The joints that the source's motion wants in a pose; 0: it is not skinned.
uint32_t joint_count(const Motion& motion);

// Barycentric weights of the point of triangle (a, b, c) nearest to p.
// Based on: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
vec3 nearest_on_triangle(vec3 p, vec3 a, vec3 b, vec3 c);

}  // namespace sinew
