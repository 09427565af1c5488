#include "sinew/io/polygon/mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/math/random.h"
#include "sinew/math/srgb.h"

namespace sinew {
namespace {

// All that a corner looks up, apart from its position.
struct AttributeKey {
  uint32_t texcoord = kNoIndex;
  uint32_t normal = kNoIndex;
  uint32_t color = kNoIndex;
  bool operator==(const AttributeKey&) const = default;
};

// Gives equal keys equal numbers, counted from 0 in order of appearance (open addressing).
class AttributeTable {
 public:
  explicit AttributeTable(size_t most_keys) : slots_(std::bit_ceil(2 * most_keys + 1), kNoIndex) {}

  uint32_t find_or_add(const AttributeKey& key) {
    const size_t mask = slots_.size() - 1;
    size_t slot = hash_combine(hash_combine(key.texcoord, key.normal), key.color) & mask;
    while (slots_[slot] != kNoIndex && keys_[slots_[slot]] != key) slot = (slot + 1) & mask;
    if (slots_[slot] == kNoIndex) {
      slots_[slot] = static_cast<uint32_t>(keys_.size());
      keys_.push_back(key);
    }
    return slots_[slot];
  }
  std::vector<AttributeKey> take_keys() { return std::move(keys_); }

 private:
  std::vector<uint32_t> slots_;
  std::vector<AttributeKey> keys_;
};

vec3 face_normal(const PolygonModel& model, size_t triangle) {
  const auto corner = [&](size_t i) {
    return model.positions[model.corners[3 * triangle + i].position];
  };
  const vec3 normal = cross(corner(1) - corner(0), corner(2) - corner(0));
  const float length_of = length(normal);
  return length_of > 0.0f && std::isfinite(length_of) ? normal / length_of : vec3(0, 0, 1);
}

// The file's normals at unit length, and which normal each corner has. A corner without one, or
// with one of no length, takes its triangle's own, appended to the file's.
struct Normals {
  std::vector<vec3> values;
  std::vector<uint32_t> at_corner;  // empty if the file has none
};

Normals make_normals(const PolygonModel& model, std::vector<std::string>& warnings) {
  Normals result;
  const bool any =
      std::any_of(model.corners.begin(), model.corners.end(),
                  [](const PolygonCorner& corner) { return corner.normal != kNoIndex; });
  if (!any) return result;
  result.values.reserve(model.normals.size());
  std::vector<uint8_t> usable(model.normals.size());
  for (size_t i = 0; i < model.normals.size(); ++i) {
    // Scaled first: the square of a large or small component may not fit a float.
    const vec3 normal = model.normals[i];
    const float largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
    usable[i] = largest > 0.0f;
    result.values.push_back(usable[i] ? normalize(normal / largest) : vec3(0, 0, 1));
  }
  result.at_corner.resize(model.corners.size());
  size_t replaced = 0;
  for (size_t triangle = 0; triangle < model.triangle_part.size(); ++triangle) {
    uint32_t own = kNoIndex;
    for (size_t i = 3 * triangle; i < 3 * triangle + 3; ++i) {
      uint32_t index = model.corners[i].normal;
      if (index == kNoIndex || !usable[index]) {
        if (own == kNoIndex) {
          own = static_cast<uint32_t>(result.values.size());
          result.values.push_back(face_normal(model, triangle));
        }
        index = own;
        ++replaced;
      }
      result.at_corner[i] = index;
    }
  }
  if (replaced > 0) {
    warnings.push_back(std::to_string(replaced) +
                       " corners of triangles have no normal: they took the triangle's own");
  }
  return result;
}

// The key of each corner's attributes, by vertex if each vertex has just one; unused vertices have
// the empty key. Empty if some vertex has two.
std::vector<AttributeKey> keys_by_vertex(const PolygonModel& model,
                                         const std::vector<AttributeKey>& corner_keys) {
  std::vector<AttributeKey> keys(model.positions.size());
  std::vector<uint8_t> known(model.positions.size());
  for (size_t i = 0; i < corner_keys.size(); ++i) {
    const uint32_t vertex = model.corners[i].position;
    if (known[vertex] && keys[vertex] != corner_keys[i]) return {};
    known[vertex] = 1;
    keys[vertex] = corner_keys[i];
  }
  return keys;
}

void fill_attributes(const PolygonModel& model, const Normals& normals, bool has_texcoords,
                     const std::vector<AttributeKey>& keys, Mesh& mesh) {
  for (const AttributeKey& key : keys) {
    if (has_texcoords) {
      const vec2 uv = key.texcoord == kNoIndex ? vec2(0.0f) : model.texcoords[key.texcoord];
      mesh.texcoords[0].emplace_back(uv.x, 1.0f - uv.y);
    }
    if (!normals.at_corner.empty()) {
      mesh.normals.push_back(key.normal == kNoIndex ? vec3(0, 0, 1) : normals.values[key.normal]);
    }
    if (!model.colors.empty()) {
      const vec3 color =
          key.color == kNoIndex ? vec3(1.0f) : clamp(model.colors[key.color], 0.0f, 1.0f);
      mesh.colors.emplace_back(srgb_to_linear(color.x), srgb_to_linear(color.y),
                               srgb_to_linear(color.z), 1.0f);
    }
  }
}

}  // namespace

Mesh make_polygon_mesh(const PolygonModel& model, const std::vector<uint32_t>& part_materials,
                       std::vector<std::string>& warnings) {
  Mesh mesh;
  mesh.positions = model.positions;
  mesh.triangle_part = model.triangle_part;
  for (size_t i = 0; i < model.parts.size(); ++i) {
    mesh.parts.push_back({part_materials[i], model.parts[i].flat});
  }
  const size_t triangles = model.triangle_part.size();
  mesh.triangles.reserve(triangles);
  for (size_t i = 0; i < triangles; ++i) {
    const PolygonCorner* corner = &model.corners[3 * i];
    mesh.triangles.emplace_back(corner[0].position, corner[1].position, corner[2].position);
  }

  const Normals normals = make_normals(model, warnings);
  const bool has_texcoords =
      std::any_of(model.corners.begin(), model.corners.end(),
                  [](const PolygonCorner& corner) { return corner.texcoord != kNoIndex; });
  if (!has_texcoords && normals.at_corner.empty() && model.colors.empty()) return mesh;

  std::vector<AttributeKey> corner_keys(model.corners.size());
  for (size_t i = 0; i < corner_keys.size(); ++i) {
    corner_keys[i].texcoord = model.corners[i].texcoord;
    if (!normals.at_corner.empty()) corner_keys[i].normal = normals.at_corner[i];
    if (!model.colors.empty()) corner_keys[i].color = model.corners[i].position;
  }
  std::vector<AttributeKey> keys = keys_by_vertex(model, corner_keys);
  if (keys.empty()) {
    AttributeTable table(corner_keys.size());
    mesh.corners.resize(triangles);
    for (size_t i = 0; i < corner_keys.size(); ++i) {
      mesh.corners[i / 3][static_cast<int>(i % 3)] = table.find_or_add(corner_keys[i]);
    }
    keys = table.take_keys();
  }
  fill_attributes(model, normals, has_texcoords, keys, mesh);
  return mesh;
}

}  // namespace sinew
