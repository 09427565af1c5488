// The statistics of a render as JSON: a header, and one entry a frame.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/frame_output.h"
#include "app/frames.h"
#include "app/view_choice.h"
#include "sinew/render/frame.h"
#include "sinew/svo/file/stream.h"

namespace sinew::app {

struct FrameRecord {
  Shot shot;
  UpdateStats update;
  double total_ms = 0.0;  // from the new time to the finished 8-bit picture
  FrameStats stats;
  ViewRecord view;
};

struct RenderReport {
  std::string input;
  std::string output;
  std::string clip;
  double fps = 0.0;
  int threads = 0;
  uint64_t triangles = 0;
  uint64_t voxels = 0;                // of all voxel objects
  std::optional<PagingStats> paging;  // if detail of octrees comes and goes
  RenderSettings settings;
  std::vector<std::string> warnings;
  std::vector<FrameRecord> frames;
};

// MRays/s of all rays over the time spent in ray queries; 0 if there was none.
double mrays_per_s(const FrameStats& stats);

std::string to_json(const RenderReport& report);

}  // namespace sinew::app
