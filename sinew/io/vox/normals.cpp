#include "sinew/io/vox/normals.h"

#include "sinew/base/parallel.h"

namespace sinew::vox {
namespace {

constexpr int kReach = 2;

// A bit a voxel, with a margin.
class Occupancy {
 public:
  Occupancy(uvec3 resolution, std::span<const PlainVoxel> voxels)
      : size_(resolution + 2u * kReach), bits_(size_t{size_.x} * size_.y * size_.z) {
    for (const PlainVoxel& v : voxels) bits_[index(voxel_of(v.voxel) + uvec3(kReach))] = true;
  }
  // `offset` is at most kReach.
  bool at(uvec3 voxel, glm::ivec3 offset) const {
    return bits_[index(uvec3(glm::ivec3(voxel) + kReach + offset))];
  }

 private:
  size_t index(uvec3 v) const { return v.x + size_t{size_.x} * (v.y + size_t{size_.y} * v.z); }

  uvec3 size_;
  std::vector<bool> bits_;
};

// From the voxels around to where there are none.
vec3 gradient(const Occupancy& occupied, uvec3 voxel) {
  vec3 sum(0.0f);
  for (int z = -kReach; z <= kReach; ++z) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        const vec3 away(x, y, z);
        if ((x != 0 || y != 0 || z != 0) && occupied.at(voxel, {x, y, z})) {
          sum -= away / dot(away, away);
        }
      }
    }
  }
  if (dot(sum, sum) > 1e-3f) return sum;
  // Alike on both sides: any free face, the upper one first.
  for (const glm::ivec3 face : {glm::ivec3(0, 1, 0), glm::ivec3(0, 0, 1), glm::ivec3(1, 0, 0),
                                glm::ivec3(-1, 0, 0), glm::ivec3(0, 0, -1), glm::ivec3(0, -1, 0)}) {
    if (!occupied.at(voxel, face)) return vec3(face);
  }
  return vec3(0.0f, 1.0f, 0.0f);
}

}  // namespace

void set_normals(uvec3 resolution, std::vector<PlainVoxel>& voxels) {
  const Occupancy occupied(resolution, voxels);
  parallel_for(voxels.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      voxels[i].normal = pack_normal(gradient(occupied, voxel_of(voxels[i].voxel)));
    }
  });
}

}  // namespace sinew::vox
