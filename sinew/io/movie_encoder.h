// What a movie format has to do. Internal to sinew/io.
#pragma once

#include <memory>
#include <string>

#include "sinew/base/error.h"
#include "sinew/io/movie.h"

namespace sinew {

class MovieEncoder {
 public:
  virtual ~MovieEncoder() = default;  // leaves no trace of an unfinished movie
  // The frame has the movie's size; `index` counts from 0.
  virtual Result<void> add(const Image8& frame, uint64_t index) = 0;
  virtual Result<void> finish(uint64_t frames) = 0;
};

Result<std::unique_ptr<MovieEncoder>> make_webp_encoder(const std::string& path, uint32_t width,
                                                        uint32_t height,
                                                        const MovieOptions& options);
Result<std::unique_ptr<MovieEncoder>> make_mp4_encoder(const std::string& path, uint32_t width,
                                                       uint32_t height,
                                                       const MovieOptions& options);

inline tl::unexpected<Error> movie_error(ErrorKind kind, const std::string& path,
                                         std::string problem, std::string remedy) {
  return fail({kind, path, "", std::move(problem), std::move(remedy)});
}

}  // namespace sinew
