// Animated WebP by libwebpmux's encoder, which is fed frame by frame and keeps them compressed in
// memory until the file is written at the end. Time stamps are rounded from the exact frame times,
// so durations differ by a millisecond but never drift. Equal neighbours become one longer frame.
#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <limits>

#include "sinew/io/movie_encoder.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace {

struct EncoderDeleter {
  void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
};

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

class WebpEncoder : public MovieEncoder {
 public:
  WebpEncoder(std::string path, uint32_t width, uint32_t height, const MovieOptions& options)
      : path_(std::move(path)), fps_(options.fps), config_(make_config(options)) {
    WebPAnimEncoderOptions encoder_options;
    WebPAnimEncoderOptionsInit(&encoder_options);
    encoder_options.anim_params.loop_count = options.loop ? 0 : 1;
    encoder_options.kmin = std::numeric_limits<int>::max() - 1;  // key frames: the first only
    encoder_options.kmax = std::numeric_limits<int>::max();
    encoder_.reset(
        WebPAnimEncoderNew(static_cast<int>(width), static_cast<int>(height), &encoder_options));
  }

  bool ready() const { return encoder_ && WebPValidateConfig(&config_); }

  Result<void> add(const Image8& frame, uint64_t index) override {
    if (time_ms(index + 1) > std::numeric_limits<int>::max()) {
      return movie_error(ErrorKind::usage, path_, "the movie is longer than WebP can hold",
                         "write PNG frames");
    }
    WebPPicture picture;
    if (!WebPPictureInit(&picture)) {
      return movie_error(ErrorKind::runtime, path_, "libwebp has another version", "");
    }
    picture.width = static_cast<int>(frame.width);
    picture.height = static_cast<int>(frame.height);
    picture.use_argb = 1;
    const bool added =
        WebPPictureImportRGBA(&picture, frame.pixels.data(), 4 * picture.width) &&
        WebPAnimEncoderAdd(encoder_.get(), &picture, static_cast<int>(time_ms(index)), &config_);
    WebPPictureFree(&picture);
    if (!added) return encoder_error();
    return {};
  }

  Result<void> finish(uint64_t frames) override {
    WebPData data;
    WebPDataInit(&data);
    const int end = static_cast<int>(time_ms(frames));
    if (!WebPAnimEncoderAdd(encoder_.get(), nullptr, end, nullptr) ||
        !WebPAnimEncoderAssemble(encoder_.get(), &data)) {
      return encoder_error();
    }
    Result<void> written = write_file(path_, {data.bytes, data.size});
    WebPDataClear(&data);
    return written;
  }

 private:
  double time_ms(uint64_t frame) const {
    return std::round(static_cast<double>(frame) * 1000.0 / fps_);
  }
  tl::unexpected<Error> encoder_error() const {
    const char* reason = WebPAnimEncoderGetError(encoder_.get());
    return movie_error(ErrorKind::output, path_,
                       std::string("cannot be encoded as WebP: ") + (reason ? reason : "unknown"),
                       "");
  }

  std::string path_;
  double fps_;
  WebPConfig config_;
  std::unique_ptr<WebPAnimEncoder, EncoderDeleter> encoder_;
};

}  // namespace

Result<std::unique_ptr<MovieEncoder>> make_webp_encoder(const std::string& path, uint32_t width,
                                                        uint32_t height,
                                                        const MovieOptions& options) {
  if (width == 0 || height == 0 || width > WEBP_MAX_DIMENSION || height > WEBP_MAX_DIMENSION) {
    return movie_error(ErrorKind::usage, path,
                       "a WebP movie cannot have " + std::to_string(width) + " x " +
                           std::to_string(height) + " pixels",
                       "choose 1 to 16383 pixels a side, or write PNG frames");
  }
  auto encoder = std::make_unique<WebpEncoder>(path, width, height, options);
  if (!encoder->ready()) {
    return movie_error(ErrorKind::runtime, path, "the WebP encoder cannot start",
                       "choose a smaller size");
  }
  return encoder;
}

}  // namespace sinew
