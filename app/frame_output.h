// Where finished frames go: one PNG or EXR each, or one movie. Single pictures carry what they
// show.
#pragma once

#include <optional>
#include <string>

#include "app/output_name.h"
#include "sinew/base/error.h"
#include "sinew/io/image_file.h"
#include "sinew/io/movie.h"
#include "sinew/render/camera.h"
#include "sinew/render/layers.h"

namespace sinew::app {

struct Shot {
  int frame = 1;
  double time = 0.0;  // seconds, in the clip
};

// A frame that is ready to be written.
struct FinishedFrame {
  Shot shot;
  const CameraView& camera;
  const Image8& picture;      // what PNG and movies show
  const Image& radiance;      // and what EXR holds
  const FrameLayers& layers;  // EXR
  ImageMetadata about;        // more than all frames have in common
};

class FrameOutput {
 public:
  // `about` goes into every single picture. `layers` are those of an EXR.
  static Result<FrameOutput> open(const OutputName& name, ImageSize size, const MovieOptions& movie,
                                  const LayerChoice& layers, const ImageMetadata& about);

  Result<void> add(const FinishedFrame& frame);
  Result<void> finish();
  void abandon() { movie_.reset(); }  // leaves no unfinished movie

 private:
  OutputName name_;
  LayerChoice layers_;
  ImageMetadata about_;
  std::optional<MovieWriter> movie_;
};

}  // namespace sinew::app
