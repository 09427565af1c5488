// One frame of `sinew render`: the world at its time, and the picture of it.
#pragma once

#include "app/render.h"
#include "app/report.h"
#include "sinew/render/layers.h"
#include "sinew/render/refinement.h"

namespace sinew::app {

// What is drawn, and the buffers that live from frame to frame.
struct Stage {
  const RenderJob& job;
  const Scene& scene;
  World& world;
  const FrameCamera& camera;
  RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement{};
  LayerScratch layer_scratch{};
  double finish_ms = 0.0;  // what the last picture took beyond update and radiance
  uint32_t absent = 0;     // most objects left out of a frame

  // Of the last shot.
  CameraView view{};
  Image radiance{};
  FrameLayers layers{};
  Image8 picture{};  // not for .exr files, unless there is a contact sheet
};

// Moves the world to the shot's time and draws what the output is made of.
Result<FrameRecord> draw_shot(Stage& stage, const Shot& shot);

}  // namespace sinew::app
