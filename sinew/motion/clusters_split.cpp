// Groups vertices by k-means over their weights and places, seeded by farthest points (T. Gonzalez,
// "Clustering to Minimize the Maximum Intercluster Distance", 1985). Whether a split pays is not
// guessed but measured: its boxes in a few trial poses against those without it.
#include "sinew/motion/clusters_split.h"

#include <algorithm>
#include <cmath>

#include "sinew/math/random.h"
#include "sinew/motion/morph.h"

namespace sinew {
namespace {

constexpr uint32_t kMostPieces = 4;
constexpr uint32_t kTrialPoses = 6;
constexpr uint32_t kRounds = 8;          // of k-means
constexpr double kTight = 1.3;           // derived over exact area; tighter is not split
constexpr double kWorthAPiece = 0.9;     // one more piece must shrink the boxes at least to this
constexpr float kPlaceInWeights = 0.3f;  // a cluster's radius counts as much as this weight

// The joints that move the vertices, ascending.
std::vector<uint16_t> list_joints(const FitSource& source, std::span<const uint32_t> vertices) {
  std::vector<uint16_t> joints;
  if (!source.skin) return joints;
  const SkinMotion& skin = *source.skin;
  for (const uint32_t v : vertices) {
    for (size_t k = size_t{v} * skin.influences; k < size_t{v + 1} * skin.influences; ++k) {
      if (skin.weights[k] != 0.0f) joints.push_back(skin.joints[k]);
    }
  }
  std::ranges::sort(joints);
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  return joints;
}

// One row of numbers a vertex: its place in the cluster, then its weight for each joint.
struct Features {
  size_t width = 0;
  std::vector<float> values;

  size_t count() const { return values.size() / width; }
  std::span<const float> row(size_t i) const { return std::span(values).subspan(i * width, width); }
};

Features make_features(const FitSource& source, std::span<const uint32_t> vertices,
                       std::span<const uint16_t> joints, const Box& box) {
  Features out;
  out.width = 3 + joints.size();
  out.values.assign(vertices.size() * out.width, 0.0f);
  const float radius = 0.5f * length(box.extent());
  for (size_t i = 0; i < vertices.size(); ++i) {
    float* const row = &out.values[i * out.width];
    const vec3 place = source.rest[vertices[i]] - box.center();
    for (int axis = 0; axis < 3 && radius > 0.0f; ++axis) {
      row[axis] = kPlaceInWeights / radius * place[axis];
    }
    if (!source.skin) continue;
    const size_t begin = size_t{vertices[i]} * source.skin->influences;
    for (size_t k = begin; k < begin + source.skin->influences; ++k) {
      if (source.skin->weights[k] == 0.0f) continue;
      const auto at = std::ranges::lower_bound(joints, source.skin->joints[k]) - joints.begin();
      row[3 + at] += source.skin->weights[k];
    }
  }
  return out;
}

float distance2(std::span<const float> a, std::span<const float> b) {
  float sum = 0.0f;
  for (size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
  return sum;
}

using Centers = std::vector<std::vector<float>>;

// Ties go to the first centre.
uint32_t nearest(const Centers& centers, std::span<const float> row) {
  uint32_t best = 0;
  float least = distance2(row, centers[0]);
  for (uint32_t g = 1; g < centers.size(); ++g) {
    const float d = distance2(row, centers[g]);
    if (d < least) least = d, best = g;
  }
  return best;
}

// The vertex farthest from the vertex farthest from the first, then always the one farthest from
// all centres so far.
Centers seed_centers(const Features& features, uint32_t groups) {
  const auto farthest_from = [&](const Centers& centers) {
    size_t farthest = 0;
    float most = -1.0f;
    for (size_t i = 0; i < features.count(); ++i) {
      const std::span<const float> row = features.row(i);
      const float d = distance2(row, centers[nearest(centers, row)]);
      if (d > most) most = d, farthest = i;
    }
    const std::span<const float> row = features.row(farthest);
    return std::vector<float>(row.begin(), row.end());
  };
  Centers centers = {std::vector<float>(features.row(0).begin(), features.row(0).end())};
  centers[0] = farthest_from(centers);
  while (centers.size() < groups) centers.push_back(farthest_from(centers));
  return centers;
}

// The group of each vertex, 0 .. groups - 1.
std::vector<uint32_t> group_vertices(const Features& features, uint32_t groups) {
  Centers centers = seed_centers(features, groups);
  std::vector<uint32_t> group(features.count());
  std::vector<uint32_t> sizes(groups);
  for (uint32_t round = 0; round < kRounds; ++round) {
    for (size_t i = 0; i < group.size(); ++i) group[i] = nearest(centers, features.row(i));
    Centers sums(groups, std::vector<float>(features.width, 0.0f));
    std::ranges::fill(sizes, 0);
    for (size_t i = 0; i < group.size(); ++i) {
      ++sizes[group[i]];
      for (size_t j = 0; j < features.width; ++j) sums[group[i]][j] += features.row(i)[j];
    }
    for (uint32_t g = 0; g < groups; ++g) {
      for (float& sum : sums[g]) sum /= float(sizes[g]);
      if (sizes[g] > 0) centers[g] = sums[g];
    }
  }
  return group;
}

FitStore fit_groups(const FitSource& source, std::span<const uint32_t> vertices,
                    std::span<const uint32_t> group, uint32_t groups) {
  FitStore out;
  std::vector<uint32_t> part;
  for (uint32_t g = 0; g < groups; ++g) {
    part.clear();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (group[i] == g) part.push_back(vertices[i]);
    }
    fit_piece(source, part, out);
  }
  return out;
}

// Joints that turn by up to 60 degrees about pivots in and around the cluster, and any weights of
// targets. The same ones each time.
class TrialPoses {
 public:
  TrialPoses(const FitSource& source, std::span<const uint16_t> joints, const Box& box)
      : joints_(joints), center_(box.center()), radius_(0.5f * length(box.extent())) {
    if (source.skin) pose_joints_.resize(source.skin->joint_count, identity_affine());
    if (source.morph) weights_.resize(target_count(*source.morph));
  }

