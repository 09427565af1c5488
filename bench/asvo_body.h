// The bodies of `sinew bench asvo`: all skinned meshes of a scene as one surface, voxelised, with
// the same voxels for every method.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/render/camera.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/make/voxelize.h"

namespace sinew::bench {

struct AsvoBody {
  std::string name;
  Scene triangles;     // the source; what is not part of the body is hidden
  Scene voxels;        // the same nodes, clips and lights, and the body as one octree
  bool turns = false;  // static: it is placed anew every frame, and no joint moves it

  // The body's surface.
  std::vector<vec3> rest;
  std::vector<uvec3> faces;
  std::vector<uint16_t> materials;
  std::vector<uint16_t> joints;  // of the pose that the octree takes
  std::vector<float> weights;
  uint32_t influences = 0;
  uint32_t joint_count = 0;

  VoxelSurface surface;
  double voxelise_ms = 0.0, make_ms = 0.0;

  AsvoBody() = default;
  AsvoBody(AsvoBody&&) = default;
  AsvoBody& operator=(AsvoBody&&) = default;

  Motion motion() const;
  SvoSource source() const { return {faces, materials, motion()}; }
  const Svo& svo() const { return voxels.octrees[0]; }
};

// "creature", "pigman" or "static": the creature without a skeleton.
struct AsvoBodyChoice {
  std::string name;
  std::string input;  // as load() and study scenes take it
  bool turns = false;
};

Result<AsvoBody> open_asvo_body(const AsvoBodyChoice& choice, uint32_t resolution);

// The body's surface as voxels of the grid, wherever its vertices are.
Result<VoxelSurface> voxelise_at(const AsvoBody& body, std::span<const vec3> positions,
                                 const VoxelGrid& grid);

// The same body in other voxels.
Result<void> voxelise(AsvoBody& body, uint32_t resolution);

// One instant of a body: what its octree and its triangles are drawn with.
struct AsvoPose {
  ScenePose scene;             // of `triangles`; `voxels` has the same nodes
  ScenePose drawn;             // of `voxels`
  Pose pose;                   // of the octree and of the surface
  std::vector<Affine> joints;  // what `pose` points to

  AsvoPose() = default;
  AsvoPose(AsvoPose&&) = default;
  AsvoPose& operator=(AsvoPose&&) = default;
};

// At `u`, 0..1, of a clip of the body; a static body turns once. Without clips: at rest.
void pose_at(const AsvoBody& body, int clip, double u, AsvoPose& out);

// Makes the bone of a joint `factor` times as long: the joint's matrix is scaled along it, and
// whatever hangs on it moves along. Only `pose` and `joints` change.
void stretch_bone(const AsvoBody& body, uint32_t joint, float factor, AsvoPose& pose);
// The joint with the longest bone that moves enough of the body, by its index in the pose.
uint32_t bone_to_stretch(const AsvoBody& body);

// Sees the body so that the longer side of its box in the picture takes `share` of the picture.
CameraView body_camera(const Box& box, float share);
// Of the surface in the pose, in the world.
Box body_box(const AsvoBody& body, const AsvoPose& pose);

}  // namespace sinew::bench
