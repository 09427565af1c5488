// Clusters: parts of a body whose boxes follow from a pose alone, without a visit to their
// vertices. Positions are linear in what a pose gives (joint matrices, morph weights). So each
// cluster's contribution to every joint and target is fitted, once, by an affine map of three
// latent coordinates s in [-1, 1]^3 with the rest as an interval; in a pose these maps add up to
// one,
//   position = h0 + h1 s1 + h2 s2 + h3 s3 +- residual,
// and the box is read off the supports of the cluster's hull in s: first-order affine arithmetic
// (J. Stolfi, L. de Figueiredo, "Self-Validated Numerical Methods and Applications", 1997, section
// 3) whose noise symbols are bounded by a polytope of 50 directions, not by a cube.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/motion/motion.h"

namespace sinew {

// Which vertices each cluster has: vertices[first[c] .. first[c + 1]), each once. `first` has one
// entry more than there are clusters.
struct ClusterVertices {
  std::span<const uint32_t> first;
  std::span<const uint32_t> vertices;
};

struct ClusterConfig {
  // Into how many pieces a cluster may be split, 1 to 4: vertices of like weights, near each other.
  // A split is kept only where it makes the boxes of trial poses smaller by a tenth. Each piece
  // takes as long to derive, and as much memory, as a cluster that is not split.
  uint32_t most_pieces = 4;
};

// The upper half of a float: 8 bits of mantissa.
using Bfloat16 = uint16_t;

// What one joint does to a piece, beside the reference joint: the products of its weight w with the
// vertex (q, 1), q against the piece's centre. Row r is (w q_x, w q_y, w q_z, w)[r]
// = affine[r] . (1, s1, s2, s3) +- residual[r], where affine[3][0] is taken with weight_rest added:
// it may act on joints that are far apart.
struct JointFit {
  Bfloat16 affine[4][4];
  Bfloat16 residual[4];
  Bfloat16 weight_rest = 0;
  uint16_t joint = 0;
};
static_assert(sizeof(JointFit) == 44);

// What one morph target does to a piece:
//   delta = target_unit * offset + slope[0] s1 + slope[1] s2 + slope[2] s3 +- residual.
// The offset is fixed-point because it may be much larger than the piece.
struct TargetFit {
  int16_t offset[3];
  Bfloat16 residual_x;
  Bfloat16 slope[3][4];  // x, y, z and one more entry: the residual's y, its z, then 0
  uint16_t target = 0;
};
static_assert(sizeof(TargetFit) == 34);

inline constexpr uint32_t kSupports = 44;
inline constexpr float kSupportUnit = 1.0f / 85.0f;  // the farthest possible is 3

// Vertices that share one fit: a cluster has one piece, or a few.
// Rest position = center + axes[0] s1 + axes[1] s2 + axes[2] s3.
struct ClusterPiece {
  vec3 center{0.0f};
  vec3 axes[3] = {};
  float pad = 0.0f;  // of the box, against sum_j(|M_j||p| + |t_j|): every rounding in positions()
                     // and here, and the weights' distance from a sum of 1
  float target_unit = 0.0f;
  uint32_t first_joint = 0;
  uint32_t first_target = 0;
  uint16_t joints = 0;           // JointFits
  uint16_t targets = 0;          // TargetFits
  int32_t reference_joint = -1;  // whose share is 1 - the others'; -1: not skinned
  // How far the hull reaches, in units of kSupportUnit, along (0, +-1, +-1), (+-1, 0, +-1),
  // (+-1, +-1, 0); (+-1, +-1, +-1); (0, +-2, +-1), (+-2, 0, +-1), (+-2, +-1, 0); (0, +-1, +-2),
  // (+-1, 0, +-2), (+-1, +-2, 0); + before -, the first coordinate fastest. Along the axes it is 1.
  uint8_t support[kSupports] = {};
};
static_assert(sizeof(ClusterPiece) == 116);

// What is known at rest of a body's clusters. Linear buffers, indices only; constant.
struct ClusterBounds {
  uint32_t clusters = 0;
  // Skin and morph: cluster c has pieces [first_piece[c], first_piece[c + 1]); entry `clusters + 1`
  // ends the pieces of the body as a whole.
  std::vector<uint32_t> first_piece;
  std::vector<ClusterPiece> pieces;
  std::vector<JointFit> joints;
  std::vector<TargetFit> targets;
  // Rigid: the rest boxes, then the body's. Keyframes: the same for each key in turn.
  std::vector<Box> boxes;

  size_t bytes() const;  // of all buffers
};

// Whether boxes follow from a pose at all. False for FreeMotion, of which nothing is known but its
// vertices, and for more than 65,535 morph targets.
bool derivable(const Motion& motion);

// Once a body, in parallel; the same bits for every thread count. The motion must be derivable, and
// valid.
ClusterBounds make_cluster_bounds(const Motion& motion, const ClusterVertices& vertices,
                                  const ClusterConfig& config = {});

// Boxes of the clusters [begin, begin + out.size()) in the pose, in the object's space (before
// placement). Each contains every finite position that positions() gives for its vertices, bit for
// bit. Empty if all of the cluster's rest positions are not finite; not finite if the pose is not,
// or if products of the pose and the body overflow. Touches no vertex and allocates nothing.
void derive_bounds(const ClusterBounds& bounds, const Motion& motion, const Pose& pose,
                   uint32_t begin, std::span<Box> out);

// The same for all clusters together, without asking each: a microsecond or two.
Box derive_body_bounds(const ClusterBounds& bounds, const Motion& motion, const Pose& pose);

}  // namespace sinew
