// Files that hold one polygon mesh, OBJ and PLY, whichever it is. Polygons become triangle fans
// around their first corner (right for convex polygons, accepted for others).
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/polygon/model.h"
#include "sinew/scene/scene.h"

namespace sinew {

// By the extension, ".ply" or else OBJ.
Result<PolygonModel> read_polygons(const std::string& path, const LoadOptions& options);

// One mesh on one node. `path` is the file's that the model was read from: its textures lie beside
// it.
Result<Scene> make_polygon_scene(PolygonModel model, const std::string& path,
                                 const LoadOptions& options);
Result<Scene> load_polygons(const std::string& path, const LoadOptions& options);

}  // namespace sinew
