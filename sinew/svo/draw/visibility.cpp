// What a key of the picture names, looked up from scratch.
#include "sinew/svo/draw/visibility.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/svo/voxel_at.h"

namespace sinew {
namespace {

// The last of `items`, sorted by `first`, that begins at or before `index`.
template <class Items, class First>
uint32_t holder_of(const Items& items, uint32_t index, const First& first) {
  const auto found =
      std::upper_bound(items.begin(), items.end(), index,
                       [&](uint32_t i, const auto& item) { return i < first(item); });
  SINEW_CHECK(found != items.begin());
  return static_cast<uint32_t>(found - items.begin()) - 1;
}

// Side of a unit cube of the object in the world.
float scale_of(const Affine& placement) {
  return std::cbrt(std::abs(glm::determinant(linear_part(placement))));
}

vec3 unit_or_up(vec3 v) {
  const float l = length(v);
  return l > 0.0f ? v / l : vec3(0.0f, 0.0f, 1.0f);
}

void set_attributes(const VoxelAttributes& a, const mat3& normal_map, VoxelSample& out) {
  out.normal = unit_or_up(normal_map * a.normal);
  out.color = a.color;
  out.spread = a.spread;
}

// Calls with all cells below the node.
template <class F>
void for_each_cell_below(const Svo& svo, uint32_t n, const F& call) {
  const SvoNode& node = svo.nodes[n];
  for (uint32_t child = node.first; child < node.first + node.count; ++child) {
    if (node.level == kCellLevel + 1) {
      call(child);
    } else {
      for_each_cell_below(svo, child, call);
    }
  }
}

Box bounds_of(const PosedSvo& posed, uint32_t n) {
  const Svo& svo = posed.svo();
  if (svo.nodes[n].level >= kBlockLevel) return posed.bounds(n);
  Box box;
  for_each_cell_below(svo, n, [&](uint32_t c) {
    const PosedBlock block = posed.block(block_of(svo, c));
    for (const uint16_t corner : svo.cells[c].corner) box.extend(block.positions[corner]);
  });
  return box;
}

uint32_t first_cell_below(const Svo& svo, uint32_t node) {
  while (svo.nodes[node].level > kCellLevel + 1) node = svo.nodes[node].first;
  return svo.nodes[node].first;
}

// A shell's middles lie within half of a voxel's largest step along the normal of the surface, on
// either side, and each box is that of the mapped corners, in the object's space.
float clearance_of(const VoxelInstance& body, const SvoCell& cell, const PosedBlock& posed,
                   vec3 local, float side, vec3 normal) {
  constexpr float kMargin = 1.1f;  // beyond a box: what it is padded by
  const vec3 n = transpose(linear_part(body.placement)) * normal;
  vec3 half(0.0f);
  float step = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    vec3 to(0.0f);
    to[axis] = 0.5f * side;
    const vec3 edge = map_point(cell, posed, local + to) - map_point(cell, posed, local - to);
    half += 0.5f * abs(edge);
    step = std::max(step, std::abs(dot(n, edge)));
  }
  return step + kMargin * dot(abs(n), half);
}

void sample_cell(const VoxelInstance& body, uint32_t c, VoxelSample& out) {
  const Svo& svo = body.posed->svo();
  const uint32_t b = block_of(svo, c);
  const SvoCell& cell = svo.cells[c];
  const PosedBlock posed = body.posed->block(b);
  const VoxelPlace place = place_of(out.code);
  const vec3 local =
      (vec3(place.min) + 0.5f * static_cast<float>(place.side)) / static_cast<float>(kCellSide);
  out.level = level_of(out.code);
  out.material = cell.material;
  out.position = transform_point(body.placement, map_point(cell, posed, local));
  out.size = static_cast<float>(place.side) * svo.grid.voxel * scale_of(body.placement);
  const VoxelAttributes a = voxel_attributes(svo, svo.blocks[b], cell, out.code);
  set_attributes(a, cofactor(body.placement) * map_normals(cell, posed, local), out);
  out.clearance =
      clearance_of(body, cell, posed, local,
                   static_cast<float>(place.side) / static_cast<float>(kCellSide), out.normal);
}

// Nodes are drawn where they are at most a pixel: their normals are carried by the placement alone.
void sample_node(const VoxelInstance& body, uint32_t n, VoxelSample& out) {
  const Svo& svo = body.posed->svo();
  out.level = svo.nodes[n].level;
  out.material = svo.cells[first_cell_below(svo, n)].material;
  out.position = transform_point(body.placement, bounds_of(*body.posed, n).center());
  out.size = static_cast<float>(1u << out.level) * svo.grid.voxel * scale_of(body.placement);
  set_attributes(level_attributes(svo.node_level, n), cofactor(body.placement), out);
  out.clearance = 2.0f * out.size;
}

}  // namespace

VoxelSample sample_voxel(std::span<const VoxelInstance> instances, VisibilityKey key) {
  SINEW_CHECK(key != kNothing);
  VoxelSample out;
  out.instance = holder_of(instances, key_unit(key),
                           [](const VoxelInstance& body) { return body.first_unit; });
  const VoxelInstance& body = instances[out.instance];
  out.unit = key_unit(key) - body.first_unit;
  out.code = key_code(key);
  const uint32_t cells = static_cast<uint32_t>(body.posed->svo().cells.size());
  if (out.unit < cells) {
    sample_cell(body, out.unit, out);
  } else {
    sample_node(body, out.unit - cells, out);
  }
  return out;
}

VoxelSample sample_voxel_hit(const VoxelInstance& instance, uint32_t primitive) {
  VoxelSample out;
  out.unit = primitive >> 10;
  out.code = primitive & 1023;
  sample_cell(instance, out.unit, out);
  return out;
}

}  // namespace sinew
