// What `sinew render` is asked to do, once its options are read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/camera_choice.h"
#include "app/draw_mode.h"
#include "app/output_name.h"
#include "app/progress.h"
#include "app/values.h"
#include "app/view_choice.h"
#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/movie.h"
#include "sinew/render/frame.h"

namespace sinew::app {

struct RenderJob {
  std::string input;
  LoadOptions load;
  std::string clip;               // as prepare() takes it
  std::vector<int> frames;        // empty: all of the clip
  std::optional<double> time;     // a single picture of this time instead of frames
  double fps = 0.0;               // 0: the scene's own
  std::vector<std::string> hide;  // patterns of object names
  DrawModeChoice mode;
  CameraChoice camera;
  RenderSettings settings;
  bool progressive = false;       // refine frames in which nothing moves
  std::optional<Rgb> background;  // lies behind everything in the finished picture
  int threads = 0;                // 0: all
  UpdateMode update = UpdateMode::automatic;
  std::string tree;  // a file of `sinew optimize`; empty: none
  bool one_tree = false;
  ViewChoice view;
  LayerChoice layers;  // of .exr
  OutputName output;
  MovieOptions movie;
  bool skip_existing = false;  // sequences: leave the frames that are there
  std::string contact_sheet;   // empty: none
  std::string json;            // empty: none
  ProgressMode progress = ProgressMode::automatic;
};

Result<int> render(const RenderJob& job);

}  // namespace sinew::app
