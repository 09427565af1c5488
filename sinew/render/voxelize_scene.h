// Scenes of meshes -> scenes of octrees: each mesh object at rest becomes voxels that its skin and
// morph targets move on.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/make/voxelize.h"

namespace sinew {

// Takes octrees that come in parts: see SvoPartsOptions::take. The outline ends an octree.
struct OctreeTaker {
  std::function<Result<void>(const Svo& part)> part;
  std::function<Result<void>(const Svo& outline)> outline;
};

struct VoxelizeSceneOptions {
  uint32_t resolution = 512;  // 1 to kHighestResolution voxels along the longest side of the chosen
                              // objects' common box at rest, in the world
  bool each = false;          // ... of each object's own box
  double voxel = 0.0;         // > 0: the side of a voxel in the world instead
  Shell shell = Shell::thin;
  bool solid = false;
  std::vector<uint8_t> chosen;  // one an object; 0: it stays a mesh. Empty: all are chosen
  bool keep_meshes = true;      // else objects that are not chosen lose their meshes
  uint64_t memory_limit = uint64_t{8} << 30;  // bytes
  // If there is one, octrees are made in parts, as large as the memory allows, and given to it;
  // VoxelizedScene::scene has them without their voxels.
  OctreeTaker* taker = nullptr;
  bool whole_process = false;  // with a taker: what the process holds already counts in the limit
  // Called before each part of an octree; false ends the work with an error.
  std::function<bool(size_t blocks_done, size_t blocks)> on_part;
  // Called before each octree that is made; false ends the work with an error.
  std::function<bool(uint32_t octree, uint32_t octrees, const std::string& name)> on_octree;
};

// One object as voxels, before they are an octree. Views into the scene, which must outlive it.
struct VoxelizedObject {
  VoxelSurface surface;
  std::vector<uint16_t> materials;  // one a triangle
  std::span<const uvec3> triangles;
  Motion motion;  // rigid if the object's own cannot move voxels

  SvoSource source() const { return {triangles, materials, motion}; }
};

// The object (an index into Scene::objects) alone; resolution counts along its own longest side in
// its own space, `voxel` is in its own space.
Result<VoxelizedObject> voxelize_object(const Scene& scene, uint32_t object,
                                        const VoxelizeSceneOptions& options);

struct OctreeReport {
  std::string name;
  uvec3 resolution{0};
  float voxel = 0.0f;  // side, in the object's space
  uint64_t triangles = 0;
  uint64_t fragments = 0;  // pairs of voxels and triangles
  uint64_t voxels = 0;
  uint64_t bytes = 0;  // in memory, of the whole
  uint64_t parts = 1;  // in which it was made
  double voxelize_s = 0.0, octree_s = 0.0;
};

struct VoxelizedScene {
  Scene scene;
  double voxel = 0.0;  // side, in the world
  std::vector<OctreeReport> octrees;
};

// Objects that share a mesh share an octree. Vertex caches and vertex programs are taken at rest,
// and stand still; Scene::warnings say so. Nodes keep their places and what else they have; meshes
// that nothing shows are dropped. If none is left, images are too, and materials get the means of
// their textures. Errors: usage for
// options and for scenes without a chosen object, bad_input for shapes that no grid fits, and what
// voxelize() and make_svo() say.
Result<VoxelizedScene> voxelize_scene(const Scene& scene, const VoxelizeSceneOptions& options);

}  // namespace sinew
