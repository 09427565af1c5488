// From the contents of a polygon file (OBJ, PLY) to a Mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/io/polygon/model.h"
#include "sinew/scene/mesh.h"

namespace sinew {

// Positions stay as the file lists them, unsplit and with unused ones, so that vertex caches fit.
// Attributes are per vertex where the file gives each vertex one set, else at corners. Texture
// coordinates are turned from the files' v-up to the v-down of glTF and Image8. Part p of the mesh
// is part p of the model with material part_materials[p].
Mesh make_polygon_mesh(const PolygonModel& model, const std::vector<uint32_t>& part_materials,
                       std::vector<std::string>& warnings);

}  // namespace sinew
