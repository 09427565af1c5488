#include "app/frame_output.h"

#include <fmt/format.h>

namespace sinew::app {

Result<FrameOutput> FrameOutput::open(const OutputName& name, ImageSize size,
                                      const MovieOptions& movie, const ImageMetadata& about) {
  FrameOutput output;
  output.name_ = name;
  output.about_ = about;
  if (name.format == OutputFormat::webp) {
    SINEW_TRY(output.movie_, MovieWriter::create(name.path, size.width, size.height, movie));
  }
  return output;
}

Result<void> FrameOutput::add(const Image8& image, const Shot& shot) {
  if (movie_) return movie_->add(image);
  ImageMetadata metadata = about_;
  metadata.emplace_back("Frame", fmt::format("{}", shot.frame));
  metadata.emplace_back("Time", fmt::format("{:.6g} s", shot.time));
  return write_png(name_.of_frame(shot.frame), image, metadata);
}

Result<void> FrameOutput::finish() {
  return movie_ ? movie_->finish() : Result<void>{};
}

}  // namespace sinew::app
