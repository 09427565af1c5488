// What holes are measured against: the source's triangles in small pieces, moved by the same skin
// lattice as the voxels, or by the true skin, and drawn the obvious way. The slow twin of the
// rasteriser; nothing of it is shared.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/svo/holes/hole_sheets.h"
#include "sinew/svo/holes/holes.h"
#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/posed.h"

namespace sinew {

struct DistanceSummary {
  double median = 0.0, most_of_100 = 0.0, largest = 0.0;  // voxels; the second: of 99%
  uint64_t points = 0;
};

class HoleReference {
 public:
  // Edges of pieces are `step` voxels long at most. The source's spans and the octree must outlive
  // the object. `surface`: what make_svo() made the octree of, which says whose each copy of a cell
  // is; null for octrees that were not made of the source, whose copies are anybody's.
  HoleReference(const SvoSource& source, const Svo& svo, float step,
                const VoxelSurface* surface = nullptr);

  // The surface as the lattice carries it. Moves all blocks.
  void draw_lattice(PosedSvo& posed, const Affine& placement, const RasterView& view,
                    SurfacePicture& out) const;
  // As the source's own motion carries it.
  void draw_true(const Pose& pose, const Affine& placement, const RasterView& view,
                 SurfacePicture& out) const;

  // How far the lattice carries points of the surface from where they belong: every 7th.
  DistanceSummary distance(PosedSvo& posed) const;

  uint64_t points() const { return cells_.size(); }
  uint64_t lost() const { return lost_; }  // points near which there is no voxel; they are left out
  // Points near which no voxel belongs to their own sheet; another sheet's carries them.
  uint64_t strays() const { return strays_; }

 private:
  static constexpr uint32_t kLost = 0xffffffffu;

  // Cell copies of one place of a block, in svo.cells: [first, end).
  struct Copies {
    uint32_t first = 0, end = 0;
  };
  struct Found {
    uint32_t cell = kLost;
    float distance = 0.0f;  // from the voxel, in voxels
    float unlike = 0.0f;    // how much materials and weights differ
  };
  void index_cells();
  uint32_t locate(vec3 p, uint32_t triangle, vec3 barycentric, bool own) const;
  void look_in(uvec3 voxel, vec3 p, uint32_t triangle, vec3 barycentric, bool own,
               Found& best) const;
  float unlikeness(uint32_t cell, vec3 p, uint32_t triangle, vec3 barycentric) const;
  vec3 local_of(uint32_t cell, vec3 p) const;  // 0..1 within the cell
  vec3 rest_of(uint32_t triangle, vec3 barycentric) const;
  template <class Move>
  void draw(const Move& move, const RasterView& view, SurfacePicture& out) const;

  const SvoSource source_;
  const Svo* svo_;
  std::span<const vec3> rest_;
  std::vector<uint32_t> block_at_;  // of every place a block may have; kLost: none
  uvec3 block_places_{0};
  std::vector<Copies> copies_;         // 512 a block
  std::vector<uint32_t> block_of_;     // of each cell
  std::vector<uint16_t> steps_;        // of each triangle: into how many its edges are cut
  std::vector<uint64_t> first_point_;  // of each triangle; its points are row by row
  std::vector<uint32_t> cells_;        // of each point
  uint64_t lost_ = 0, strays_ = 0;
  std::optional<HoleSheets> sheets_;
};

}  // namespace sinew
