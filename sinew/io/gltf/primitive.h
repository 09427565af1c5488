// Primitives of a glTF mesh before they are merged: which vertices they use and which triangles
// they make of them (glTF 2.0 specification, section 3.7.2.1).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sinew/io/gltf/draco.h"
#include "sinew/io/gltf/reader.h"
#include "sinew/math/vec.h"

namespace sinew::gltf {

// A set of vertex accessors, used by one or more primitives of a mesh.
struct VertexSource {
  Json primitive;  // the first that uses it
  Json attributes;
  std::vector<Json> targets;         // morph targets
  std::unique_ptr<DracoMesh> draco;  // if compressed: the vertices, and the triangles on them
  uint32_t first = 0;                // its vertices in the mesh: [first, first + count)
  uint32_t count = 0;
};

enum class Topology : uint8_t { list = 4, strip, fan };

struct Primitive {
  Json json;
  Topology topology = Topology::list;
  uint32_t source = 0;               // index into Primitives::sources
  std::optional<uint32_t> material;  // JSON material
};

struct Primitives {
  std::vector<Primitive> items;  // those of triangles
  std::vector<VertexSource> sources;
  uint32_t vertex_count = 0;
};

Result<Primitives> read_primitives(const Reader& reader, const Json& mesh, size_t material_count);

// The triangles of a primitive, as indices of the mesh's vertices.
Result<std::vector<uvec3>> read_triangles(const Reader& reader, const Primitive& primitive,
                                          const VertexSource& source);

}  // namespace sinew::gltf
