// The hierarchy's boxes as lines over a picture.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/render/camera.h"
#include "sinew/scene/image.h"
#include "sinew/world/world.h"

namespace sinew {

// Draws the edges of World::boxes(level), coloured by object (the top tree's are white). Parts that
// lie behind `depth` (of a picture's pixels, see FrameLayers) are faint. Returns how many boxes
// there are.
size_t draw_boxes(const World& world, uint32_t level, const CameraView& camera,
                  std::span<const float> depth, Image8& picture);

}  // namespace sinew
