// Cameras (glTF 2.0 specification, section 3.10) and lights (KHR_lights_punctual).
#pragma once

#include "sinew/io/gltf/json.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// Fill scene.cameras and scene.lights, one a JSON item, in order.
Result<void> read_cameras(const Json& root, Scene& scene);
Result<void> read_lights(const Json& root, Scene& scene);

}  // namespace sinew::gltf
