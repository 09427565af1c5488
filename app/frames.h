// Frames: which ones to draw, and what time each of them shows. Frames count from 1; frame n shows
// the time start + (n - 1) / fps of its clip.
#pragma once

#include <string_view>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew::app {

// "7", "1-100", "1,3,5-9", "1-100x2" (every second one). The frames come back in ascending order,
// each once. Everything else is a usage error that shows the right spelling.
Result<std::vector<int>> parse_frames(std::string_view text);

struct Timeline {
  double start = 0.0;  // seconds
  double end = 0.0;    // seconds
  double fps = 24.0;
  int frames = 1;  // how many frames the clip has at this rate
};

// `fps` > 0 overrides the scene's own rate; `clip` is an index or kRestPose.
Timeline timeline_of(const Scene& scene, int clip, double fps = 0.0);

double frame_time(const Timeline& timeline, int frame);

}  // namespace sinew::app
