// Morton codes of voxels.
#include "sinew/svo/make/fragments.h"

namespace sinew {
namespace {

// Puts two zero bits before each of the lowest 12 bits, and takes them out again.
uint64_t spread(uint64_t x) {
  x = (x | x << 16) & 0x00ff0000ff0000ffull;
  x = (x | x << 8) & 0xf00f00f00f00f00full;
  x = (x | x << 4) & 0x30c30c30c30c30c3ull;
  return (x | x << 2) & 0x9249249249249249ull;
}
uint32_t gather(uint64_t x) {
  x &= 0x9249249249249249ull;
  x = (x | x >> 2) & 0x30c30c30c30c30c3ull;
  x = (x | x >> 4) & 0xf00f00f00f00f00full;
  x = (x | x >> 8) & 0x00ff0000ff0000ffull;
  return static_cast<uint32_t>((x | x >> 16) & 0xffff);
}

}  // namespace

VoxelMorton morton_of(uvec3 v) {
  return spread(v.x) | spread(v.y) << 1 | spread(v.z) << 2;
}

uvec3 voxel_of(VoxelMorton m) {
  return uvec3(gather(m), gather(m >> 1), gather(m >> 2));
}

}  // namespace sinew
