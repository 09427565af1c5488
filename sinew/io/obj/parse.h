// Wavefront OBJ: the statements of one file, checked and triangulated. Without normals in the file
// the model has none, and is smooth unless the file says "s off".
#pragma once

#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/polygon/model.h"

namespace sinew {

// `path` stands in errors. About at most options.memory_limit bytes are taken.
Result<PolygonModel> parse_obj(std::string_view text, const std::string& path,
                               const LoadOptions& options);

}  // namespace sinew
