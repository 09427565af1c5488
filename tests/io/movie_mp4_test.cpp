// MP4 through the ffmpeg program; decoded by it again.
#include <gtest/gtest.h>

#include <cstdlib>

#include "io/hostile.h"
#include "sinew/io/movie.h"

namespace sinew {
namespace {

constexpr uint32_t kWidth = 48, kHeight = 32;

bool has_ffmpeg() {
  return std::system("ffmpeg -version > /dev/null 2>&1") == 0;
}
#define FFMPEG_OR_SKIP() \
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not on the PATH"

// Plain colours that the reduced colour resolution leaves alone.
constexpr uint8_t kColors[3][3] = {{200, 40, 40}, {40, 180, 60}, {70, 70, 210}};

Image8 plain(const uint8_t (&color)[3], uint32_t width = kWidth, uint32_t height = kHeight) {
  Image8 image{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), {color[0], color[1], color[2], 255});
  }
  return image;
}

MovieOptions mp4(double fps = 25.0) {
  MovieOptions options;
  options.format = MovieFormat::mp4;
  options.fps = fps;
  options.quality = 100.0f;
  return options;
}

TEST(Mp4, FramesComeBackInOrderAndColour) {
  FFMPEG_OR_SKIP();
  const TemporaryFolder folder;
  const std::string path = folder.path("it's a movie; $HOME.mp4");  // no shell looks at it
  auto movie = MovieWriter::create(path, kWidth, kHeight, mp4());
  ASSERT_TRUE(movie) << movie.error().message();
  for (const auto& color : kColors) ASSERT_TRUE(movie->add(plain(color)));
  EXPECT_FALSE(std::filesystem::exists(path));
  const auto finished = movie->finish();
  ASSERT_TRUE(finished) << finished.error().message();
  EXPECT_EQ(folder.file_count(), 1u);

  std::filesystem::copy(path, folder.path("in.mp4"));
  const std::string command = "ffmpeg -loglevel error -i " + folder.path("in.mp4") +
                              " -f rawvideo -pix_fmt rgb24 " + folder.path("raw");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string raw = slurp(folder.path("raw"));
  ASSERT_EQ(raw.size(), size_t{3} * 3 * kWidth * kHeight);
  for (size_t frame = 0; frame < 3; ++frame) {
    const size_t middle = 3 * (frame * kWidth * kHeight + (kHeight / 2) * kWidth + kWidth / 2);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(static_cast<uint8_t>(raw[middle + c]), kColors[frame][c], 6)
          << "frame " << frame << ", channel " << c;
    }
  }
}

TEST(Mp4, UnfinishedMoviesLeaveNothing) {
  FFMPEG_OR_SKIP();
  const TemporaryFolder folder;
  {
    auto movie = MovieWriter::create(folder.path("a.mp4"), kWidth, kHeight, mp4());
    ASSERT_TRUE(movie && movie->add(plain(kColors[0])));
    EXPECT_EQ(folder.file_count(), 1u);
  }
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Mp4, WhatItCannotHoldIsAUsageError) {
  const TemporaryFolder folder;
  const auto error_of = [&](uint32_t width, uint32_t height, const MovieOptions& options) {
    const auto movie = MovieWriter::create(folder.path("a.mp4"), width, height, options);
    EXPECT_FALSE(movie.has_value());
    return movie ? ErrorKind::runtime : movie.error().kind;
  };
  EXPECT_EQ(error_of(47, 32, mp4()), ErrorKind::usage);
  EXPECT_EQ(error_of(48, 31, mp4()), ErrorKind::usage);
  EXPECT_EQ(error_of(0, 0, mp4()), ErrorKind::usage);
  EXPECT_EQ(error_of(20000, 2, mp4()), ErrorKind::usage);
  EXPECT_EQ(error_of(48, 32, mp4(0.0)), ErrorKind::usage);
  MovieOptions lossless = mp4();
  lossless.lossless = true;
  EXPECT_EQ(error_of(48, 32, lossless), ErrorKind::usage);
  EXPECT_EQ(folder.file_count(), 0u);
}

// While it lives the PATH is another one.
class Path {
 public:
  explicit Path(const std::string& path) { ::setenv("PATH", path.c_str(), 1); }
  ~Path() { ::setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_ = std::getenv("PATH");
};

TEST(Mp4, WithoutFfmpegTheErrorSaysWhatToDo) {
  const TemporaryFolder folder;
  const Path nowhere(folder.path("empty"));
  const auto movie = MovieWriter::create(folder.path("a.mp4"), kWidth, kHeight, mp4());
  ASSERT_FALSE(movie.has_value());
  EXPECT_EQ(movie.error().kind, ErrorKind::runtime);
  EXPECT_NE(movie.error().message().find("ffmpeg"), std::string::npos);
  EXPECT_NE(movie.error().remedy.find("install"), std::string::npos);
  EXPECT_EQ(folder.file_count(), 0u);
}

// A program called ffmpeg that lists an encoder, then runs `body`.
std::string fake_ffmpeg(const TemporaryFolder& folder, const std::string& body) {
  const std::string program = folder.write(
      "bin/ffmpeg",
      "#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V. libx264 x'; exit 0;; esac\n" + body + "\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  return folder.path("bin");
}

TEST(Mp4, WhatFfmpegSaysIsInTheError) {
  const TemporaryFolder folder;
  const Path fake(fake_ffmpeg(folder, "echo 'no such luck' >&2; exit 3") + ":/usr/bin:/bin");
  auto movie = MovieWriter::create(folder.path("a.mp4"), kWidth, kHeight, mp4());
  ASSERT_TRUE(movie) << movie.error().message();
  // It may stop reading at any time: enough frames fill whatever lies between.
  Result<void> result;
  for (int i = 0; i < 2000 && result; ++i) result = movie->add(plain(kColors[0]));
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().kind, ErrorKind::output);
  EXPECT_NE(result.error().problem.find("no such luck"), std::string::npos)
      << result.error().message();
  EXPECT_FALSE(movie->add(plain(kColors[0])).has_value());
  EXPECT_FALSE(movie->finish().has_value());
}

TEST(Mp4, FailureAtTheEndLeavesNothing) {
  const TemporaryFolder folder;
  const Path fake(fake_ffmpeg(folder, "cat > /dev/null; echo 'disk full' >&2; exit 1") +
                  ":/usr/bin:/bin");
  auto movie = MovieWriter::create(folder.path("a.mp4"), kWidth, kHeight, mp4());
  ASSERT_TRUE(movie && movie->add(plain(kColors[0])));
  const auto finished = movie->finish();
  ASSERT_FALSE(finished.has_value());
  EXPECT_NE(finished.error().problem.find("disk full"), std::string::npos);
  *movie = std::move(*MovieWriter::create(folder.path("b.webp"), 2, 2, {}));
  EXPECT_EQ(folder.file_count(), 1u) << "only bin";
}

// A child that never reads must not outlive its movie, nor keep us waiting.
TEST(Mp4, AHangingFfmpegIsKilled) {
  const TemporaryFolder folder;
  const Path fake(fake_ffmpeg(folder, "exec sleep 1000") + ":/usr/bin:/bin");
  {
    auto movie = MovieWriter::create(folder.path("a.mp4"), kWidth, kHeight, mp4());
    ASSERT_TRUE(movie && movie->add(plain(kColors[0])));
  }
  EXPECT_EQ(folder.file_count(), 1u) << "only bin";
}

}  // namespace
}  // namespace sinew
