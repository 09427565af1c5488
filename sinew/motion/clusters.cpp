// Assembles what is known of a body's clusters: fits pieces in parallel chunks, then puts the
// chunks' parts together in order.
#include "sinew/motion/clusters.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/motion/clusters_split.h"
#include "sinew/motion/keyframes.h"
#include "sinew/motion/morph.h"

namespace sinew {
namespace {

constexpr uint32_t kMostBodyParts = 64;  // of a body without skin, to bound it as a whole

uint32_t count_of(const ClusterVertices& clusters) {
  return clusters.first.empty() ? 0 : static_cast<uint32_t>(clusters.first.size() - 1);
}
std::span<const uint32_t> vertices_of(const ClusterVertices& clusters, size_t cluster) {
  const uint32_t begin = clusters.first[cluster];
  return clusters.vertices.subspan(begin, clusters.first[cluster + 1] - begin);
}

// The boxes of all clusters, then of all together; vertices that are not finite are nowhere.
void make_boxes(const ClusterVertices& clusters, std::span<const vec3> positions,
                std::span<Box> out) {
  const uint32_t count = count_of(clusters);
  parallel_for(count, 256, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      for (const uint32_t v : vertices_of(clusters, c)) {
        const Box point{positions[v], positions[v]};
        if (is_finite(point)) out[c].extend(point);
      }
    }
  });
  for (uint32_t c = 0; c < count; ++c) out[count].extend(out[c]);
}

// Fits items in parallel, `grain` a task, and keeps their order. `fit(item, store)` appends the
// pieces of one item.
template <class Fit>
void fit_in_order(size_t items, size_t grain, const Fit& fit, FitStore& out,
                  std::vector<uint32_t>* first_piece = nullptr) {
  std::vector<FitStore> parts((items + grain - 1) / grain);
  std::vector<uint32_t> pieces(items);
  parallel_for(items, grain, [&](size_t begin, size_t end) {
    FitStore& part = parts[begin / grain];
    for (size_t i = begin; i < end; ++i) {
      const size_t before = part.pieces.size();
      fit(i, part);
      pieces[i] = static_cast<uint32_t>(part.pieces.size() - before);
    }
  });
  if (first_piece) {
    uint32_t sum = static_cast<uint32_t>(out.pieces.size());
    for (const uint32_t count : pieces) {
      first_piece->push_back(sum);
      sum += count;
    }
  }
  for (const FitStore& part : parts) out.append(part);
}

// The vertices that the clusters have, each once, ascending, without those that are never finite.
std::vector<uint32_t> body_vertices(const FitSource& source, const ClusterVertices& clusters) {
  std::vector<uint8_t> used(source.rest.size(), 0);
  for (const uint32_t v : clusters.vertices) used[v] = 1;
  std::vector<uint32_t> out;
  for (uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] && can_be_finite(source, v)) out.push_back(v);
  }
  return out;
}

// One region for each joint: the vertices that it moves. Their hulls' union holds every blend.
// Returns false if a weight is negative, for then it does not.
bool fit_regions(const FitSource& source, std::span<const uint32_t> vertices, FitStore& out) {
  const SkinMotion& skin = *source.skin;
  std::vector<std::vector<uint32_t>> moved(std::max(skin.joint_count, 1u));
  double defect = 0.0;
  for (const uint32_t v : vertices) {
    double sum = 0.0;
    for (size_t k = size_t{v} * skin.influences; k < size_t{v + 1} * skin.influences; ++k) {
      const float weight = skin.weights[k];
      if (weight < 0.0f) return false;
      sum += weight;
      std::vector<uint32_t>& list = moved[skin.joints[k]];
      if (weight > 0.0f && (list.empty() || list.back() != v)) list.push_back(v);
    }
    if (sum == 0.0) moved[0].push_back(v);
    defect = std::max(defect, std::abs(sum - 1.0));
  }
  fit_in_order(
      moved.size(), 1,
      [&](size_t joint, FitStore& part) {
        fit_region(source, moved[joint], static_cast<uint16_t>(joint), defect, part);
      },
      out);
  return true;
}

