// What all movie formats share: checks of options and frames.
#include "sinew/io/movie.h"

#include "sinew/base/check.h"
#include "sinew/io/movie_encoder.h"
#include "sinew/io/output_file.h"

namespace sinew {

struct MovieWriter::State {
  std::string path;
  uint32_t width = 0;
  uint32_t height = 0;
  uint64_t frames = 0;
  bool finished = false;
  std::unique_ptr<MovieEncoder> encoder;
};

MovieWriter::MovieWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
MovieWriter::MovieWriter(MovieWriter&&) noexcept = default;
MovieWriter& MovieWriter::operator=(MovieWriter&&) noexcept = default;
MovieWriter::~MovieWriter() = default;

Result<MovieWriter> MovieWriter::create(const std::string& path, uint32_t width, uint32_t height,
                                        const MovieOptions& options) {
  if (!(options.fps >= 0.001 && options.fps <= 1000.0)) {
    return movie_error(ErrorKind::usage, path, "the frame rate is out of range",
                       "choose 0.001 to 1000 frames a second");
  }
  if (!(options.quality >= 0.0f && options.quality <= 100.0f)) {
    return movie_error(ErrorKind::usage, path, "the quality is out of range", "choose 0 to 100");
  }
  SINEW_CHECKED(check_writable(path));
  auto state = std::make_unique<State>();
  state->path = path;
  state->width = width;
  state->height = height;
  const auto make = options.format == MovieFormat::mp4 ? make_mp4_encoder : make_webp_encoder;
  SINEW_TRY(state->encoder, make(path, width, height, options));
  return MovieWriter(std::move(state));
}

Result<void> MovieWriter::add(const Image8& frame) {
  SINEW_CHECK(state_ && !state_->finished);
  SINEW_CHECK(frame.pixels.size() == size_t{4} * frame.width * frame.height);
  State& movie = *state_;
  if (frame.width != movie.width || frame.height != movie.height) {
    return movie_error(ErrorKind::runtime, movie.path,
                       "frame " + std::to_string(movie.frames) + " has another size",
                       "give all frames the size of the movie");
  }
  SINEW_CHECKED(movie.encoder->add(frame, movie.frames));
  ++movie.frames;
  return {};
}

Result<void> MovieWriter::finish() {
  SINEW_CHECK(state_ && !state_->finished);
  State& movie = *state_;
  if (movie.frames == 0) {
    return movie_error(ErrorKind::usage, movie.path, "a movie needs at least one frame", "");
  }
  movie.finished = true;
  return movie.encoder->finish(movie.frames);
}

}  // namespace sinew
