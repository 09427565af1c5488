// Frame by principal axes, fits by least squares whose residual intervals are then centred.
#include "sinew/motion/clusters_fit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "sinew/motion/morph.h"

namespace sinew {
namespace {

using glm::dmat3;
using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

constexpr double kRounding = 0x1p-24;  // of one float operation, relative

double widen(Bfloat16 bits) {
  return std::bit_cast<float>(uint32_t{bits} << 16);
}
Bfloat16 round_to_bfloat16(double value) {
  const uint32_t bits = std::bit_cast<uint32_t>(static_cast<float>(value));
  return static_cast<Bfloat16>((bits + 0x7fff + ((bits >> 16) & 1)) >> 16);
}
// For values that are not negative.
Bfloat16 round_up_to_bfloat16(double value) {
  if (value == 0.0) return 0;
  const float above = std::nextafter(static_cast<float>(value * (1.0 + 1e-6)), INFINITY);
  return static_cast<Bfloat16>((std::bit_cast<uint32_t>(above) + 0xffff) >> 16);
}

// Eigenvectors of a symmetric matrix, by cyclic Jacobi rotations; columns are orthonormal.
dmat3 principal_axes(dmat3 m) {
  dmat3 axes(1.0);
  const double negligible = 1e-14 * (m[0][0] + m[1][1] + m[2][2]);
  for (int sweep = 0; sweep < 12; ++sweep) {
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      if (std::abs(m[p][q]) <= negligible) continue;
      const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      dmat3 rotation(1.0);
      rotation[p][p] = rotation[q][q] = c;
      rotation[q][p] = s;
      rotation[p][q] = -s;
      m = glm::transpose(rotation) * m * rotation;
      axes = axes * rotation;
    }
  }
  return axes;
}

// Position = center + axes * s, exactly in double; s in [-1, 1]^3.
struct Frame {
  vec3 center{0.0f};
  vec3 axes[3] = {};
  std::vector<dvec3> latent;  // s of each vertex
};

dmat3 frame_axes(const FitSource& source, std::span<const uint32_t> vertices) {
  dvec3 mean(0.0);
  for (const uint32_t v : vertices) mean += dvec3(source.rest[v]);
  mean /= double(vertices.size());
  dmat3 covariance(0.0);
  for (const uint32_t v : vertices) {
    const dvec3 d = dvec3(source.rest[v]) - mean;
    covariance += glm::outerProduct(d, d);
  }
  return principal_axes(covariance);
}

Frame make_frame(const FitSource& source, std::span<const uint32_t> vertices) {
  // Thinner hulls would make `latent` ill-conditioned.
  constexpr double kLeastThickness = 1e-3;
  const dmat3 axes = frame_axes(source, vertices);
  dvec3 low(INFINITY), high(-INFINITY);
  for (const uint32_t v : vertices) {
    const dvec3 along = glm::transpose(axes) * dvec3(source.rest[v]);
    low = glm::min(low, along);
    high = glm::max(high, along);
  }
  Frame frame;
  frame.center = vec3(axes * (0.5 * (low + high)));
  frame.latent.assign(vertices.size(), dvec3(0.0));
  dvec3 half(0.0);
  for (const uint32_t v : vertices) {
    const dvec3 q = dvec3(source.rest[v]) - dvec3(frame.center);
    half = glm::max(half, glm::abs(glm::transpose(axes) * q));
  }
  const double widest = std::max({half.x, half.y, half.z});
  if (widest == 0.0) return frame;  // a single point
  // More than the rounding of the axes to float can turn them out of the hull.
  half = glm::max(half, kLeastThickness * widest) * (1.0 + 1e-5) + 4e-7 * widest;
  for (int k = 0; k < 3; ++k) frame.axes[k] = vec3(half[k] * axes[k]);
  const dmat3 to_latent =
      glm::inverse(dmat3(dvec3(frame.axes[0]), dvec3(frame.axes[1]), dvec3(frame.axes[2])));
  for (size_t i = 0; i < vertices.size(); ++i) {
    const dvec3 q = dvec3(source.rest[vertices[i]]) - dvec3(frame.center);
    frame.latent[i] = to_latent * q;
  }
  return frame;
}

// In the order that ClusterPiece::support tells.
dvec3 support_direction(uint32_t index) {
  const auto sign = [&](uint32_t bit) { return index & bit ? -1.0 : 1.0; };
  if (index >= 12 && index < 20) {
    index -= 12;
    return {sign(1), sign(2), sign(4)};
  }
  const uint32_t kind = index < 12 ? 0 : (index - 8) / 12;  // edge, long first, long second
  if (kind > 0) index = (index - 20) % 12;
  const uint32_t without = index / 4, first = without == 0 ? 1 : 0, second = without == 2 ? 1 : 2;
  dvec3 direction(0.0);
  direction[first] = (kind == 1 ? 2.0 : 1.0) * sign(1);
  direction[second] = (kind == 2 ? 2.0 : 1.0) * sign(2);
  return direction;
}

void store_support(std::span<const dvec3> latent, uint8_t (&out)[kSupports]) {
  constexpr double kUnits = 1.0 / kSupportUnit * (1.0 + 1e-6);
  double x[kSupports], y[kSupports], z[kSupports], most[kSupports];
  for (uint32_t i = 0; i < kSupports; ++i) {
    const dvec3 direction = support_direction(i);
    x[i] = direction.x, y[i] = direction.y, z[i] = direction.z;
    most[i] = -INFINITY;
  }
  for (const dvec3& s : latent) {
    for (uint32_t i = 0; i < kSupports; ++i) {
      const double along = x[i] * s.x + y[i] * s.y + z[i] * s.z;
      most[i] = most[i] < along ? along : most[i];
    }
  }
  for (uint32_t i = 0; i < kSupports; ++i) {
    out[i] = static_cast<uint8_t>(std::clamp(std::ceil(most[i] * kUnits), 0.0, 255.0));
  }
}

// Fits affine functions of s to values at the vertices.
class AffineFitter {
 public:
  explicit AffineFitter(std::span<const dvec3> latent) : latent_(latent) {
    constexpr double kRidge = 1e-6;  // holds slopes along which the vertices do not vary
    dmat4 normal(0.0);
    for (const dvec3 s : latent) normal += glm::outerProduct(dvec4(1.0, s), dvec4(1.0, s));
    for (int k = 0; k < 4; ++k) normal[k][k] += kRidge * double(latent.size());
    inverse_ = glm::inverse(normal);
  }

