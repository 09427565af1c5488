// Sequences of polygon files: one file a frame.
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew {

// Whether the file name holds a frame number's place: "####" or "%04d".
bool is_sequence(const std::string& pattern);

// One file a frame at 24 frames a second, in order of their numbers; the first is at time 0. Files
// of one topology become one mesh with keys and a linear clip; otherwise each frame is a node that
// shows for its time.
Result<Scene> load_sequence(const std::string& pattern, const LoadOptions& options);

}  // namespace sinew
