#include "sinew/io/movie.h"

#include <gtest/gtest.h>
#include <webp/demux.h>

#include <cmath>
#include <cstring>

#include "io/hostile.h"
#include "sinew/io/image_file.h"

namespace sinew {
namespace {

// A bright disc that moves over a gradient: every frame differs.
Image8 make_frame(uint32_t width, uint32_t height, int frame) {
  Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const float dx = static_cast<float>(x) - 8.0f - 3.0f * static_cast<float>(frame);
      const float dy = static_cast<float>(y) - 0.5f * static_cast<float>(height);
      const bool inside = dx * dx + dy * dy < 64.0f;
      uint8_t* pixel = image.at(x, y);
      pixel[0] = inside ? 240 : static_cast<uint8_t>(2 * x);
      pixel[1] = inside ? 230 : static_cast<uint8_t>(2 * y);
      pixel[2] = inside ? 220 : 90;
      pixel[3] = 255;
    }
  }
  return image;
}

struct Decoded {
  uint32_t width = 0, height = 0, loop_count = 0;
  std::vector<int> end_ms;
  std::vector<Image8> frames;
};

Decoded decode(const std::string& path) {
  const std::string file = slurp(path);
  const WebPData data{reinterpret_cast<const uint8_t*>(file.data()), file.size()};
  Decoded result;
  WebPAnimDecoder* decoder = WebPAnimDecoderNew(&data, nullptr);
  if (!decoder) return result;
  WebPAnimInfo info;
  WebPAnimDecoderGetInfo(decoder, &info);
  result.width = info.canvas_width;
  result.height = info.canvas_height;
  result.loop_count = info.loop_count;
  while (WebPAnimDecoderHasMoreFrames(decoder)) {
    uint8_t* pixels = nullptr;
    int end = 0;
    if (!WebPAnimDecoderGetNext(decoder, &pixels, &end)) break;
    result.end_ms.push_back(end);
    result.frames.push_back(
        {info.canvas_width,
         info.canvas_height,
         {pixels, pixels + size_t{4} * info.canvas_width * info.canvas_height}});
  }
  WebPAnimDecoderDelete(decoder);
  return result;
}

TEST(Movie, FramesTimesAndPixelsComeBack) {
  TemporaryFolder folder;
  const std::string path = folder.path("a.webp");
  constexpr int kFrames = 31;
  auto movie = MovieWriter::create(path, 120, 80, {.fps = 24.0});
  ASSERT_TRUE(movie) << movie.error().message();
  for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(movie->add(make_frame(120, 80, i)));
  EXPECT_EQ(folder.file_count(), 0u) << "something appeared before finish";
  ASSERT_TRUE(movie->finish());
  EXPECT_EQ(folder.file_count(), 1u);

  const Decoded decoded = decode(path);
  EXPECT_EQ(decoded.width, 120u);
  EXPECT_EQ(decoded.height, 80u);
  EXPECT_EQ(decoded.loop_count, 0u);
  ASSERT_EQ(decoded.frames.size(), size_t{kFrames});
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(decoded.end_ms[i], static_cast<int>(std::lround((i + 1) * 1000.0 / 24.0)));
    EXPECT_GT(compare_images(decoded.frames[i], make_frame(120, 80, i))->psnr, 28.0) << i;
  }
}

TEST(Movie, LosslessKeepsEveryBit) {
  TemporaryFolder folder;
  const std::string path = folder.path("a.webp");
  auto movie = MovieWriter::create(path, 60, 40, {.fps = 60.0, .lossless = true, .loop = false});
  ASSERT_TRUE(movie);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(movie->add(make_frame(60, 40, i)));
  ASSERT_TRUE(movie->finish());
  const Decoded decoded = decode(path);
  ASSERT_EQ(decoded.frames.size(), 4u);
  EXPECT_EQ(decoded.loop_count, 1u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(decoded.frames[i].pixels, make_frame(60, 40, i).pixels);
}

TEST(Movie, OneFrameAndEqualFramesAreFine) {
  TemporaryFolder folder;
  for (int count : {1, 5}) {
    const std::string path = folder.path("a.webp");
    auto movie = MovieWriter::create(path, 16, 16, {});
    ASSERT_TRUE(movie);
    for (int i = 0; i < count; ++i) ASSERT_TRUE(movie->add(make_frame(16, 16, 0)));
    ASSERT_TRUE(movie->finish());
    EXPECT_GE(decode(path).frames.size(), 1u);
  }
}

TEST(Movie, AnUnfinishedMovieLeavesNoTrace) {
  TemporaryFolder folder;
  {
    auto movie = MovieWriter::create(folder.path("a.webp"), 16, 16, {});
    ASSERT_TRUE(movie);
    ASSERT_TRUE(movie->add(make_frame(16, 16, 0)));
    MovieWriter moved = std::move(*movie);
    ASSERT_TRUE(moved.add(make_frame(16, 16, 1)));
  }
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Movie, ImpossibleRequestsAreErrors) {
  TemporaryFolder folder;
  const std::string path = folder.path("a.webp");
  EXPECT_FALSE(MovieWriter::create(path, 0, 16, {}));
  EXPECT_FALSE(MovieWriter::create(path, 16, 16384, {}));
  EXPECT_FALSE(MovieWriter::create(path, 16, 16, {.fps = 0.0}));
  EXPECT_FALSE(MovieWriter::create(path, 16, 16, {.fps = std::nan("")}));
  EXPECT_FALSE(MovieWriter::create(path, 16, 16, {.quality = 101.0f}));
  const auto unwritable = MovieWriter::create(folder.path("none/a.webp"), 16, 16, {});
  ASSERT_FALSE(unwritable);
  EXPECT_EQ(unwritable.error().kind, ErrorKind::output);

  auto movie = MovieWriter::create(path, 16, 16, {});
  ASSERT_TRUE(movie);
  EXPECT_FALSE(movie->finish()) << "no frames";
  const auto other_size = movie->add(make_frame(17, 16, 0));
  ASSERT_FALSE(other_size);
  EXPECT_NE(other_size.error().message().find("frame 0"), std::string::npos);
  EXPECT_EQ(folder.file_count(), 0u);
}

}  // namespace
}  // namespace sinew
