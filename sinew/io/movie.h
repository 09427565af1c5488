// Movies: animated WebP, written in-process, and MP4 (H.264), written by the ffmpeg program.
#pragma once

#include <memory>
#include <string>

#include "sinew/base/error.h"
#include "sinew/scene/image.h"

namespace sinew {

enum class MovieFormat : uint8_t { webp, mp4 };

struct MovieOptions {
  MovieFormat format = MovieFormat::webp;
  double fps = 24.0;
  float quality = 85.0f;  // 0..100
  bool lossless = false;  // WebP only
  bool loop = true;       // WebP only
};

// Add frames in order, all of one size, then finish. Nothing appears under `path` before finish
// succeeds; a writer destroyed before that leaves no trace. "-" is standard output, for WebP only.
// MP4 has no transparency (alpha is ignored), needs even sides, and ffmpeg on the PATH.
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
  struct State;
  explicit MovieWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sinew
