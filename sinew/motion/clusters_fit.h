// Fits one piece of a cluster: its frame and hull, and what each joint and target does to it (see
// clusters.h). In double; every rounding of what is stored goes into the stored residuals.
#pragma once

#include <span>
#include <vector>

#include "sinew/motion/clusters.h"

namespace sinew {

// A body that is skinned, morphed, or both.
struct FitSource {
  std::span<const vec3> rest;
  const SkinMotion* skin = nullptr;    // null: none
  const MorphMotion* morph = nullptr;  // null: none
};
FitSource fit_source(const SkinMotion& motion);
FitSource fit_source(const MorphMotion& motion);

// Pieces in order, with the fits that they refer to.
struct FitStore {
  std::vector<ClusterPiece> pieces;
  std::vector<JointFit> joints;
  std::vector<TargetFit> targets;

  void append(const FitStore& other);
};

// Whether every position of the vertex is finite in some pose.
bool can_be_finite(const FitSource& source, uint32_t vertex);

// Appends a piece that holds the vertices, all of which can be finite; nothing if there are none.
void fit_piece(const FitSource& source, std::span<const uint32_t> vertices, FitStore& out);

// Appends a piece that holds where `joint` alone would take the vertices. Any blend of such pieces'
// points with weights that are not negative and sum to 1 + `defect` at most lies in their union.
void fit_region(const FitSource& source, std::span<const uint32_t> vertices, uint16_t joint,
                double defect, FitStore& out);

}  // namespace sinew
