// The voxeliser: triangles -> the voxels that they touch, with how the surface looks there.
//
//   triangles -> blocks of 64^3 voxels that they meet -> in each block, in parallel: voxels of each
//   triangle, their looks, sorted -> fragments of all blocks in Morton order
//
// Based on: M. Schwarz, H.-P. Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs",
// SIGGRAPH Asia 2010, section 3; J. Huang et al., "An Accurate Method for Voxelizing Polygon
// Meshes", VolVis 1998 (separability). Differs: planes that run exactly between two voxels put one
// voxel into a thin shell, not two; solids are filled from outside, so that meshes may be open.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/math/box.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {

enum class Shell : uint8_t {
  thin,          // 6-separating: no path over faces of voxels passes through the surface
  conservative,  // 26-separating: every voxel that a triangle touches, be it in a point
};

// Points of one triangle whose looks are asked for. All spans have one entry a point.
struct SurfaceBatch {
  uint32_t triangle = 0;
  float voxel = 1.0f;           // side of a voxel: what a look stands for
  std::span<const float> u, v;  // weights of the triangle's second and third vertex
  std::span<uint16_t> normals;  // to be written, see pack_normal
  std::span<uint16_t> colors;   // to be written, see pack_color
  std::span<uint8_t> present;   // all 1; 0 leaves the voxel out, nothing else may stand here
};

// A view of a callable `void(const SurfaceBatch&)`, called by several threads at the same time.
class LookFunction {
 public:
  template <class F>
  LookFunction(const F& function)
      : context_(&function), call_([](const void* context, const SurfaceBatch& batch) {
          (*static_cast<const F*>(context))(batch);
        }) {}
  void operator()(const SurfaceBatch& batch) const { call_(context_, batch); }

 private:
  const void* context_;
  void (*call_)(const void*, const SurfaceBatch&);
};

struct VoxelizeOptions {
  Shell shell = Shell::thin;
  // One a triangle, or none: those that have a conservative shell within a thin one (see rims.h).
  std::span<const uint8_t> rims{};
  bool solid = false;         // fill whatever cannot be reached from outside over faces of voxels
                              // without passing the shell: an open mesh holds what its shell does
  uint16_t inside_color = 0;  // of the filling; its normals are +Z
  uint64_t memory_limit = uint64_t{8} << 30;  // bytes; more is an error
};

// Contains every triangle that has an area and finite vertices; empty if there is none.
Box surface_box(std::span<const vec3> positions, std::span<const uvec3> triangles);

// The grid with `resolution` voxels (1 to kHighestResolution) along the box's longest side, or with
// voxels of the given side. Nothing in the box touches the grid's border. Errors: usage for other
// numbers and for more than kHighestResolution voxels; bad_input for boxes that are empty, or so
// large, small or far from the origin that float coordinates cannot tell voxels apart.
Result<VoxelGrid> grid_of_resolution(const Box& box, uint32_t resolution);
Result<VoxelGrid> grid_of_voxels(const Box& box, float voxel);

// How many voxels along a side of this length count as one of `resolution`.
double voxel_side(double longest, uint32_t resolution);

// What of the triangles lies in the grid. The same bits for any number of threads. An error
// (runtime) if it would take more memory than allowed.
Result<VoxelSurface> voxelize(std::span<const vec3> positions, std::span<const uvec3> triangles,
                              const VoxelGrid& grid, LookFunction look,
                              const VoxelizeOptions& options = {});

// The same, a few blocks at a time. What it is given must outlive it.
class SurfaceVoxelizer {
 public:
  SurfaceVoxelizer(std::span<const vec3> positions, std::span<const uvec3> triangles,
                   const VoxelGrid& grid, LookFunction look, const VoxelizeOptions& options);
  ~SurfaceVoxelizer();

  const VoxelGrid& grid() const { return grid_; }
  bool solid() const { return solid_; }
  std::span<const uint32_t> blocks() const;  // Morton codes of those that triangles meet, rising
  // Of each of them without filling: at least as many as there are. Takes as long as marking.
  std::vector<uint64_t> most_fragments();
  Result<VoxelSurface> all();
  // Of blocks()[which[0]], ..., rising. Not for solids: what is inside is known of the whole only.
  Result<VoxelSurface> some(std::span<const uint32_t> which);

 private:
  struct Work;
  VoxelGrid grid_;
  bool solid_;
  std::unique_ptr<Work> work_;
};

}  // namespace sinew
