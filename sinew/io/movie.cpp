// Animated WebP by libwebpmux's encoder, which is fed frame by frame and keeps them compressed in
// memory until the file is written at the end. Time stamps are rounded from the exact frame times,
// so durations differ by a millisecond but never drift. Equal neighbours become one longer frame.
#include "sinew/io/movie.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace {

struct EncoderDeleter {
  void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
};

tl::unexpected<Error> movie_error(ErrorKind kind, const std::string& path, std::string problem,
                                  std::string remedy) {
  return fail({kind, path, "", std::move(problem), std::move(remedy)});
}

// Method 2 of 0..6 and sub-frames against the last frame only: several frames of 800 x 600 a second
// on one core, some per cent larger than the slow settings.
WebPConfig make_config(const MovieOptions& options) {
  WebPConfig config;
  WebPConfigInit(&config);
  if (options.lossless) {
    WebPConfigLosslessPreset(&config, 2);
  } else {
    config.quality = options.quality;
    config.method = 2;
  }
  return config;
}

}  // namespace

struct MovieWriter::Impl {
  std::string path;
  uint32_t width = 0;
  uint32_t height = 0;
  double fps = 0.0;
  uint64_t frames = 0;
  bool finished = false;
  WebPConfig config{};
  std::unique_ptr<WebPAnimEncoder, EncoderDeleter> encoder;

  double time_ms(uint64_t frame) const {
    return std::round(static_cast<double>(frame) * 1000.0 / fps);
  }
  tl::unexpected<Error> encoder_error() const {
    const char* reason = WebPAnimEncoderGetError(encoder.get());
    return movie_error(ErrorKind::output, path,
                       std::string("cannot be encoded as WebP: ") + (reason ? reason : "unknown"),
                       "");
  }
};

MovieWriter::MovieWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MovieWriter::MovieWriter(MovieWriter&&) noexcept = default;
MovieWriter& MovieWriter::operator=(MovieWriter&&) noexcept = default;
MovieWriter::~MovieWriter() = default;

Result<MovieWriter> MovieWriter::create(const std::string& path, uint32_t width, uint32_t height,
                                        const MovieOptions& options) {
  if (width == 0 || height == 0 || width > WEBP_MAX_DIMENSION || height > WEBP_MAX_DIMENSION) {
    return movie_error(ErrorKind::usage, path,
                       "a WebP movie cannot have " + std::to_string(width) + " x " +
                           std::to_string(height) + " pixels",
                       "choose 1 to 16383 pixels a side, or write PNG frames");
  }
  if (!(options.fps >= 0.001 && options.fps <= 1000.0)) {
    return movie_error(ErrorKind::usage, path, "the frame rate is out of range",
                       "choose 0.001 to 1000 frames a second");
  }
  if (!(options.quality >= 0.0f && options.quality <= 100.0f)) {
    return movie_error(ErrorKind::usage, path, "the quality is out of range", "choose 0 to 100");
  }
  SINEW_CHECKED(check_writable(path));

  WebPAnimEncoderOptions encoder_options;
  WebPAnimEncoderOptionsInit(&encoder_options);
  encoder_options.anim_params.loop_count = options.loop ? 0 : 1;
  encoder_options.kmin = std::numeric_limits<int>::max() - 1;  // key frames: the first only
  encoder_options.kmax = std::numeric_limits<int>::max();
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->width = width;
  impl->height = height;
  impl->fps = options.fps;
  impl->config = make_config(options);
  impl->encoder.reset(
      WebPAnimEncoderNew(static_cast<int>(width), static_cast<int>(height), &encoder_options));
  if (!impl->encoder || !WebPValidateConfig(&impl->config)) {
    return movie_error(ErrorKind::runtime, path, "the WebP encoder cannot start",
                       "choose a smaller size");
  }
  return MovieWriter(std::move(impl));
}

Result<void> MovieWriter::add(const Image8& frame) {
  SINEW_CHECK(impl_ && !impl_->finished);
  SINEW_CHECK(frame.pixels.size() == size_t{4} * frame.width * frame.height);
  Impl& movie = *impl_;
  if (frame.width != movie.width || frame.height != movie.height) {
    return movie_error(ErrorKind::runtime, movie.path,
                       "frame " + std::to_string(movie.frames) + " has another size",
                       "give all frames the size of the movie");
  }
  if (movie.time_ms(movie.frames + 1) > std::numeric_limits<int>::max()) {
    return movie_error(ErrorKind::usage, movie.path, "the movie is longer than WebP can hold",
                       "write PNG frames");
  }
  WebPPicture picture;
  if (!WebPPictureInit(&picture)) {
    return movie_error(ErrorKind::runtime, movie.path, "libwebp has another version", "");
  }
  picture.width = static_cast<int>(frame.width);
  picture.height = static_cast<int>(frame.height);
  picture.use_argb = 1;
  const bool added =
      WebPPictureImportRGBA(&picture, frame.pixels.data(), 4 * picture.width) &&
      WebPAnimEncoderAdd(movie.encoder.get(), &picture,
                         static_cast<int>(movie.time_ms(movie.frames)), &movie.config);
  WebPPictureFree(&picture);
  if (!added) return movie.encoder_error();
  ++movie.frames;
  return {};
}

Result<void> MovieWriter::finish() {
  SINEW_CHECK(impl_ && !impl_->finished);
  Impl& movie = *impl_;
  if (movie.frames == 0) {
    return movie_error(ErrorKind::usage, movie.path, "a movie needs at least one frame", "");
  }
  movie.finished = true;
  WebPData data;
  WebPDataInit(&data);
  const int end = static_cast<int>(movie.time_ms(movie.frames));
  if (!WebPAnimEncoderAdd(movie.encoder.get(), nullptr, end, nullptr) ||
      !WebPAnimEncoderAssemble(movie.encoder.get(), &data)) {
    return movie.encoder_error();
  }
  Result<void> written = write_file(movie.path, {data.bytes, data.size});
  WebPDataClear(&data);
  return written;
}

}  // namespace sinew