  struct Row {
    std::array<Bfloat16, 3> slope;
    double middle = 0.0;  // of what the slopes leave: the best offset
  };
  Row fit(std::span<const double> values) const {
    dvec4 moment(0.0);
    for (size_t i = 0; i < values.size(); ++i) moment += values[i] * dvec4(1.0, latent_[i]);
    const dvec4 best = inverse_ * moment;
    Row row;
    for (int k = 0; k < 3; ++k) row.slope[k] = round_to_bfloat16(best[k + 1]);
    const auto [low, high] = left_by_slopes(values, row);
    row.middle = 0.5 * (low + high);
    return row;
  }

  // What remains of the values with this offset, rounded up.
  Bfloat16 residual(std::span<const double> values, const Row& row, double offset) const {
    const auto [low, high] = left_by_slopes(values, row);
    return round_up_to_bfloat16(std::max({offset - low, high - offset, 0.0}));
  }

 private:
  std::pair<double, double> left_by_slopes(std::span<const double> values, const Row& row) const {
    const dvec3 slope(widen(row.slope[0]), widen(row.slope[1]), widen(row.slope[2]));
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < values.size(); ++i) {
      const double left = values[i] - dot(slope, latent_[i]);
      low = std::min(low, left);
      high = std::max(high, left);
    }
    return {low, high};
  }

  std::span<const dvec3> latent_;
  dmat4 inverse_;
};

// The float nearest above.
float round_up(double value) {
  return std::nextafter(static_cast<float>(value), INFINITY);
}

class PieceFitter {
 public:
  PieceFitter(const FitSource& source, std::span<const uint32_t> vertices, FitStore& out)
      : source_(source),
        vertices_(vertices),
        frame_(make_frame(source, vertices)),
        fitter_(frame_.latent),
        out_(out) {
    piece_.center = frame_.center;
    std::ranges::copy(frame_.axes, piece_.axes);
    store_support(frame_.latent, piece_.support);
    piece_.first_joint = static_cast<uint32_t>(out.joints.size());
    piece_.first_target = static_cast<uint32_t>(out.targets.size());
    values_.resize(vertices.size());
  }