// Splits the vertices at the median of their widest axis until there are `parts` parts or more.
void fit_parts(const FitSource& source, std::span<uint32_t> vertices, uint32_t parts,
               FitStore& out) {
  if (parts <= 1 || vertices.size() < 2) return fit_piece(source, vertices, out);
  Box box;
  for (const uint32_t v : vertices) box.extend(source.rest[v]);
  const vec3 extent = box.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const size_t half = vertices.size() / 2;
  std::ranges::nth_element(vertices, vertices.begin() + half, {},
                           [&](uint32_t v) { return std::pair(source.rest[v][axis], v); });
  fit_parts(source, vertices.first(half), parts / 2, out);
  fit_parts(source, vertices.subspan(half), parts / 2, out);
}

template <class M>
void make_fits(const M& motion, const ClusterVertices& clusters, const ClusterConfig& config,
               ClusterBounds& out) {
  const FitSource source = fit_source(motion);
  const Motion any = motion;
  FitStore store;
  fit_in_order(
      out.clusters, 32,
      [&](size_t cluster, FitStore& part) {
        std::vector<uint32_t> vertices;
        for (const uint32_t v : vertices_of(clusters, cluster)) {
          if (can_be_finite(source, v)) vertices.push_back(v);
        }
        fit_cluster(source, any, vertices, config, part);
      },
      store, &out.first_piece);
  out.first_piece.push_back(static_cast<uint32_t>(store.pieces.size()));
  std::vector<uint32_t> body = body_vertices(source, clusters);
  if (!source.skin || !fit_regions(source, body, store)) {
    fit_parts(source, body, std::min(kMostBodyParts, out.clusters / 2), store);
  }
  out.first_piece.push_back(static_cast<uint32_t>(store.pieces.size()));
  out.pieces = std::move(store.pieces);
  out.joints = std::move(store.joints);
  out.targets = std::move(store.targets);
}

void make(const RigidMotion& motion, const ClusterVertices& clusters, const ClusterConfig&,
          ClusterBounds& out) {
  out.boxes.resize(out.clusters + 1);
  make_boxes(clusters, motion.rest, out.boxes);
}
void make(const KeyframeMotion& motion, const ClusterVertices& clusters, const ClusterConfig&,
          ClusterBounds& out) {
  const size_t stride = size_t{out.clusters} + 1, keys = key_count(motion);
  out.boxes.resize(stride * keys);
  for (size_t key = 0; key < keys; ++key) {
    make_boxes(clusters, motion.keys.subspan(key * motion.vertex_count, motion.vertex_count),
               std::span(out.boxes).subspan(key * stride, stride));
  }
}
void make(const SkinMotion& motion, const ClusterVertices& clusters, const ClusterConfig& config,
          ClusterBounds& out) {
  make_fits(motion, clusters, config, out);
}
void make(const MorphMotion& motion, const ClusterVertices& clusters, const ClusterConfig& config,
          ClusterBounds& out) {
  make_fits(motion, clusters, config, out);
}
void make(const FreeMotion&, const ClusterVertices&, const ClusterConfig&, ClusterBounds&) {}

template <class T>
size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

}  // namespace

bool derivable(const Motion& motion) {
  const auto* const morph = std::get_if<MorphMotion>(&motion);
  if (morph) return target_count(*morph) <= 0xffff;
  return !std::holds_alternative<FreeMotion>(motion);
}

size_t ClusterBounds::bytes() const {
  return bytes_of(first_piece) + bytes_of(pieces) + bytes_of(joints) + bytes_of(targets) +
         bytes_of(boxes);
}

ClusterBounds make_cluster_bounds(const Motion& motion, const ClusterVertices& vertices,
                                  const ClusterConfig& config) {
  SINEW_CHECK(derivable(motion));
  SINEW_DCHECK(validate(motion).empty());
  ClusterBounds out;
  out.clusters = count_of(vertices);
  std::visit([&](const auto& m) { make(m, vertices, config, out); }, motion);
  return out;
}

}  // namespace sinew
