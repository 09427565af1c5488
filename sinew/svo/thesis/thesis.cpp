#include "sinew/svo/thesis/thesis.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew {
namespace {

// Nodes of one level with the Morton codes of their places, while the octree is made bottom-up.
struct Level {
  std::vector<VoxelMorton> places;
  std::vector<ThesisNode> nodes;  // first_child counts within the level below
};

Level leaves_of(std::span<const ThesisVoxel> voxels) {
  Level out;
  out.places.reserve(voxels.size());
  out.nodes.reserve(voxels.size());
  for (const ThesisVoxel& voxel : voxels) {
    out.places.push_back(voxel.voxel);
    out.nodes.push_back({.material = voxel.material,
                         .skin = voxel.skin,
                         .normal = unpack_normal(voxel.normal),
                         .color = voxel.color});
  }
  return out;
}

ThesisNode parent_of(std::span<const ThesisNode> children) {
  ThesisNode out{.level = static_cast<uint8_t>(children[0].level + 1),
                 .material = children[0].material};
  ThesisMix mix;
  mix.clear();
  vec3 normal(0.0f), color(0.0f);
  for (const ThesisNode& child : children) {
    mix.add(child.skin, 1.0f);
    normal += child.normal;
    color += unpack_color(child.color);
  }
  out.skin = mix.mean();
  out.normal = dot(normal, normal) > 1e-12f ? normalize(normal) : children[0].normal;
  out.color = pack_color(color / static_cast<float>(children.size()));
  return out;
}

Level level_above(const Level& below) {
  Level out;
  for (size_t i = 0; i < below.places.size();) {
    const VoxelMorton place = below.places[i] >> 3;
    size_t end = i;
    uint8_t children = 0;
    for (; end < below.places.size() && below.places[end] >> 3 == place; ++end) {
      children = static_cast<uint8_t>(children | 1u << (below.places[end] & 7));
    }
    ThesisNode node = parent_of({&below.nodes[i], end - i});
    node.first_child = static_cast<uint32_t>(i);
    node.children = children;
    out.places.push_back(place);
    out.nodes.push_back(node);
    i = end;
  }
  return out;
}

vec3 center_of(const VoxelGrid& grid, const ThesisVisit& visit, uint32_t level) {
  const vec3 low(static_cast<float>(visit.x), static_cast<float>(visit.y),
                 static_cast<float>(visit.z));
  return grid.origin + grid.voxel * (low + 0.5f * static_cast<float>(1u << level));
}

float scale_of(const Affine& placement) {
  return std::cbrt(std::abs(glm::determinant(linear_part(placement))));
}

// Pixels that something of length 1 at depth 1 covers in the middle of the picture.
float pixels_per_unit(const RasterView& view) {
  const float middle = 0.5f * static_cast<float>(view.width);
  return length(vec3(view.x) - middle * vec3(view.w));
}

void draw(const ThesisSquare& square, VisibilityKey key, Visibility& out) {
  const float half = 0.5f * square.size;
  // Both are clamped before they are turned into whole numbers: squares may be anywhere.
  const auto whole = [](float v, uint32_t size) {
    return static_cast<int64_t>(std::clamp(v, -1.0f, static_cast<float>(size)));
  };
  const auto range = [&](float middle, uint32_t size) {
    const int64_t own = whole(std::floor(middle), size);
    return std::pair(std::min(own, whole(std::ceil(middle - half - 0.5f), size)),
                     std::max(own, whole(std::floor(middle + half - 0.5f), size)));
  };
  const auto [x0, x1] = range(square.x, out.width);
  const auto [y0, y1] = range(square.y, out.height);
  for (int64_t y = std::max<int64_t>(y0, 0); y <= std::min<int64_t>(y1, out.height - 1); ++y) {
    VisibilityKey* const row = &out.keys[static_cast<size_t>(y) * out.width];
    for (int64_t x = std::max<int64_t>(x0, 0); x <= std::min<int64_t>(x1, out.width - 1); ++x) {
      row[x] = std::min(row[x], key);
    }
  }
}

void add_children(const ThesisNode& node, const ThesisVisit& visit,
                  std::vector<ThesisVisit>& queue) {
  const uint32_t side = 1u << (node.level - 1);
  uint32_t child = node.first_child;
  for (uint32_t bit = 0; bit < 8; ++bit) {
    if (!(node.children >> bit & 1)) continue;
    queue.push_back({child++, static_cast<uint16_t>(visit.x + (bit & 1) * side),
                     static_cast<uint16_t>(visit.y + (bit >> 1 & 1) * side),
                     static_cast<uint16_t>(visit.z + (bit >> 2) * side)});
  }
}

void rasterize_one(const ThesisInstance& instance, const RasterView& view,
                   const ThesisSettings& settings, ThesisScratch& scratch, ThesisStats& stats,
                   Visibility& out) {
  const ThesisPlacing place(instance, view, settings);
  scratch.queue.assign(1, ThesisVisit{});
  while (!scratch.queue.empty()) {
    scratch.next.clear();
    stats.visited += scratch.queue.size();
    for (const ThesisVisit& visit : scratch.queue) {
      const ThesisNode& node = instance.octree->nodes[visit.node];
      const ThesisSquare square = place(visit);
      // What is before the near plane is no proof that its children are.
      const bool large = !settings.lod || !square.visible || square.size > settings.pixel;
      if (large && node.children != 0) {
        add_children(node, visit, scratch.next);
      } else if (square.visible) {
        ++stats.drawn;
        stats.leaves_drawn += node.children == 0;
        const uint32_t unit = instance.first_unit + (visit.node >> 10);
        draw(square, make_key(square.depth, unit, visit.node & 1023), out);
      }
    }
    std::swap(scratch.queue, scratch.next);
  }
}

}  // namespace

