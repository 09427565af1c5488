#include "sinew/svo/thesis/thesis_skinned.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew {
namespace {

constexpr uint32_t kSlack = 16;

uvec3 first_voxel(const SvoBlock& block, const SvoCell& cell) {
  const uint32_t place = cell.place;
  return kBlockSide * uvec3(block.x, block.y, block.z) +
         kCellSide * uvec3(place & 7, place >> 3 & 7, place >> 6);
}

// Weights in 255ths; rounding goes to the heaviest.
uint32_t pack_weights(const ThesisWeights& skin) {
  uint32_t packed = 0, sum = 0;
  for (uint32_t k = 1; k < kSvoInfluences; ++k) {
    const auto w = static_cast<uint32_t>(skin.weights[k] * 255.0f + 0.5f);
    packed |= w << 8 * k;
    sum += w;
  }
  return packed | (255 - sum);
}

// Of a cell: sums up what its voxels weigh, by the code of each level.
class CellSkins {
 public:
  CellSkins(std::span<const ThesisVoxel> voxels, uvec3 first) {
    const VoxelMorton begin = morton_of(first);
    const auto at = std::ranges::lower_bound(voxels, begin, {}, &ThesisVoxel::voxel);
    for (auto it = at; it != voxels.end() && it->voxel >> 9 == begin >> 9; ++it) {
      skins_[it->voxel & 511] = it->skin;
    }
  }

  // The mean of the occupied voxels in a voxel of the level.
  ThesisWeights at(VoxelPlace place, std::span<const uint64_t, 8> masks) const {
    ThesisMix mix;
    mix.clear();
    for (uint32_t i = 0; i < place.side * place.side * place.side; ++i) {
      const uvec3 v = place.min + uvec3(i % place.side, i / place.side % place.side,
                                        i / (place.side * place.side));
      const uint32_t brick = v.x / 4 + 2 * (v.y / 4) + 4 * (v.z / 4);
      const uint32_t bit = v.x % 4 + 4 * (v.y % 4) + 16 * (v.z % 4);
      if (masks[brick] >> bit & 1) mix.add(skins_[morton_of(v)], 1.0f);
    }
    return mix.mean();
  }

 private:
  ThesisWeights skins_[512];
};

struct Palette {
  std::array<uint8_t, SkinnedVoxels::kPalette> joints{};
  uint32_t count = 0;
  bool full = false;

  uint32_t slot_of(uint32_t joint) {
    for (uint32_t i = 0; i < count; ++i) {
      if (joints[i] == joint) return i;
    }
    full |= count == joints.size();
    if (full) return 0;
    joints[count] = static_cast<uint8_t>(joint);
    return count++;
  }
};

void add_voxel(const ThesisWeights& skin, Palette& palette, SkinnedLevel& out) {
  uint32_t joints = 0, slots = 0;
  for (uint32_t k = 0; k < kSvoInfluences; ++k) {
    // An unused influence names the first joint, so that it takes no place in the palette.
    const uint32_t joint = skin.weights[k] > 0.0f ? skin.joints[k] : skin.joints[0];
    joints |= joint << 8 * k;
    slots |= palette.slot_of(joint) << 8 * k;
  }
  out.joints.push_back(joints);
  out.palette_slots.push_back(slots);
  out.weights.push_back(pack_weights(skin));
}

uint32_t size_of(const SkinnedLevel& level) {
  return static_cast<uint32_t>(level.joints.size());
}

void add_cell(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
              std::span<const ThesisVoxel> voxels, SkinnedVoxels& out) {
  const CellSkins skins(voxels, first_voxel(block, cell));
  uint64_t masks[8] = {};
  uint32_t brick = block.first_brick + cell.first_brick;
  for (uint32_t b = 0; b < 8; ++b) {
    if (cell.bricks >> b & 1) masks[b] = svo.bricks[brick++];
  }
  out.first.push_back({size_of(out.levels[0]), size_of(out.levels[1]), size_of(out.levels[2])});
  Palette palette;
  const auto add = [&](VoxelCode code) {
    add_voxel(skins.at(place_of(code), masks), palette, out.levels[level_of(code)]);
  };
  for (uint32_t b = 0; b < 8; ++b) {
    for (uint64_t rest = masks[b]; rest != 0; rest &= rest - 1) {
      add(64 * b + static_cast<uint32_t>(std::countr_zero(rest)));
    }
  }
  for (uint64_t rest = coarse_voxels(cell, &svo.bricks[block.first_brick + cell.first_brick]);
       rest != 0; rest &= rest - 1) {
    add(kFirstCode[1] + static_cast<uint32_t>(std::countr_zero(rest)));
  }
  for (uint32_t b = 0; b < 8; ++b) {
    if (cell.bricks >> b & 1) add(kFirstCode[2] + b);
  }
  out.palettes.push_back(palette.joints);
  out.palette_sizes.push_back(palette.full ? uint8_t{0} : static_cast<uint8_t>(palette.count));
}

}  // namespace

SkinnedVoxels make_skinned_voxels(const Svo& svo, std::span<const ThesisVoxel> voxels) {
  SINEW_CHECK(svo.joints <= SkinnedVoxels::kMostJoints);
  SkinnedVoxels out;
  out.joints = svo.joints;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    for (uint32_t c = block.first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      add_cell(svo, block, svo.cells[c], voxels, out);
    }
  }
  for (SkinnedLevel& level : out.levels) {
    for (std::vector<uint32_t>* values : {&level.joints, &level.palette_slots, &level.weights}) {
      values->resize(values->size() + kSlack, 0);
    }
  }
  return out;
}

void set_view(const VoxelInstance& instance, const RasterView& view, SkinnedTable& out) {
  const VoxelGrid& grid = instance.posed->svo().grid;
  const std::span<const Affine> joints = instance.posed->pose().joints;
  const uint32_t count = std::max(out.voxels->joints, 1u);
  out.rows.resize(size_t{16} * count);
  for (uint32_t j = 0; j < count; ++j) {
    const glm::dmat4x3 joint(out.voxels->joints == 0 ? identity_affine() : joints[j]);
    const glm::dmat4x3 placement(instance.placement);
    // voxels -> object at rest -> pose -> world
    const auto to_world = [&](glm::dvec4 p) { return placement * glm::dvec4(joint * p, p.w); };
    const glm::dvec3 columns[4] = {
        to_world({grid.voxel, 0.0, 0.0, 0.0}), to_world({0.0, grid.voxel, 0.0, 0.0}),
        to_world({0.0, 0.0, grid.voxel, 0.0}), to_world(glm::dvec4(grid.origin, 1.0))};
    const vec4 functions[3] = {view.x, view.y, view.depth};
    for (uint32_t row = 0; row < 3; ++row) {
      const glm::dvec4 f(functions[row]);
      for (uint32_t c = 0; c < 4; ++c) {
        const double value = dot(glm::dvec3(f), columns[c]) + (c == 3 ? f.w : 0.0);
        out.rows[16 * j + 4 * row + c] = static_cast<float>(value);
      }
    }
  }
}

}  // namespace sinew
