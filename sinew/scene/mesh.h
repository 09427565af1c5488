// A body's shape: constant data from which its Motion makes positions.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/motion/motion.h"

namespace sinew {

// Triangles that share a material.
struct MeshPart {
  uint32_t material = 0;  // index into Scene::materials
  bool flat = false;      // shade with the triangle's own normal, not with vertex normals
};

struct Mesh {
  std::string name;

  std::vector<vec3> positions;          // at rest; one a vertex
  std::vector<uvec3> triangles;         // vertex indices, counter-clockwise from outside
  std::vector<uint32_t> triangle_part;  // one a triangle: index into parts
  std::vector<MeshPart> parts;

  // Attributes at triangle corners. They are indexed by `triangles`, or by `corners` (one uvec3 a
  // triangle) where attributes have seams that positions have not (OBJ). All optional.
  std::vector<uvec3> corners;
  std::vector<vec3> normals;   // at rest, unit length; empty: computed from positions
  std::vector<vec4> tangents;  // xyz at rest, w = +1 or -1 (bitangent = w * cross(n, t))
  std::vector<vec2> texcoords[2];
  std::vector<vec4> colors;  // linear RGBA, multiplies the base colour

  // Skin (see SkinMotion).
  uint32_t influences = 0;
  std::vector<uint16_t> joints;
  std::vector<float> weights;

  // Morph targets (see MorphMotion): target-major deltas. Normal deltas are indexed like normals.
  uint32_t morph_targets = 0;
  std::vector<vec3> morph_positions;
  std::vector<vec3> morph_normals;   // empty if the file has none
  std::vector<float> morph_weights;  // default weight of each target
  std::vector<std::string> morph_names;

  // Vertex cache (see KeyframeMotion): key-major positions. Vertex normals are computed.
  uint32_t keys = 0;
  std::vector<vec3> key_positions;

  // Free motion: writes the vertices of time t (seconds) to a span of positions.size() entries.
  // Vertex normals are computed.
  std::function<void(double time, std::span<vec3> out)> vertex_program;

  // Whether a skin moves the vertices.
  bool skinnable() const { return influences > 0 && keys == 0 && !vertex_program; }

  uint32_t material_of(uint32_t triangle) const { return parts[triangle_part[triangle]].material; }
  uvec3 corner_of(uint32_t triangle) const {
    return corners.empty() ? triangles[triangle] : corners[triangle];
  }
};

// The motion of a mesh as its data say: free if it has a vertex program, keyframes if it has keys,
// else morph, skin or rigid. Views into the mesh, which must outlive it.
Motion motion_of(const Mesh& mesh, bool skinned);

// Every invariant above: sizes, index ranges, finite values. Empty text if all hold, else what is
// wrong and where.
std::string validate(const Mesh& mesh);

}  // namespace sinew
