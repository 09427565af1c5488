#include "sinew/svo/thesis/thesis_corners.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kGrain = 4096;  // corners

uvec3 corner_place(uvec3 voxel, uint32_t corner) {
  return voxel + uvec3(corner & 1, corner >> 1 & 1, corner >> 2);
}

// A corner for a voxel that it belongs to.
struct CornerUse {
  uint64_t place = 0;  // 13 bits an axis
  uint32_t voxel = 0;
  uint32_t corner = 0;
};

std::vector<CornerUse> list_corners(std::span<const ThesisVoxel> voxels) {
  std::vector<CornerUse> out;
  out.reserve(8 * voxels.size());
  for (uint32_t v = 0; v < voxels.size(); ++v) {
    const uvec3 voxel = voxel_of(voxels[v].voxel);
    for (uint32_t c = 0; c < 8; ++c) {
      const uvec3 p = corner_place(voxel, c);
      out.push_back({uint64_t{p.x} | uint64_t{p.y} << 13 | uint64_t{p.z} << 26, v, c});
    }
  }
  std::ranges::sort(out, [](const CornerUse& a, const CornerUse& b) {
    return a.place != b.place ? a.place < b.place : a.voxel < b.voxel;
  });
  return out;
}

vec3 place_to_vec(uint64_t place) {
  return vec3(static_cast<float>(place & 8191), static_cast<float>(place >> 13 & 8191),
              static_cast<float>(place >> 26));
}

void cover(const std::array<uint32_t, 8>& corner, std::span<const vec4> projected,
           VisibilityKey key, Visibility& out) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  vec2 low(kInfinity), high(-kInfinity);
  for (const uint32_t c : corner) {
    low = glm::min(low, vec2(projected[c]));
    high = glm::max(high, vec2(projected[c]));
  }
  const auto whole = [](float v, uint32_t size) {
    return static_cast<int64_t>(std::clamp(v, -1.0f, static_cast<float>(size)));
  };
  const auto [x0, y0] = std::pair(std::max<int64_t>(whole(std::ceil(low.x - 0.5f), out.width), 0),
                                  std::max<int64_t>(whole(std::ceil(low.y - 0.5f), out.height), 0));
  const int64_t x1 = std::min<int64_t>(whole(std::floor(high.x - 0.5f), out.width), out.width - 1);
  const int64_t y1 =
      std::min<int64_t>(whole(std::floor(high.y - 0.5f), out.height), out.height - 1);
  for (int64_t y = y0; y <= y1; ++y) {
    VisibilityKey* const row = &out.keys[static_cast<size_t>(y) * out.width];
    for (int64_t x = x0; x <= x1; ++x) row[x] = std::min(row[x], key);
  }
}

}  // namespace

size_t CornerVoxels::bytes() const {
  return voxels.size() * (sizeof(ThesisVoxel) - sizeof(ThesisWeights) + sizeof(corner[0])) +
         rest.size() * (sizeof(vec3) + sizeof(ThesisWeights));
}

CornerVoxels make_corner_voxels(const VoxelGrid& grid, std::vector<ThesisVoxel> voxels,
                                uint32_t joints) {
  CornerVoxels out{.grid = grid, .joints = joints, .voxels = std::move(voxels)};
  out.corner.resize(out.voxels.size());
  const std::vector<CornerUse> uses = list_corners(out.voxels);
  for (size_t i = 0; i < uses.size();) {
    const auto number = static_cast<uint32_t>(out.rest.size());
    ThesisMix mix;
    mix.clear();
    size_t end = i;
    for (; end < uses.size() && uses[end].place == uses[i].place; ++end) {
      mix.add(out.voxels[uses[end].voxel].skin, 1.0f);
      out.corner[uses[end].voxel][uses[end].corner] = number;
    }
    out.rest.push_back(grid.origin + grid.voxel * place_to_vec(uses[i].place));
    out.skin.push_back(mix.mean());
    i = end;
  }
  return out;
}

namespace {

void project_corners(const CornerInstance& instance, const RasterView& view,
                     CornerScratch& scratch) {
  const CornerVoxels& voxels = *instance.voxels;
  const std::span<const Affine> joints =
      voxels.joints == 0 ? std::span<const Affine>() : instance.joints;
  scratch.projected.resize(voxels.rest.size());
  parallel_for(voxels.rest.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const vec3 moved = thesis_point(voxels.skin[i], joints, voxels.rest[i]);
      const vec4 p(transform_point(instance.placement, moved), 1.0f);
      const float w = dot(view.w, p), depth = dot(view.depth, p);
      const vec4 at(dot(view.x, p) / w, dot(view.y, p) / w, depth, 1.0f);
      const bool seen = depth > view.near && std::isfinite(at.x + at.y + at.z);
      scratch.projected[i] = seen ? at : vec4(0.0f);
    }
  });
}

}  // namespace

uint64_t rasterize_corners(std::span<const CornerInstance> instances, const RasterView& view,
                           CornerScratch& scratch, Visibility& out) {
  out.width = view.width;
  out.height = view.height;
  out.keys.assign(size_t{view.width} * view.height, kNothing);
  uint64_t drawn = 0;
  for (const CornerInstance& instance : instances) {
    const CornerVoxels& voxels = *instance.voxels;
    SINEW_CHECK(voxels.joints == 0 || instance.joints.size() >= voxels.joints);
    SINEW_CHECK(instance.first_unit + unit_count(voxels) <= kMostUnits);
    project_corners(instance, view, scratch);
    for (size_t v = 0; v < voxels.voxels.size(); ++v) {
      vec4 sum(0.0f);
      for (const uint32_t c : voxels.corner[v]) sum += scratch.projected[c];
      if (sum.w != 8.0f) continue;
      ++drawn;
      const auto number = static_cast<uint32_t>(v);
      cover(voxels.corner[v], scratch.projected,
            make_key(0.125f * sum.z, instance.first_unit + (number >> 10), number & 1023), out);
    }
  }
  return drawn;
}

VoxelSample sample_corners(std::span<const CornerInstance> instances, VisibilityKey key) {
  const uint32_t unit = key_unit(key);
  const auto after = std::ranges::upper_bound(instances, unit, {}, &CornerInstance::first_unit);
  SINEW_DCHECK(after != instances.begin());
  const CornerInstance& instance = *(after - 1);
  const CornerVoxels& voxels = *instance.voxels;
  VoxelSample out;
  out.instance = static_cast<uint32_t>(&instance - instances.data());
  out.unit = unit - instance.first_unit;
  out.code = key_code(key);
  const size_t index = size_t{out.unit} << 10 | out.code;
  const ThesisVoxel& voxel = voxels.voxels[index];
  const std::span<const Affine> joints =
      voxels.joints == 0 ? std::span<const Affine>() : instance.joints;
  vec3 sum(0.0f);
  for (const uint32_t c : voxels.corner[index]) {
    sum += thesis_point(voxels.skin[c], joints, voxels.rest[c]);
  }
  const Affine& placement = instance.placement;
  out.position = transform_point(placement, 0.125f * sum);
  out.material = voxel.material;
  out.size = voxels.grid.voxel * std::cbrt(std::abs(glm::determinant(linear_part(placement))));
  out.normal = normalize(cofactor(placement) * unpack_normal(voxel.normal));
  out.color = unpack_color(voxel.color);
  return out;
}

}  // namespace sinew
