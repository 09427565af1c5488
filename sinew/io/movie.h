// Animated WebP, written in-process.
#pragma once

#include <memory>
#include <string>

#include "sinew/base/error.h"
#include "sinew/scene/image.h"

namespace sinew {

struct MovieOptions {
  double fps = 24.0;
  float quality = 85.0f;  // 0..100
  bool lossless = false;
  bool loop = true;
};

// Add frames in order, all of one size, then finish. Nothing appears under `path` before finish
// succeeds; a writer destroyed before that leaves no trace. "-" is standard output.
class MovieWriter {
 public:
  static Result<MovieWriter> create(const std::string& path, uint32_t width, uint32_t height,
                                    const MovieOptions& options);
  MovieWriter(MovieWriter&&) noexcept;
  MovieWriter& operator=(MovieWriter&&) noexcept;
  ~MovieWriter();

  Result<void> add(const Image8& frame);
  Result<void> finish();

 private:
  struct Impl;
  explicit MovieWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
