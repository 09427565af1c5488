// Octrees in files, opened to come and go.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "io/hostile.h"
#include "sinew/svo/file/stream.h"
#include "svo/svo_oracle.h"

namespace sinew::test {

// A sphere of voxels, one or two thick.
inline std::vector<PlainVoxel> shell_voxels(uint32_t resolution, float radius, uint32_t seed) {
  std::map<VoxelMorton, PlainVoxel> voxels;
  Random random(seed);
  const float half = 0.5f * static_cast<float>(resolution);
  for (uint32_t z = 0; z < resolution; ++z) {
    for (uint32_t y = 0; y < resolution; ++y) {
      for (uint32_t x = 0; x < resolution; ++x) {
        const vec3 d = vec3(x, y, z) + 0.5f - half;
        if (std::abs(length(d) - radius) > 0.8f) continue;
        const VoxelMorton at = morton_of(uvec3(x, y, z));
        voxels[at] = {at, pack_normal(d), static_cast<uint16_t>(random.next()), 0};
      }
    }
  }
  std::vector<PlainVoxel> out;
  for (const auto& [morton, voxel] : voxels) out.push_back(voxel);
  return out;
}

// An encoded octree in a file of its own.
class SvoOnDisk {
 public:
  explicit SvoOnDisk(const Svo& svo) {
    const Result<EncodedSvo> encoded = encode_svo(svo, 3);
    EXPECT_TRUE(encoded) << encoded.error().message();
    write({encoded->bytes.begin(), encoded->bytes.end()});
  }
  void write(const std::string& bytes) {
    bytes_ = bytes;
    path_ = folder_.write("a.octree", bytes);
  }
  const std::string& bytes() const { return bytes_; }
  const std::string& path() const { return path_; }

  Result<SvoInFile> find() const {
    SINEW_TRY(RandomFile file, RandomFile::open(path_));
    const auto shared = std::make_shared<const RandomFile>(std::move(file));
    return find_svo(shared, 0, shared->size(), uint64_t{1} << 30);
  }
  // With `spare` bytes more than the least.
  Result<Svo> open(uint64_t spare, bool settle = false) const {
    SINEW_TRY(SvoInFile found, find());
    const uint64_t budget = found.least + spare;
    return PagedSvo::open(std::move(found), {budget, settle});
  }

 private:
  TemporaryFolder folder_;
  std::string bytes_, path_;
};

// Asks for blocks until they are there, as far as they fit.
inline void ask(Svo& svo, const std::vector<uint32_t>& blocks, float priority = 1.0f) {
  for (const uint32_t block : blocks) svo.paging->request(block, priority);
  svo.paging->settle();
}

inline std::vector<uint32_t> all_blocks(const Svo& svo) {
  std::vector<uint32_t> all;
  for (uint32_t b = 0; b < svo.block_count(); ++b) all.push_back(b);
  return all;
}

}  // namespace sinew::test
