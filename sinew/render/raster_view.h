// Views of the rasteriser: through the camera's pixels, and from lights.
#pragma once

#include <span>

#include "sinew/math/box.h"
#include "sinew/render/camera.h"
#include "sinew/render/lights.h"
#include "sinew/svo/draw/visibility.h"

namespace sinew {

// What CameraRays(camera, width, height) sees through the points step * (x + offset.x, y +
// offset.y) of the pixels of an image that is `step` times smaller.
RasterView camera_raster_view(const CameraView& camera, uint32_t width, uint32_t height,
                              uint32_t step = 1, vec2 offset = vec2(0.5f));

// A camera at `eye` with pixels of this size on the plane one unit before it; `frame` has the axes
// of CameraView::to_world.
RasterView perspective_view(const Affine& frame, float pixel, uint32_t width, uint32_t height,
                            float near);

// Along `direction`, just large enough for the boxes; its pixels stand still in the world while
// these move a little, so that the edges of shadows do not crawl. There must be a box.
RasterView directional_view(vec3 direction, std::span<const Box> boxes, uint32_t size);

// All that the light shines to: one view, or six for a cone too wide for that (0 for directional
// ones). Faces overlap by the reach of the filter.
uint32_t light_views(const ShadingLight& light, float near, uint32_t size, RasterView (&out)[6]);

}  // namespace sinew