  void add_targets() {
    if (!source_.morph) return;
    const size_t stride = source_.rest.size();
    std::vector<uint32_t> moving;
    double farthest = 0.0;
    for (uint32_t target = 0; target < target_count(*source_.morph); ++target) {
      const std::span deltas = source_.morph->deltas.subspan(target * stride, stride);
      double far = 0.0;
      for (const uint32_t v : vertices_) {
        for (int axis = 0; axis < 3; ++axis) far = std::max(far, std::abs(finite(deltas[v][axis])));
      }
      if (far > 0.0) moving.push_back(target);
      farthest = std::max(farthest, far);
    }
    // Slopes may put the offset outside the deltas, but not far.
    piece_.target_unit = round_up(farthest / 8192.0);
    for (const uint32_t target : moving) {
      add_target(target, source_.morph->deltas.subspan(target * stride, stride));
    }
    piece_.targets = static_cast<uint16_t>(out_.targets.size() - piece_.first_target);
  }

  void add_joints() {
    if (!source_.skin) return;
    list_joints();
    piece_.reference_joint =
        *std::ranges::max_element(joints_, {}, [&](uint16_t joint) { return total_weight(joint); });
    for (const uint16_t joint : joints_) {
      if (joint != piece_.reference_joint) add_joint(joint);
    }
    piece_.joints = static_cast<uint16_t>(out_.joints.size() - piece_.first_joint);
  }

  // The piece follows this joint alone.
  void follow(uint16_t joint, double defect) {
    piece_.reference_joint = joint;
    defect_ = defect;
  }

  void finish() {
    piece_.pad = round_up(relative_pad());
    out_.pieces.push_back(piece_);
  }

 private:
  using Row = AffineFitter::Row;

  // A vertex whose delta is not finite is nowhere, unless the target's weight is 0.
  static double finite(float delta) { return std::isfinite(delta) ? delta : 0.0; }

  void add_target(uint32_t target, std::span<const vec3> deltas) {
    TargetFit fit;
    Bfloat16 residual[3];
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t i = 0; i < vertices_.size(); ++i) values_[i] = finite(deltas[vertices_[i]][axis]);
      const Row row = fitter_.fit(values_);
      for (int k = 0; k < 3; ++k) fit.slope[k][axis] = row.slope[k];
      const double steps = std::round(row.middle / piece_.target_unit);
      fit.offset[axis] = static_cast<int16_t>(std::clamp(steps, -32767.0, 32767.0));
      residual[axis] =
          fitter_.residual(values_, row, double(piece_.target_unit) * fit.offset[axis]);
    }
    fit.residual_x = residual[0];
    fit.slope[0][3] = residual[1];
    fit.slope[1][3] = residual[2];
    fit.slope[2][3] = 0;
    fit.target = static_cast<uint16_t>(target);
    out_.targets.push_back(fit);
  }

  // Calls visit(joint, weight) for each influence of the vertex that is not 0.
  template <class Visit>
  void for_each_influence(uint32_t vertex, const Visit& visit) const {
    const SkinMotion& skin = *source_.skin;
    for (size_t k = size_t{vertex} * skin.influences; k < size_t{vertex + 1} * skin.influences;
         ++k) {
      if (skin.weights[k] != 0.0f) visit(skin.joints[k], double(skin.weights[k]));
    }
  }

  double weight_of(uint32_t vertex, uint16_t joint) const {
    double sum = 0.0;  // a joint may be named twice
    for_each_influence(vertex, [&](uint16_t j, double w) { sum += j == joint ? w : 0.0; });
    return sum;
  }
  double total_weight(uint16_t joint) const {
    double sum = 0.0;
    for (const uint32_t v : vertices_) sum += weight_of(v, joint);
    return sum;
  }

  void list_joints() {
    for (const uint32_t v : vertices_) {
      double sum = 0.0, size = 0.0;
      for_each_influence(v, [&](uint16_t joint, double w) {
        joints_.push_back(joint);
        sum += w;
        size += std::abs(w);
      });
      defect_ = std::max(defect_, std::abs(sum - 1.0));
      weight_size_ = std::max(weight_size_, size);
    }
    std::ranges::sort(joints_);
    joints_.erase(std::unique(joints_.begin(), joints_.end()), joints_.end());
    if (joints_.empty()) joints_.push_back(0);  // all weights are 0
  }

  void add_joint(uint16_t joint) {
    JointFit fit;
    fit.joint = joint;
    weights_.resize(vertices_.size());
    for (size_t i = 0; i < vertices_.size(); ++i) weights_[i] = weight_of(vertices_[i], joint);
    for (int r = 0; r < 4; ++r) {
      for (size_t i = 0; i < vertices_.size(); ++i) {
        const dvec3 q = dvec3(source_.rest[vertices_[i]]) - dvec3(frame_.center);
        values_[i] = weights_[i] * (r < 3 ? q[r] : 1.0);
      }
      const Row row = fitter_.fit(values_);
      std::ranges::copy(row.slope, fit.affine[r] + 1);
      fit.affine[r][0] = round_to_bfloat16(row.middle);
      double offset = widen(fit.affine[r][0]);
      if (r == 3) {
        fit.weight_rest = round_to_bfloat16(row.middle - offset);
        offset += widen(fit.weight_rest);
      }
      fit.residual[r] = fitter_.residual(values_, row, offset);
      const double reach = r < 3 ? rest_reach(r) : 1.0;
      double sum = std::abs(offset) + widen(fit.residual[r]);
      for (const Bfloat16 slope : row.slope) sum += std::abs(widen(slope));
      if (reach > 0.0) joint_gain_[r] += sum / reach;
    }
    out_.joints.push_back(fit);
  }

  double rest_reach(int axis) const {
    return std::abs(frame_.center[axis]) + std::abs(frame_.axes[0][axis]) +
           std::abs(frame_.axes[1][axis]) + std::abs(frame_.axes[2][axis]);
  }

  // Let m be sum_j(|M_j| reach + |t_j|), per axis. positions() makes n = influences + targets + 6
  // roundings in a row of terms that sum to at most `weight_size_ * m`. derive_bounds makes 4 a
  // joint, 2 a target and at most 24 more, of terms that sum to at most 2 m for the reference joint
  // and, for each other one, whose map is a difference of two, 2 m times its fitted products
  // against what it multiplies; the support adds three times those of the axes.
  double relative_pad() const {
    const double influences = source_.skin ? source_.skin->influences : 0;
    const double targets = source_.morph ? target_count(*source_.morph) : 0;
    const double gain =
        2.0 + 4.0 * std::max({joint_gain_[0], joint_gain_[1], joint_gain_[2], joint_gain_[3]});
    const double theirs = (influences + targets + 6.0) * weight_size_;
    const double ours = (4.0 * piece_.joints + 2.0 * piece_.targets + 24.0) * 4.0 * gain;
    return (kRounding * (theirs + ours) + defect_) * 1.01;
  }

  const FitSource& source_;
  std::span<const uint32_t> vertices_;
  Frame frame_;
  AffineFitter fitter_;
  FitStore& out_;
  ClusterPiece piece_;
  std::vector<double> values_;    // scratch: one a vertex
  std::vector<double> weights_;   // the same
  std::vector<uint16_t> joints_;  // that move the piece, ascending
  double defect_ = 0.0;           // of the weights' sums, against 1
  double weight_size_ = 1.0;      // the largest sum of a vertex's |weights|
  dvec4 joint_gain_{0.0};         // fitted products against what they multiply, over all joints
};

}  // namespace

