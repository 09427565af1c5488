// The statements of one OBJ file, checked and triangulated, before they become a Mesh.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/math/vec.h"

namespace sinew {

inline constexpr uint32_t kNoIndex = 0xffffffffu;

// What a face says about one of its corners: indices into ObjModel's arrays, from 0.
struct ObjCorner {
  uint32_t position = 0;
  uint32_t texcoord = kNoIndex;
  uint32_t normal = kNoIndex;
};

struct ObjPart {
  uint32_t material = kNoIndex;  // index into ObjModel::materials
  bool flat = false;             // faces without normals after "s off"
};

struct ObjModel {
  std::vector<vec3> positions;
  std::vector<vec3> colors;        // one a position or none: "v x y z r g b"
  std::vector<vec2> texcoords;     // as in the file: v goes up
  std::vector<vec3> normals;       // as in the file: any length
  std::vector<ObjCorner> corners;  // three a triangle
  std::vector<uint32_t> triangle_part;
  std::vector<ObjPart> parts;
  std::vector<std::string> materials;  // names, in order of first use
  std::vector<std::string> libraries;  // as mtllib names them
  std::vector<std::string> warnings;
};

// `path` stands in errors. About at most options.memory_limit bytes are taken.
Result<ObjModel> parse_obj(std::string_view text, const std::string& path,
                           const LoadOptions& options);
Result<ObjModel> read_obj(const std::string& path, const LoadOptions& options);

}  // namespace sinew
