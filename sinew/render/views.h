// Views: pictures of what rays met and cost rather than of light. They are made from layers.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/render/layers.h"
#include "sinew/scene/image.h"

namespace sinew {

struct StepSummary {
  uint32_t largest = 0;
  uint32_t high = 0;  // all but one in 200 pixels have no more
  double mean = 0.0;
};
StepSummary summarize_steps(std::span<const uint32_t> steps);

// The least of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten from 10 up that is not below
// `steps`: a scale that seldom changes from frame to frame.
uint32_t round_scale(uint32_t steps);

// Steps of the traversal by heat_color: black is none, pale yellow `scale` or more.
void draw_heatmap(const FrameLayers& layers, uint32_t scale, Image8& out);

// World normals: x, y, z from -1 to 1 as red, green, blue from 0 to 255; black where nothing is.
void draw_normals(const FrameLayers& layers, Image8& out);

// Depth in greys, linear from the nearest (white) to the farthest (dark) pixel; black where nothing
// is.
void draw_depth(const FrameLayers& layers, Image8& out);

// A colour an object, lighter where its surface faces the eye; black where nothing is. Needs the
// layers object and normal.
void draw_objects(const FrameLayers& layers, const CameraView& camera, Image8& out);

}  // namespace sinew
