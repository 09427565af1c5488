// The ways of drawing a skinned octree that the bench compares, behind one call.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "bench/asvo_body.h"
#include "sinew/svo/draw/rasterize.h"
#include "sinew/svo/thesis/thesis.h"
#include "sinew/svo/thesis/thesis_corners.h"

namespace sinew::bench {

enum class AsvoMethod : uint8_t { lattice, corners, thesis, thesis_plain };
inline constexpr std::array kAsvoMethods = {AsvoMethod::lattice, AsvoMethod::corners,
                                            AsvoMethod::thesis, AsvoMethod::thesis_plain};
const char* name_of(AsvoMethod method);

// Everything that draws one body. The body must outlive it, and not be voxelised anew.
class AsvoPainter {
 public:
  explicit AsvoPainter(const AsvoBody& body);

  void set_pose(const AsvoPose& pose);
  void draw(AsvoMethod method, const RasterView& view, Visibility& out);

  PosedSvo& posed() { return posed_; }
  const ThesisOctree& octree() const { return octree_; }
  ThesisInstance thesis_instance() const;
  CornerInstance corner_instance() const;
  VoxelInstance lattice_instance();

  RasterSettings settings;    // of the lattice
  RasterStats lattice_stats;  // of its last picture
  ThesisStats thesis_stats;   // of the last one of either kind

 private:
  const AsvoBody& body_;
  SvoMotion motion_;
  PosedSvo posed_;
  Pose pose_;
  RasterScratchPtr scratch_ = make_raster_scratch();
  ThesisOctree octree_;
  ThesisScratch thesis_scratch_;
  CornerVoxels corners_;
  CornerScratch corner_scratch_;
};

}  // namespace sinew::bench
