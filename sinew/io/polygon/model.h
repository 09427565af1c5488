// A polygon file's contents, checked and triangulated, before they become a Mesh: what the readers
// of OBJ and PLY have in common.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

inline constexpr uint32_t kNoIndex = 0xffffffffu;

// What a face says about one of its corners: indices into PolygonModel's arrays, from 0.
struct PolygonCorner {
  uint32_t position = 0;
  uint32_t texcoord = kNoIndex;
  uint32_t normal = kNoIndex;
};

struct PolygonPart {
  uint32_t material = kNoIndex;  // index into PolygonModel::materials
  bool flat = false;             // faces that are to be shaded with their own normals
};

struct PolygonModel {
  std::vector<vec3> positions;
  std::vector<vec3> colors;            // sRGB, 0..1; one a position or none
  std::vector<vec2> texcoords;         // as in the file: v goes up
  std::vector<vec3> normals;           // as in the file: any length
  std::vector<PolygonCorner> corners;  // three a triangle
  std::vector<uint32_t> triangle_part;
  std::vector<PolygonPart> parts;
  std::vector<std::string> materials;  // names, in order of first use
  std::vector<std::string> libraries;  // files that define materials
  std::string texture;                 // an image for parts without a material; may be empty
  std::vector<std::string> warnings;

  // What the large arrays take.
  uint64_t bytes() const {
    return sizeof(vec3) * (positions.capacity() + colors.capacity() + normals.capacity()) +
           sizeof(vec2) * texcoords.capacity() + sizeof(PolygonCorner) * corners.capacity() +
           sizeof(uint32_t) * triangle_part.capacity();
  }
};

// The most entries that an array may have, so that sums of indices never overflow.
inline constexpr size_t kMostPolygonEntries = 0x7fffffff;

// Adds the triangles of the polygon `face` as a fan around its first corner, which is right for
// convex ones.
inline void add_fan(const std::vector<PolygonCorner>& face, uint32_t part, PolygonModel& model) {
  for (size_t i = 2; i < face.size(); ++i) {
    model.corners.insert(model.corners.end(), {face[0], face[i - 1], face[i]});
    model.triangle_part.push_back(part);
  }
}

}  // namespace sinew