FitSource fit_source(const SkinMotion& motion) {
  return {motion.rest, &motion, nullptr};
}
FitSource fit_source(const MorphMotion& motion) {
  return {motion.rest, motion.skin.influences > 0 ? &motion.skin : nullptr, &motion};
}

void FitStore::append(const FitStore& other) {
  const auto joint_shift = static_cast<uint32_t>(joints.size());
  const auto target_shift = static_cast<uint32_t>(targets.size());
  for (ClusterPiece piece : other.pieces) {
    piece.first_joint += joint_shift;
    piece.first_target += target_shift;
    pieces.push_back(piece);
  }
  joints.insert(joints.end(), other.joints.begin(), other.joints.end());
  targets.insert(targets.end(), other.targets.begin(), other.targets.end());
}

bool can_be_finite(const FitSource& source, uint32_t vertex) {
  const vec3 p = source.rest[vertex];
  bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  if (!source.skin) return finite;
  const size_t begin = size_t{vertex} * source.skin->influences;
  for (const float weight : source.skin->weights.subspan(begin, source.skin->influences)) {
    finite = finite && std::isfinite(weight);
  }
  return finite;
}

void fit_piece(const FitSource& source, std::span<const uint32_t> vertices, FitStore& out) {
  if (vertices.empty()) return;
  PieceFitter fitter(source, vertices, out);
  fitter.add_targets();
  fitter.add_joints();
  fitter.finish();
}

void fit_region(const FitSource& source, std::span<const uint32_t> vertices, uint16_t joint,
                double defect, FitStore& out) {
  if (vertices.empty()) return;
  PieceFitter fitter(source, vertices, out);
  fitter.add_targets();
  fitter.follow(joint, defect);
  fitter.finish();
}

}  // namespace sinew
