// Finds objects by name, and leaves them out of the picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew::app {

// Which nodes are objects whose node or contents have a name that one of the patterns (`*` and `?`
// as in a shell) fits; one entry a node. A pattern that fits nothing is a usage error that names
// the option and lists the names.
Result<std::vector<uint8_t>> find_objects(const Scene& scene,
                                          const std::vector<std::string>& patterns,
                                          const char* option);

// Hides every object that find_objects() finds for --hide.
Result<void> hide_objects(Scene& scene, const std::vector<std::string>& patterns);

}  // namespace sinew::app
