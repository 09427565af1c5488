#include "bench/asvo_methods.h"

#include <utility>

namespace sinew::bench {

const char* name_of(AsvoMethod method) {
  constexpr const char* kNames[] = {"lattice", "corners", "thesis", "thesis without S"};
  return kNames[static_cast<size_t>(method)];
}

AsvoPainter::AsvoPainter(const AsvoBody& body) : body_(body), motion_(make_svo_motion(body.svo())) {
  std::vector<ThesisVoxel> voxels = make_thesis_voxels(body.surface, body.source());
  octree_ = make_thesis_octree(body.surface.grid, voxels, body.joint_count);
  corners_ = make_corner_voxels(body.surface.grid, std::move(voxels), body.joint_count);
}

void AsvoPainter::set_pose(const AsvoPose& pose) {
  pose_ = pose.pose;
  posed_.set_pose(motion_, pose_);
}

ThesisInstance AsvoPainter::thesis_instance() const {
  return {&octree_, pose_.joints, pose_.placement, 0};
}

CornerInstance AsvoPainter::corner_instance() const {
  return {&corners_, pose_.joints, pose_.placement, 0};
}

VoxelInstance AsvoPainter::lattice_instance() {
  return {&posed_, pose_.placement, 0};
}

void AsvoPainter::draw(AsvoMethod method, const RasterView& view, Visibility& out) {
  if (method == AsvoMethod::lattice) {
    const VoxelInstance instance = lattice_instance();
    lattice_stats = rasterize({&instance, 1}, view, settings, *scratch_, out);
  } else if (method == AsvoMethod::corners) {
    const CornerInstance instance = corner_instance();
    rasterize_corners({&instance, 1}, view, corner_scratch_, out);
  } else {
    const ThesisInstance instance = thesis_instance();
    const ThesisSettings how{.enlarge = method == AsvoMethod::thesis};
    thesis_stats = rasterize_thesis({&instance, 1}, view, how, thesis_scratch_, out);
  }
}

}  // namespace sinew::bench
