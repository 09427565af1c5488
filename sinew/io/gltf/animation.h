// Animations of a glTF file as clips (glTF 2.0 specification, section 3.11).
#pragma once

#include <span>

#include "sinew/io/gltf/node.h"
#include "sinew/io/gltf/reader.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// STEP, LINEAR or CUBICSPLINE as the member "interpolation" says; LINEAR if there is none.
Result<Interpolation> interpolation_of(const Json& sampler);

// Fills scene.clips, one a JSON animation. Nodes with a matrix that is animated get translation,
// rotation and scale instead.
Result<void> read_animations(const Reader& reader, std::span<const NodePlace> places, Scene& scene);

}  // namespace sinew::gltf
