// The file that --tree names.
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/world/animation_trees.h"

namespace sinew::app {

// The trees of the file, if they are whole and fit the scene and clip; else an error that names the
// file.
Result<TreeFile> read_trees(const std::string& file, const Scene& scene, int clip);

}  // namespace sinew::app
