// Wavefront OBJ: polygon meshes with materials. Polygons become triangle fans around their first
// corner (right for convex polygons, accepted for others). Without normals in the file the mesh has
// none, and is smooth unless the file says "s off".
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew {

// One mesh on one node.
Result<Scene> load_obj(const std::string& path, const LoadOptions& options);

// Whether the file name holds a frame number's place: "####" or "%04d".
bool is_sequence(const std::string& pattern);

// One file a frame at 24 frames a second, in order of their numbers; the first is at time 0. Files
// of one topology become one mesh with keys and a linear clip; otherwise each frame is a node that
// shows for its time.
Result<Scene> load_obj_sequence(const std::string& pattern, const LoadOptions& options);

}  // namespace sinew
