// Materials of a glTF file: metallic-roughness (glTF 2.0 specification, section 3.9) with
// KHR_materials_unlit, _emissive_strength, _ior, _specular, _transmission, _volume and
// _pbrSpecularGlossiness. Rays find out themselves how thick a volume is.
#pragma once

#include "sinew/io/gltf/reader.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// Fills scene.materials (one a JSON material, in its order) and scene.images.
Result<void> read_materials(const Reader& reader, Scene& scene);

// What a primitive without a material has.
Material default_material();

}  // namespace sinew::gltf
