// Leaves objects out of the picture by name.
#pragma once

#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew::app {

// Hides every object whose node, mesh or octree has a name that a pattern (`*` and `?` as in a
// shell) fits. A pattern that fits nothing is a usage error that lists the names.
Result<void> hide_objects(Scene& scene, const std::vector<std::string>& patterns);

}  // namespace sinew::app
