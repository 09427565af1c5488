// Where finished frames go: one PNG each, or one animated WebP. A PNG carries what it shows.
#pragma once

#include <optional>
#include <string>

#include "app/output_name.h"
#include "sinew/base/error.h"
#include "sinew/io/image_file.h"
#include "sinew/io/movie.h"

namespace sinew::app {

struct Shot {
  int frame = 1;
  double time = 0.0;  // seconds, in the clip
};

class FrameOutput {
 public:
  // `about` goes into every PNG.
  static Result<FrameOutput> open(const OutputName& name, ImageSize size, const MovieOptions& movie,
                                  const ImageMetadata& about);

  Result<void> add(const Image8& image, const Shot& shot);
  Result<void> finish();
  void abandon() { movie_.reset(); }  // leaves no unfinished movie

 private:
  OutputName name_;
  ImageMetadata about_;
  std::optional<MovieWriter> movie_;
};

}  // namespace sinew::app
