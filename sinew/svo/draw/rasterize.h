// The rasteriser: octrees in poses -> which voxel is in front in every pixel.
//
//   blocks   boxes from the pose alone against the view; what is seen is posed, in parallel
//   cells    eight corners projected; box, depth, level of detail; listed for the tiles they meet
//   tiles    one thread owns a tile: cells seen in the last frame are drawn, then the rest is
//   tested against the depths that they left, and drawn if it may be seen
//
// Blocks whose detail is not in memory (svo/file/stream.h) are drawn by their cells at finest, and
// asked for unless they are hidden: when nothing more comes, the picture is that of the whole
// octree.
//
// Where the detail does not fit into memory, a picture is drawn in parts: the first shows what is
// there, each of the others what has come since, on top of what is drawn. What is still to come is
// not drawn, but hides as cells whom it would ask for. The last part completes the picture of the
// whole octree: of a pixel's voxels the least depth wins whatever the order
// (svo/draw/visibility.h).
//
// A drawn voxel covers every pixel whose centre lies in its projected box, so nothing shows through
// between neighbours, whatever the stretch. The picture is the same for any number of threads, and
// whatever was seen in the last frame.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "sinew/svo/draw/visibility.h"

namespace sinew {

struct RasterSettings {
  // Pixels: the finest level whose deformed voxels are at least as large is drawn. At 1 the fringe
  // of a body begins to reach a pixel beyond it, and little time is saved.
  float smallest = 0.75f;
  // Voxels: how far each reaches beyond itself, on every side. A thin shell leaves out what the
  // surface only grazes; without a margin about one pixel in a million shows through there.
  float margin = 0.05f;
  bool lod = true;             // else always voxels
  bool occlusion = true;       // two-phase hierarchical z
  bool front_to_back = false;  // cells sorted by depth, instead of Morton order (the thesis's)
  float large = 8.0f;          // pixels: voxels above it are drawn as boxes with faces
};

struct RasterStats {
  uint64_t blocks = 0, blocks_drawn = 0;  // drawn: in the view
  uint64_t cells = 0;                     // in the view
  uint64_t cells_hidden = 0;              // left out by depths, tile by tile
  uint64_t voxels_drawn = 0;              // of any level, tile by tile
  uint64_t leaves_drawn = 0;              // of level 0
  uint64_t nodes_drawn = 0;
  double pose_ms = 0.0, view_ms = 0.0, draw_ms = 0.0;
};

// Buffers that live from frame to frame, one for each view: a frame after the first of a size
// allocates nothing. It remembers what was seen.
struct RasterScratch;
struct RasterScratchDeleter {
  void operator()(RasterScratch* scratch) const;
};
using RasterScratchPtr = std::unique_ptr<RasterScratch, RasterScratchDeleter>;
RasterScratchPtr make_raster_scratch();

// Which part of a picture is drawn, see PagedSvo::begin_parts(). `more` needs the scratch, the size
// and the result of the part before.
enum class RasterPart : uint8_t { whole, first, more };

// Both need instances with rising `first_unit`, as many units in all as kMostUnits at most
// (checked).
RasterStats rasterize(std::span<const VoxelInstance> instances, const RasterView& view,
                      const RasterSettings& settings, RasterScratch& scratch, Visibility& out,
                      RasterPart part = RasterPart::whole);
RasterStats rasterize_depth(std::span<const VoxelInstance> instances, const RasterView& view,
                            const RasterSettings& settings, RasterScratch& scratch, DepthMap& out,
                            RasterPart part = RasterPart::whole);
// Sums what was drawn and how long it took.
void add(const RasterStats& stats, RasterStats& sum);

}  // namespace sinew
