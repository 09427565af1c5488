#include "app/frame_output.h"

#include <fmt/format.h>

#include "sinew/render/frame_exr.h"

namespace sinew::app {
namespace {

// The lens, and the matrix from camera to world space, row by row.
void add_camera(const CameraView& camera, ImageMetadata& metadata) {
  constexpr double kDegrees = 57.29577951308232;
  metadata.emplace_back("Camera",
                        camera.orthographic
                            ? fmt::format("orthographic, height {:.6g}", 2.0 * camera.ymag)
                            : fmt::format("perspective, vertical field of view {:.6g} degrees",
                                          camera.yfov * kDegrees));
  std::string rows;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      rows += fmt::format("{:.9g} ", camera.to_world[column][row]);
    }
  }
  metadata.emplace_back("CameraToWorld", rows + "0 0 0 1");
}

}  // namespace

Result<FrameOutput> FrameOutput::open(const OutputName& name, ImageSize size,
                                      const MovieOptions& movie, const LayerChoice& layers,
                                      const ImageMetadata& about) {
  FrameOutput output;
  output.name_ = name;
  output.layers_ = layers;
  output.about_ = about;
  if (is_movie(name.format)) {
    MovieOptions options = movie;
    options.format = name.format == OutputFormat::mp4 ? MovieFormat::mp4 : MovieFormat::webp;
    SINEW_TRY(output.movie_, MovieWriter::create(name.path, size.width, size.height, options));
  }
  return output;
}

Result<void> FrameOutput::add(const FinishedFrame& frame) {
  if (movie_) return movie_->add(frame.picture);
  ImageMetadata metadata = about_;
  metadata.emplace_back("Frame", fmt::format("{}", frame.shot.frame));
  metadata.emplace_back("Time", fmt::format("{:.6g} s", frame.shot.time));
  add_camera(frame.camera, metadata);
  metadata.insert(metadata.end(), frame.about.begin(), frame.about.end());
  const std::string path = name_.of_frame(frame.shot.frame);
  if (name_.format == OutputFormat::exr) {
    return write_frame_exr(path, frame.radiance, frame.layers, layers_, frame.camera, metadata);
  }
  return write_png(path, frame.picture, metadata);
}

Result<void> FrameOutput::finish() {
  return movie_ ? movie_->finish() : Result<void>{};
}

}  // namespace sinew::app
