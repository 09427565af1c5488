// One frame as an OpenEXR file: the picture and its layers in named channels.
//   R, G, B, A          half    linear radiance (primaries of sRGB), premultiplied; no exposure and
//                               no display transform
//   depth.Z             float   along the camera's axis, metres; infinite: nothing is there
//   normal.X .Y .Z      half    world, unit, towards the eye
//   object.id           uint    1 + index in Scene::objects; 0: nothing is there
//   primitive.id        uint    1 + index of the triangle in its mesh; 0: nothing is there
//   traversal.steps     uint    nodes and packets of triangles that the ray tested
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/io/image_exr.h"
#include "sinew/render/camera.h"
#include "sinew/render/layers.h"
#include "sinew/scene/image.h"

namespace sinew {

// Writes the chosen layers, which must be there. The camera goes into the standard attributes
// worldToCamera and worldToNDC, the texts into attributes of their names.
Result<void> write_frame_exr(const std::string& path, const Image& color, const FrameLayers& layers,
                             const LayerChoice& choice, const CameraView& camera,
                             const ImageMetadata& texts = {});

}  // namespace sinew
