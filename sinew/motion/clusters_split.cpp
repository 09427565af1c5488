// Groups by k-means over weight vectors, seeded by farthest points (T. Gonzalez, "Clustering to
// Minimize the Maximum Intercluster Distance", 1985). Whether a split pays is not guessed from the
// weights but measured: its boxes in a few trial poses against those without it.
#include "sinew/motion/clusters_split.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/math/random.h"
#include "sinew/motion/morph.h"

namespace sinew {
namespace {

constexpr uint32_t kMaxGroups = 4;
constexpr uint32_t kTrialPoses = 6;
constexpr uint32_t kRounds = 8;        // of k-means
constexpr double kWorthAGroup = 0.86;  // one more group must shrink the boxes at least to this

// A vertex's weights, as a row over the joints that move the cluster.
struct WeightRows {
  std::vector<uint16_t> joints;  // ascending
  std::vector<float> rows;       // vertex-major

  std::span<const float> row(size_t i) const {
    return std::span(rows).subspan(i * joints.size(), joints.size());
  }
};

WeightRows weight_rows(const SkinMotion& skin, std::span<const uint32_t> vertices) {
  WeightRows out;
  for (const uint32_t v : vertices) {
    for (size_t k = size_t{v} * skin.influences; k < size_t{v + 1} * skin.influences; ++k) {
      if (skin.weights[k] != 0.0f) out.joints.push_back(skin.joints[k]);
    }
  }
  std::ranges::sort(out.joints);
  out.joints.erase(std::unique(out.joints.begin(), out.joints.end()), out.joints.end());
  out.rows.assign(vertices.size() * out.joints.size(), 0.0f);
  for (size_t i = 0; i < vertices.size(); ++i) {
    const size_t begin = size_t{vertices[i]} * skin.influences;
    for (size_t k = begin; k < begin + skin.influences; ++k) {
      if (skin.weights[k] == 0.0f) continue;
      const auto at = std::ranges::lower_bound(out.joints, skin.joints[k]) - out.joints.begin();
      out.rows[i * out.joints.size() + at] += skin.weights[k];
    }
  }
  return out;
}

float distance2(std::span<const float> a, std::span<const float> b) {
  float sum = 0.0f;
  for (size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
  return sum;
}

// The group of each vertex, 0 .. groups - 1. Ties go to the lower group and the earlier vertex.
std::vector<uint32_t> group_by_weights(const WeightRows& weights, size_t vertices,
                                       uint32_t groups) {
  std::vector<std::vector<float>> centers;
  const auto row_vector = [&](size_t i) {
    return std::vector<float>(weights.row(i).begin(), weights.row(i).end());
  };
  const auto nearest = [&](size_t i) {
    uint32_t best = 0;
    for (uint32_t g = 1; g < centers.size(); ++g) {
      if (distance2(weights.row(i), centers[g]) < distance2(weights.row(i), centers[best]))
        best = g;
    }
    return best;
  };
  centers.push_back(row_vector(0));
  for (uint32_t g = 0; g <= groups; ++g) {  // the first seed only starts the search
    size_t farthest = 0;
    float most = -1.0f;
    for (size_t i = 0; i < vertices; ++i) {
      const float d = distance2(weights.row(i), centers[nearest(i)]);
      if (d > most) most = d, farthest = i;
    }
    if (g == 0) centers.clear();
    if (centers.size() < groups) centers.push_back(row_vector(farthest));
  }
  std::vector<uint32_t> group(vertices);
  for (uint32_t round = 0; round < kRounds; ++round) {
    for (size_t i = 0; i < vertices; ++i) group[i] = nearest(i);
    for (uint32_t g = 0; g < groups; ++g) {
      std::vector<float> sum(weights.joints.size(), 0.0f);
      float count = 0.0f;
      for (size_t i = 0; i < vertices; ++i) {
        if (group[i] != g) continue;
        for (size_t j = 0; j < sum.size(); ++j) sum[j] += weights.row(i)[j];
        count += 1.0f;
      }
      if (count == 0.0f) continue;
      for (size_t j = 0; j < sum.size(); ++j) centers[g][j] = sum[j] / count;
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

// Joints that turn by up to 60 degrees about pivots in and around the cluster.
class TrialPoses {
 public:
  TrialPoses(const FitSource& source, std::span<const uint32_t> vertices,
             std::span<const uint16_t> joints)
      : pose_joints_(source.skin->joint_count, identity_affine()), joints_(joints) {
    Box box;
    for (const uint32_t v : vertices) box.extend(source.rest[v]);
    center_ = box.center();
    radius_ = 0.5f * length(box.extent());
    if (source.morph) weights_.assign(target_count(*source.morph), 0.0f);
  }

  double area(const Motion& motion, FitStore store) {
    ClusterBounds bounds;
    bounds.clusters = 1;
    bounds.first_piece = {0, static_cast<uint32_t>(store.pieces.size())};
    bounds.pieces = std::move(store.pieces);
    bounds.joints = std::move(store.joints);
    bounds.targets = std::move(store.targets);
    Random random(1);
    double sum = 0.0;
    for (uint32_t i = 0; i < kTrialPoses; ++i) {
      const mat3 view =
          glm::mat3_cast(glm::angleAxis(random.uniform(0.0f, 6.2f), random.direction()));
      for (const uint16_t joint : joints_) pose_joints_[joint] = turn(random, view);
      Pose pose;
      pose.joints = pose_joints_;
      pose.weights = weights_;
      Box box;
      derive_bounds(bounds, motion, pose, 0, {&box, 1});
      sum += half_area(box);
    }
    return sum;
  }

 private:
  // Turns about a pivot, then the view of the whole.
  Affine turn(Random& random, const mat3& view) const {
    constexpr float kMostRadians = 1.05f;
    const vec3 axis = random.direction();
    const float angle = random.uniform(0.0f, kMostRadians);
    const vec3 away = random.direction();
    const vec3 pivot = center_ + radius_ * random.uniform(0.0f, 1.5f) * away;
    const mat3 rotation = view * glm::mat3_cast(glm::angleAxis(angle, axis));
    const vec3 moved = view * pivot - rotation * pivot;
    return Affine(rotation[0], rotation[1], rotation[2], moved);
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
  FitStore best;
  fit_piece(source, vertices, best);
  const uint32_t most = std::min(config.weight_groups, kMaxGroups);
  if (source.skin && most > 1 && vertices.size() > 1) {
    const WeightRows weights = weight_rows(*source.skin, vertices);
    TrialPoses poses(source, vertices, weights.joints);
    double least = poses.area(motion, best);
    double wanted = kWorthAGroup;
    for (uint32_t groups = 2; groups <= most && weights.joints.size() > 1; ++groups) {
      const std::vector<uint32_t> group = group_by_weights(weights, vertices.size(), groups);
      FitStore split = fit_groups(source, vertices, group, groups);
      const double area = poses.area(motion, split);
      if (area < wanted * least) {
        least = area;
        best = std::move(split);
        wanted = kWorthAGroup;
      } else {
        wanted *= kWorthAGroup;
      }
    }
  }
  out.append(best);
}

}  // namespace sinew
