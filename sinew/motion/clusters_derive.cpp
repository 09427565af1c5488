// Boxes of clusters in a pose: adds up the fits of clusters.h, then reads the box off the hull.
// Four lanes hold x, y, z (and something finite) with the compiler's own vectors; see skin.h.
#include <bit>

#include "sinew/base/check.h"
#include "sinew/motion/clusters.h"
#include "sinew/motion/keyframes.h"
#include "sinew/motion/skin.h"

namespace sinew {
namespace {

using Int4 = int32_t __attribute__((vector_size(16)));
using Ushort8 = uint16_t __attribute__((vector_size(16)));
using Byte16 = uint8_t __attribute__((vector_size(16)));

// So small that only underflow needs it.
constexpr float kLeastPad = 1e-37f;

Float4 splat(float x) {
  return Float4{x, x, x, x};
}
Float4 absolute(Float4 x) {
  return Float4(Int4(x) & 0x7fffffff);
}
Float4 smaller(Float4 a, Float4 b) {
  return a < b ? a : b;
}
Float4 larger(Float4 a, Float4 b) {
  return a > b ? a : b;
}
// If either is NaN, so is the result: a pose that is not finite must show.
Float4 smaller_or_nan(Float4 a, Float4 b) {
  return a == a ? smaller(a, b) : a;
}
Float4 larger_or_nan(Float4 a, Float4 b) {
  return a == a ? larger(a, b) : a;
}
Float4 load3(const vec3& v) {
  return Float4{v.x, v.y, v.z, 0.0f};
}

// Eight consecutive 16-bit values, each in the upper half of its lane.
struct Words {
  Int4 low, high;
};
Words load8(const void* values) {
  Ushort8 bits;
  std::memcpy(&bits, values, sizeof bits);
  constexpr Ushort8 kZero{};
  return {Int4(__builtin_shufflevector(kZero, bits, 0, 8, 1, 9, 2, 10, 3, 11)),
          Int4(__builtin_shufflevector(kZero, bits, 4, 12, 5, 13, 6, 14, 7, 15))};
}

Float4 decode4(const Bfloat16* values) {
  Ushort8 bits{};
  std::memcpy(&bits, values, 4 * sizeof *values);
  return Float4(__builtin_shufflevector(Ushort8{}, bits, 0, 8, 1, 9, 2, 10, 3, 11));
}
float decode(Bfloat16 value) {
  return std::bit_cast<float>(uint32_t{value} << 16);
}

// In each lane the byte table[index], 0 where bit 7 of the index is set; else it is 0 to 15.
Int4 look_up(const uint8_t* table, Int4 index) {
  Byte16 bytes;
  std::memcpy(&bytes, table, sizeof bytes);
#ifdef __SSSE3__
  using Char16 = char __attribute__((vector_size(16)));
  constexpr int kNone = static_cast<int>(0x80808000u);
  return Int4(__builtin_ia32_pshufb128(Char16(bytes), Char16(index | kNone)));
#else
  Int4 out;
  for (int lane = 0; lane < 4; ++lane) out[lane] = index[lane] & 128 ? 0 : bytes[index[lane]];
  return out;
#endif
}

// A map (1, s1, s2, s3) -> space: column 0 is where s = 0 goes.
struct LatentMap {
  Float4 column[4] = {};
};

// The columns x, y, z, t of an affine map.
struct Columns {
  Float4 x, y, z, t;
};

Columns load_columns(const Affine& m) {
  const float* const values = &m[0].x;
  const Float4 last = load4(values + 8);
  return {load4(values), load4(values + 3), load4(values + 6),
          __builtin_shufflevector(last, last, 1, 2, 3, 3)};
}
Float4 linear(const Columns& m, Float4 v) {
  return m.x * v[0] + m.y * v[1] + m.z * v[2];
}
Columns absolute(const Columns& m) {
  return {absolute(m.x), absolute(m.y), absolute(m.z), absolute(m.t)};
}

// How far the hull reaches along the row (x[lane], y[lane], z[lane]) in each lane, and along its
// opposite. Let its magnitudes be a >= b >= c. The direction is a sum of the three stored ones
// nearest to it, with factors that are not negative: of `axis` and `edge` only one counts. Supports
// are convex, so the same sum of stored reaches is an upper bound.
struct Support {
  Float4 forth, back;
};
Support support(const uint8_t (&table)[kSupports], Float4 x, Float4 y, Float4 z) {
  const Float4 ax = absolute(x), ay = absolute(y), az = absolute(z);
  const Float4 low = smaller(ax, ay), high = larger(ax, ay);
  const Float4 a = larger(high, az), b = larger(low, smaller(high, az)), c = smaller(low, az);
  const Float4 bend = (a - b) - (b - c);
  const Float4 axis = larger(bend, Float4{}), edge = larger(-bend, Float4{}) * kSupportUnit;
  const Float4 slant = smaller(a - b, b - c) * kSupportUnit, corner = c * kSupportUnit;

  const Int4 nx = Int4(Int4(x) < 0) & 1, ny = Int4(Int4(y) < 0) & 1, nz = Int4(Int4(z) < 0) & 1;
  const Int4 no_x = nz * 2 + ny, no_y = nz * 2 + nx + 4, no_z = ny * 2 + nx + 8;
  const Int4 at = az <= low ? no_z : (ax <= ay ? no_x : no_y);
  const Int4 second_longer = az <= low ? ay > ax : (ax <= ay ? az > ay : az > ax);
  const Int4 corner_at = nz * 4 + ny * 2 + nx;
  const auto value = [&](Int4 flip_two, Int4 flip_three) {
    const Int4 place = at ^ flip_two;
    const Int4 edges = look_up(table, place);
    const Int4 corners = look_up(table + 12, corner_at ^ flip_three);
    const Int4 slants = look_up(table + 20, place | (second_longer & 128)) |
                        look_up(table + 28, (place + 4) | (~second_longer & 128));
    return axis + edge * __builtin_convertvector(edges, Float4) +
           slant * __builtin_convertvector(slants, Float4) +
           corner * __builtin_convertvector(corners, Float4);
  };
  return {value(Int4{}, Int4{}), value(Int4{} + 3, Int4{} + 7)};
}

// The piece before its skin: p = map(s) +- residual, |p| <= reach.
struct Morphed {
  LatentMap delta;  // what the targets add to the rest position
  Float4 residual{};
  Float4 delta_reach{};  // of the targets' sum
  bool any = false;
};

Morphed add_targets(const ClusterPiece& piece, const ClusterBounds& bounds, const Pose& pose) {
  Morphed out;
  const TargetFit* const begin = bounds.targets.data() + piece.first_target;
  for (const TargetFit* fit = begin; fit < begin + piece.targets; ++fit) {
    const float weight = pose.weights[fit->target];
    if (weight == 0.0f) continue;
    out.any = true;
    const Words front = load8(fit->offset), back = load8(fit->slope[1]);
    const Float4 offset =
        piece.target_unit * __builtin_convertvector(front.low >> 16, Float4);  // lane 3: anything
    const Float4 slope[3] = {Float4(front.high), Float4(back.low), Float4(back.high)};
    out.delta.column[0] += weight * offset;
    Float4 reach = absolute(offset);
    for (int k = 0; k < 3; ++k) {
      out.delta.column[k + 1] += weight * slope[k];
      reach += absolute(slope[k]);
    }
    const Float4 residual{Float4(front.low)[3], slope[0][3], slope[1][3], 0.0f};
    const Float4 magnitude = absolute(splat(weight));
    out.residual += magnitude * residual;
    out.delta_reach += magnitude * (reach + residual);
  }
  return out;
}

// The piece in the pose: position = map(s) +- residual, with the magnitudes that roundings are
// relative to.
struct Posed {
  LatentMap map;
  Float4 residual{};
  Float4 magnitude{};
};

Posed rest_in_space(const ClusterPiece& piece, const Morphed& morphed) {
  Posed out;
  out.map.column[0] = load3(piece.center);
  for (int k = 0; k < 3; ++k) out.map.column[k + 1] = load3(piece.axes[k]);
  for (const Float4& column : out.map.column) out.magnitude += absolute(column);
  if (!morphed.any) return out;
  for (int k = 0; k < 4; ++k) out.map.column[k] += morphed.delta.column[k];
  out.magnitude += morphed.delta_reach;
  out.residual = morphed.residual;
  return out;
}

// Adds one more joint's share: its map against the reference joint's, times its fitted products.
void add_joint(const JointFit& fit, const Columns& difference, const Morphed& morphed, Posed& out) {
  const Columns size = absolute(difference);
  const Words front = load8(fit.affine[0]), back = load8(fit.affine[2]);
  Float4 row[4] = {Float4(front.low), Float4(front.high), Float4(back.low), Float4(back.high)};
  row[3] += Float4{decode(fit.weight_rest), 0.0f, 0.0f, 0.0f};
  for (int k = 0; k < 4; ++k) {
    out.map.column[k] += difference.x * row[0][k] + difference.y * row[1][k] +
                         difference.z * row[2][k] + difference.t * row[3][k];
  }
  const Float4 residual = decode4(fit.residual);
  out.residual += linear(size, residual) + size.t * residual[3];
  if (!morphed.any) return;
  // The weight is row[3] over s: its value at s = 0, give or take the spread.
  const Float4 sizes = absolute(row[3]);
  const float middle = row[3][0], spread = sizes[1] + sizes[2] + sizes[3] + residual[3];
  for (int k = 0; k < 4; ++k) {
    out.map.column[k] += middle * linear(difference, morphed.delta.column[k]);
  }
  out.residual += linear(size, sizes[0] * morphed.residual + spread * morphed.delta_reach);
}

// sum_j w_j M_j p = M_r p + sum_(j != r) w_j (M_j - M_r) p, r the reference joint.
Posed skinned(const ClusterPiece& piece, const Morphed& morphed, const Posed& rest,
              const ClusterBounds& bounds, const Pose& pose) {
  Columns reference = load_columns(pose.joints[piece.reference_joint]);
  const Columns size = absolute(reference);
  Posed out;
  out.magnitude = linear(size, rest.magnitude) + size.t;
  if (morphed.any) out.residual = linear(size, rest.residual);
  const Float4 center = load3(piece.center);
  reference.t += linear(reference, center);
  out.map.column[0] = reference.t;
  if (morphed.any) out.map.column[0] += linear(reference, morphed.delta.column[0]);
  for (int k = 1; k < 4; ++k) out.map.column[k] = linear(reference, rest.map.column[k]);

  const JointFit* const begin = bounds.joints.data() + piece.first_joint;
  for (const JointFit* fit = begin; fit < begin + piece.joints; ++fit) {
    Columns joint = load_columns(pose.joints[fit->joint]);
    const Columns joint_size = absolute(joint);
    out.magnitude += linear(joint_size, rest.magnitude) + joint_size.t;
    joint.t += linear(joint, center);
    const Columns difference{joint.x - reference.x, joint.y - reference.y, joint.z - reference.z,
                             joint.t - reference.t};
    add_joint(*fit, difference, morphed, out);
  }
  return out;
}

void extend_by_piece(const ClusterPiece& piece, const ClusterBounds& bounds, const Pose& pose,
                     Float4& low, Float4& high) {
  const Morphed morphed = piece.targets > 0 ? add_targets(piece, bounds, pose) : Morphed{};
  Posed posed = rest_in_space(piece, morphed);
  if (piece.reference_joint >= 0) posed = skinned(piece, morphed, posed, bounds, pose);
  const LatentMap& map = posed.map;
  const Support reach = support(piece.support, map.column[1], map.column[2], map.column[3]);
  const Float4 wider = posed.residual + piece.pad * posed.magnitude + kLeastPad;
  low = smaller_or_nan(low, map.column[0] - reach.back - wider);
  high = larger_or_nan(high, map.column[0] + reach.forth + wider);
}

Box box_of_pieces(const ClusterBounds& bounds, const Pose& pose, uint32_t first, uint32_t end) {
  Box box;
  Float4 low = load3(box.min), high = load3(box.max);
  for (uint32_t p = first; p < end; ++p) extend_by_piece(bounds.pieces[p], bounds, pose, low, high);
  box.min = vec3(low[0], low[1], low[2]);
  box.max = vec3(high[0], high[1], high[2]);
  return box;
}

// The formula of position(), which is monotonic in both keys even in float: no pad is needed.
Box between_keys(const Box& a, const Box& b, float u) {
  if (a.empty() || b.empty()) return {};
  return {(1.0f - u) * a.min + u * b.min, (1.0f - u) * a.max + u * b.max};
}

// `which` may be bounds.clusters: the whole body.
Box derive_one(const ClusterBounds& bounds, const Motion& motion, const Pose& pose,
               uint32_t which) {
  if (const auto* cache = std::get_if<KeyframeMotion>(&motion)) {
    if (cache->vertex_count == 0) return {};
    const size_t stride = size_t{bounds.clusters} + 1;
    const uint32_t next = std::min(pose.key + 1, key_count(*cache) - 1);
    return between_keys(bounds.boxes[pose.key * stride + which],
                        bounds.boxes[next * stride + which], pose.key_fraction);
  }
  if (std::holds_alternative<RigidMotion>(motion)) return bounds.boxes[which];
  return box_of_pieces(bounds, pose, bounds.first_piece[which], bounds.first_piece[which + 1]);
}

}  // namespace

void derive_bounds(const ClusterBounds& bounds, const Motion& motion, const Pose& pose,
                   uint32_t begin, std::span<Box> out) {
  SINEW_CHECK(derivable(motion));
  SINEW_DCHECK(pose_fits(motion, pose));
  SINEW_CHECK(begin + out.size() <= bounds.clusters);
  for (uint32_t i = 0; i < out.size(); ++i) out[i] = derive_one(bounds, motion, pose, begin + i);
}

Box derive_body_bounds(const ClusterBounds& bounds, const Motion& motion, const Pose& pose) {
  SINEW_CHECK(derivable(motion));
  SINEW_DCHECK(pose_fits(motion, pose));
  return derive_one(bounds, motion, pose, bounds.clusters);
}

}  // namespace sinew
