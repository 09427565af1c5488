#include "bench/openvdb_volume.h"

#ifdef SINEW_OPENVDB
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#endif

namespace sinew::bench {

#ifdef SINEW_OPENVDB

namespace {

// What meshToVolume asks of a mesh, in voxels.
struct Mesh {
  std::span<const vec3> positions;
  std::span<const uvec3> triangles;
  float scale = 1.0f;

  size_t polygonCount() const { return triangles.size(); }
  size_t pointCount() const { return positions.size(); }
  size_t vertexCount(size_t) const { return 3; }
  void getIndexSpacePoint(size_t triangle, size_t corner, openvdb::Vec3d& out) const {
    const vec3 p = positions[triangles[triangle][static_cast<int>(corner)]] * scale;
    out = openvdb::Vec3d(p.x, p.y, p.z);
  }
};

}  // namespace

std::optional<uint64_t> mesh_to_volume(std::span<const vec3> positions,
                                       std::span<const uvec3> triangles, float voxel) {
  openvdb::initialize();
  const Mesh mesh{positions, triangles, 1.0f / voxel};
  const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      mesh, *openvdb::math::Transform::createLinearTransform(voxel), 1.0f, 1.0f,
      openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  return grid->activeVoxelCount();
}

#else

std::optional<uint64_t> mesh_to_volume(std::span<const vec3>, std::span<const uvec3>, float) {
  return std::nullopt;
}

#endif

}  // namespace sinew::bench