  // Sums of half areas of the cluster's boxes: as derived from its pieces, and exact ones.
  double area(const Motion& motion, FitStore store) {
    ClusterBounds bounds;
    bounds.clusters = 1;
    bounds.first_piece = {0, static_cast<uint32_t>(store.pieces.size())};
    bounds.pieces = std::move(store.pieces);
    bounds.joints = std::move(store.joints);
    bounds.targets = std::move(store.targets);
    return sum_over_poses([&](const Pose& pose) {
      Box box;
      derive_bounds(bounds, motion, pose, 0, {&box, 1});
      return box;
    });
  }
  double exact_area(const Motion& motion, std::span<const uint32_t> vertices) {
    return sum_over_poses([&](const Pose& pose) { return bounds(motion, pose, vertices); });
  }

 private:
  template <class BoxOf>
  double sum_over_poses(const BoxOf& box_of) {
    Pose pose;
    pose.joints = pose_joints_;
    pose.weights = weights_;
    Random random(1);
    double sum = 0.0;
    for (uint32_t i = 0; i < kTrialPoses; ++i) {
      const mat3 view = turn(random, 6.28f);
      for (const uint16_t joint : joints_) pose_joints_[joint] = place(random, view);
      for (float& weight : weights_) weight = random.uniform(-0.5f, 1.0f);
      sum += half_area(box_of(pose));
    }
    return sum;
  }

  static mat3 turn(Random& random, float most_radians) {
    const float angle = random.uniform(0.0f, most_radians);
    return glm::mat3_cast(glm::angleAxis(angle, random.direction()));
  }
  Affine place(Random& random, const mat3& view) const {
    const mat3 rotation = view * turn(random, 1.05f);
    const float away = random.uniform(0.0f, 1.5f * radius_);
    const vec3 pivot = center_ + away * random.direction();
    return Affine(rotation[0], rotation[1], rotation[2], view * pivot - rotation * pivot);
  }

  std::vector<Affine> pose_joints_;
  std::vector<float> weights_;
  std::span<const uint16_t> joints_;
  vec3 center_;
  float radius_;
};

}  // namespace

void fit_cluster(const FitSource& source, const Motion& motion, std::span<const uint32_t> vertices,
                 const ClusterConfig& config, FitStore& out) {
  if (vertices.empty()) return;
  FitStore best;
  fit_piece(source, vertices, best);
  const uint32_t most =
      std::min<uint32_t>({config.most_pieces, kMostPieces, static_cast<uint32_t>(vertices.size())});
  if (most > 1) {
    Box box;
    for (const uint32_t v : vertices) box.extend(source.rest[v]);
    const std::vector<uint16_t> joints = list_joints(source, vertices);
    const Features features = make_features(source, vertices, joints, box);
    TrialPoses poses(source, joints, box);
    double least = poses.area(motion, best), worth = 1.0;
    const double tight = kTight * poses.exact_area(motion, vertices);
    for (uint32_t groups = 2; groups <= most && least > tight; ++groups) {
      worth *= kWorthAPiece;
      FitStore split = fit_groups(source, vertices, group_vertices(features, groups), groups);
      const double area = poses.area(motion, split);
      if (area >= worth * least) continue;
      least = area;
      worth = 1.0;
      best = std::move(split);
    }
  }
  out.append(best);
}

}  // namespace sinew
