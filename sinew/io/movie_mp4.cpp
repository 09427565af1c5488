// MP4 through the ffmpeg program: raw frames go to its standard input, H.264 (or MPEG-4 part 2,
// where ffmpeg was built without x264) comes out in a temporary file beside the target.
#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/io/child_process.h"
#include "sinew/io/movie_encoder.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace {

constexpr uint32_t kMaxSide = 16384;  // pixels, by H.264

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

// The error of a ChildProcess for a movie.
tl::unexpected<Error> no_ffmpeg(const std::string& path, const Error& error) {
  return movie_error(ErrorKind::runtime, path, error.problem,
                     "install ffmpeg, or write a .webp or .png frames");
}

// What ffmpeg said last, on one line.
std::string complaint(const ChildProcess& ffmpeg) {
  std::string text = ffmpeg.output();
  while (!text.empty() && text.back() == '\n') text.pop_back();
  if (text.empty()) return "ffmpeg gave up without a word";
  constexpr size_t kMost = 400;
  if (text.size() > kMost) text = "... " + text.substr(text.size() - kMost);
  std::replace(text.begin(), text.end(), '\n', ';');
  return "ffmpeg says: " + text;
}

// Options of the encoder that this ffmpeg has. Quality 0..100 is x264's constant rate factor
// 40..14 (85: 18, where few see a loss), or MPEG-4's quantiser 31..2.
Result<std::vector<std::string>> encoder_words(const std::string& path, float quality) {
  auto ffmpeg = ChildProcess::start({"ffmpeg", "-hide_banner", "-loglevel", "error", "-encoders"});
  if (!ffmpeg) return no_ffmpeg(path, ffmpeg.error());
  if (ffmpeg->wait() != 0) {
    return movie_error(ErrorKind::runtime, path, complaint(*ffmpeg), "reinstall ffmpeg");
  }
  const std::string known = ffmpeg->output();
  if (known.find(" libx264 ") != known.npos) {
    return std::vector<std::string>{"-c:v", "libx264", "-crf",
                                    number(std::round(40.0 - 0.26 * double{quality}))};
  }
  if (known.find(" mpeg4 ") != known.npos) {
    return std::vector<std::string>{"-c:v", "mpeg4", "-q:v",
                                    number(std::round(31.0 - 0.29 * double{quality}))};
  }
  return movie_error(ErrorKind::runtime, path, "ffmpeg has no encoder for .mp4",
                     "install an ffmpeg with libx264, or write a .webp");
}

class Mp4Encoder : public MovieEncoder {
 public:
  Mp4Encoder(std::string path, OutputFile file, ChildProcess ffmpeg)
      : path_(std::move(path)), file_(std::move(file)), ffmpeg_(std::move(ffmpeg)) {}

  Result<void> add(const Image8& frame, uint64_t) override {
    const size_t pixels = frame.pixels.size() / 4;
    rgb_.resize(3 * pixels);
    for (size_t i = 0; i < pixels; ++i) std::copy_n(&frame.pixels[4 * i], 3, &rgb_[3 * i]);
    if (ffmpeg_.write(rgb_)) return {};
    ffmpeg_.wait();
    return failure();
  }

  Result<void> finish(uint64_t) override {
    if (ffmpeg_.wait() != 0) return failure();
    return file_.publish();
  }

 private:
  tl::unexpected<Error> failure() const {
    return movie_error(ErrorKind::output, path_, "cannot be encoded: " + complaint(ffmpeg_),
                       "write a .webp or .png frames");
  }

  std::string path_;
  OutputFile file_;
  ChildProcess ffmpeg_;  // destroyed first: killed before its file goes
  std::vector<uint8_t> rgb_;
};

}  // namespace

Result<std::unique_ptr<MovieEncoder>> make_mp4_encoder(const std::string& path, uint32_t width,
                                                       uint32_t height,
                                                       const MovieOptions& options) {
  if (width == 0 || height == 0 || width % 2 != 0 || height % 2 != 0 || width > kMaxSide ||
      height > kMaxSide) {
    return movie_error(
        ErrorKind::usage, path,
        "an .mp4 cannot have " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
        "choose even sides, at most 16384");
  }
  if (options.lossless) {
    return movie_error(ErrorKind::usage, path, "an .mp4 cannot be lossless", "write a .webp");
  }
  SINEW_TRY(const std::vector<std::string> encoder, encoder_words(path, options.quality));
  SINEW_TRY(OutputFile file, OutputFile::create(path));
  if (file.temporary().empty()) {
    return movie_error(ErrorKind::output, path, "is no regular file", "give the name of a file");
  }
  SINEW_CHECKED(file.close());  // ffmpeg opens it by its name

  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  std::vector<std::string> words = {
      "ffmpeg", "-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format",
      "rgb24", "-video_size", size, "-framerate", number(options.fps), "-i", "pipe:0", "-an",
      // The matrix that players expect of a movie of this size, stated in the file as well.
      "-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p", "-colorspace",
      "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"};
  words.insert(words.end(), encoder.begin(), encoder.end());
  for (const std::string& word :
       {std::string("-threads"), std::to_string(thread_count()), std::string("-movflags"),
        std::string("+faststart"), std::string("-f"), std::string("mp4"),
        "file:" + file.temporary()}) {
    words.push_back(word);
  }
  auto ffmpeg = ChildProcess::start(words);
  if (!ffmpeg) return no_ffmpeg(path, ffmpeg.error());
  return std::make_unique<Mp4Encoder>(path, std::move(file), std::move(*ffmpeg));
}

}  // namespace sinew
