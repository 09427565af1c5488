// PLY polygon meshes: ASCII and binary of either byte order, properties of any type in any order.
// Vertices may have normals, colours and texture coordinates; faces are polygons or triangle strips
// and may have texture coordinates at their corners. Other elements and properties are passed over.
#pragma once

#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/polygon/model.h"

namespace sinew {

// `path` stands in errors. About at most options.memory_limit bytes are taken.
Result<PolygonModel> parse_ply(std::string_view bytes, const std::string& path,
                               const LoadOptions& options);

}  // namespace sinew
