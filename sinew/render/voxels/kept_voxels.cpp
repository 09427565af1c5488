#include "sinew/render/voxels/kept_voxels.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/voxels/voxel_tiles.h"

namespace sinew {

struct KeptVoxels::Scratch {
  TileWinners winners;
  VoxelBatch batch;
  std::vector<Voxel> voxels;
};

void KeptVoxels::clear() {
  for (std::vector<Voxel>& voxels : tiles_) voxels.clear();
}

KeptVoxels::Voxel KeptVoxels::voxel_of(uint64_t name, const VoxelBatch& batch, uint32_t i) {
  Voxel voxel;
  voxel.name = name;
  std::copy_n(batch.place[i], 4, voxel.place);
  std::copy_n(batch.normal[i], 4, voxel.normal);
  std::copy_n(batch.color[i], 3, voxel.color);
  voxel.material = batch.material[i];
  return voxel;
}

void KeptVoxels::keep_tile(std::span<const VoxelInstance> instances, Scratch& scratch,
                           std::vector<Voxel>& voxels) {
  const auto begin = scratch.winners.keys;
  const auto end = std::unique(begin, begin + scratch.winners.count,
                               [](auto a, auto b) { return key_name(a) == key_name(b); });
  scratch.voxels.clear();
  VisibilityKey* missing = begin;
  auto known = voxels.begin();
  for (const VisibilityKey* key = begin; key != end; ++key) {
    while (known != voxels.end() && known->name < key_name(*key)) ++known;
    if (known != voxels.end() && known->name == key_name(*key)) {
      scratch.voxels.push_back(*known);
    } else {
      *missing++ = *key;
    }
  }
  if (missing != begin) {
    const auto count = static_cast<uint32_t>(missing - begin);
    fetch_voxels(instances, {begin, count}, scratch.batch);
    for (uint32_t i = 0; i < count; ++i) {
      scratch.voxels.push_back(voxel_of(key_name(begin[i]), scratch.batch, i));
    }
    std::ranges::sort(scratch.voxels, {}, &Voxel::name);
  }
  voxels.assign(scratch.voxels.begin(), scratch.voxels.end());
}

void KeptVoxels::keep(std::span<const VoxelInstance> instances, const Visibility& visibility) {
  tiles_.resize(shading_tiles(visibility));
  parallel_for(tiles_.size(), 4, [&](size_t first, size_t last) {
    Scratch scratch;
    for (size_t i = first; i < last; ++i) {
      TileWinners& winners = scratch.winners;
      list_winners(visibility, shading_tile(visibility, i), winners);
      std::sort(winners.keys, winners.keys + winners.count,
                [](auto a, auto b) { return key_name(a) < key_name(b); });
      keep_tile(instances, scratch, tiles_[i]);
    }
  });
}

void KeptVoxels::fetch(size_t tile, std::span<const VisibilityKey> keys, VoxelBatch& out) const {
  const std::vector<Voxel>& voxels = tiles_[tile];
  out.count = static_cast<uint32_t>(keys.size());
  for (uint32_t i = 0; i < out.count; ++i) {
    const auto found = std::ranges::lower_bound(voxels, key_name(keys[i]), {}, &Voxel::name);
    SINEW_CHECK(found != voxels.end() && found->name == key_name(keys[i]));
    std::copy_n(found->place, 4, out.place[i]);
    std::copy_n(found->normal, 4, out.normal[i]);
    std::copy_n(found->color, 3, out.color[i]);
    out.color[i][3] = 0.0f;
    out.material[i] = found->material;
  }
  out.pad();
}

}  // namespace sinew