ThesisOctree make_thesis_octree(const VoxelGrid& grid, std::span<const ThesisVoxel> voxels,
                                uint32_t joints) {
  SINEW_CHECK(!voxels.empty());
  std::vector<Level> levels;
  levels.push_back(leaves_of(voxels));
  const uint32_t side = std::max({grid.resolution.x, grid.resolution.y, grid.resolution.z, 1u});
  while (1u << (levels.size() - 1) < side) levels.push_back(level_above(levels.back()));
  ThesisOctree out{.grid = grid, .joints = joints, .nodes = {}, .places = {}};
  out.leaves = static_cast<uint32_t>(voxels.size());
  for (size_t l = levels.size(); l-- > 0;) {
    const auto next = static_cast<uint32_t>(out.nodes.size() + levels[l].nodes.size());
    out.places.insert(out.places.end(), levels[l].places.begin(), levels[l].places.end());
    for (ThesisNode node : levels[l].nodes) {
      if (node.children != 0) node.first_child += next;
      out.nodes.push_back(node);
    }
  }
  return out;
}

float stretch_factor(const ThesisNode& node) {
  const auto positive = std::ranges::count_if(node.skin.weights, [](float w) { return w > 0.0f; });
  return positive == 0 ? 1.0f : std::min(2.0f, static_cast<float>(positive));
}

ThesisPlacing::ThesisPlacing(const ThesisInstance& instance, const RasterView& view,
                             const ThesisSettings& settings)
    : octree_(*instance.octree),
      joints_(octree_.joints == 0 ? std::span<const Affine>() : instance.joints),
      placement_(instance.placement),
      view_(view),
      enlarge_(settings.enlarge),
      pixels_(octree_.grid.voxel * scale_of(instance.placement) * pixels_per_unit(view)) {}

ThesisSquare ThesisPlacing::operator()(const ThesisVisit& visit) const {
  const ThesisNode& node = octree_.nodes[visit.node];
  const vec3 rest = center_of(octree_.grid, visit, node.level);
  const vec4 p(transform_point(placement_, thesis_point(node.skin, joints_, rest)), 1.0f);
  ThesisSquare out;
  const float w = dot(view_.w, p);
  out.depth = dot(view_.depth, p);
  out.x = dot(view_.x, p) / w;
  out.y = dot(view_.y, p) / w;
  const float side = static_cast<float>(1u << node.level);
  out.size = side * (enlarge_ ? stretch_factor(node) : 1.0f) * pixels_ / w;
  out.visible = out.depth > view_.near && std::isfinite(out.depth + out.x + out.y + out.size);
  return out;
}

ThesisStats rasterize_thesis(std::span<const ThesisInstance> instances, const RasterView& view,
                             const ThesisSettings& settings, ThesisScratch& scratch,
                             Visibility& out) {
  out.width = view.width;
  out.height = view.height;
  out.keys.assign(size_t{view.width} * view.height, kNothing);
  ThesisStats stats;
  for (const ThesisInstance& instance : instances) {
    SINEW_CHECK(instance.first_unit + unit_count(*instance.octree) <= kMostUnits);
    SINEW_CHECK(instance.octree->joints == 0 || instance.joints.size() >= instance.octree->joints);
    rasterize_one(instance, view, settings, scratch, stats, out);
  }
  return stats;
}

VoxelSample sample_thesis(std::span<const ThesisInstance> instances, VisibilityKey key) {
  const uint32_t unit = key_unit(key);
  const auto after = std::ranges::upper_bound(instances, unit, {}, &ThesisInstance::first_unit);
  SINEW_DCHECK(after != instances.begin());
  const ThesisInstance& instance = *(after - 1);
  VoxelSample out;
  out.instance = static_cast<uint32_t>(&instance - instances.data());
  out.unit = unit - instance.first_unit;
  out.code = key_code(key);
  const ThesisOctree& octree = *instance.octree;
  const size_t index = size_t{out.unit} << 10 | out.code;
  const ThesisNode& node = octree.nodes[index];
  const uvec3 place = voxel_of(octree.places[index] << 3 * node.level);
  const vec3 rest = octree.grid.origin +
                    octree.grid.voxel * (vec3(place) + 0.5f * static_cast<float>(1u << node.level));
  const std::span<const Affine> joints =
      octree.joints == 0 ? std::span<const Affine>() : instance.joints;
  out.position = transform_point(instance.placement, thesis_point(node.skin, joints, rest));
  out.level = node.level;
  out.material = node.material;
  out.size =
      octree.grid.voxel * static_cast<float>(1u << node.level) * scale_of(instance.placement);
  out.normal = normalize(cofactor(instance.placement) * node.normal);
  out.color = unpack_color(node.color);
  return out;
}

}  // namespace sinew
