#include "sinew/io/image_file.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>

#include "io/hostile.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace sinew {
namespace {

Image8 make_image(uint32_t width, uint32_t height, bool opaque) {
  Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
  Random random(7);
  for (uint8_t& value : image.pixels) value = static_cast<uint8_t>(random.next() >> 24);
  if (opaque) {
    for (size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
  }
  return image;
}

Result<Image8> decode(const std::string& bytes) {
  return decode_image({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "texture");
}
Result<ImageSize> size_of(const std::string& bytes) {
  return image_size({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "texture");
}

std::string big_endian(uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}
std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto crc = static_cast<uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
  return big_endian(static_cast<uint32_t>(data.size())) + body + big_endian(crc);
}
// A PNG with right checksums around whatever header and rows the test wants.
std::string make_png(uint32_t width, uint32_t height, int depth, int color_type,
                     const std::string& rows, const std::string& extra_chunks = "") {
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(size);
  const std::string header = big_endian(width) + big_endian(height) + static_cast<char>(depth) +
                             static_cast<char>(color_type) + std::string(3, '\0');
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + extra_chunks + chunk("IDAT", packed) +
         chunk("IEND", "");
}

std::string make_jpeg(int width, int height) {
  std::vector<uint8_t> rgb(size_t{3} * width * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      uint8_t* pixel = &rgb[3 * (size_t{static_cast<size_t>(y)} * width + x)];
      pixel[0] = static_cast<uint8_t>(4 * x);
      pixel[1] = static_cast<uint8_t>(4 * y);
      pixel[2] = 128;
    }
  }
  std::string bytes;
  stbi_write_jpg_to_func(
      [](void* context, void* data, int size) {
        static_cast<std::string*>(context)->append(static_cast<const char*>(data), size);
      },
      &bytes, width, height, 3, rgb.data(), 90);
  return bytes;
}

// 24 x 16, a gradient from red (top) to blue.
const unsigned char kProgressiveJpeg[] = {
    0xff, 0xd8, 0xff, 0xe0, 0x00, 0x10, 0x4a, 0x46, 0x49, 0x46, 0x00, 0x01, 0x01, 0x00, 0x00, 0x01,
    0x00, 0x01, 0x00, 0x00, 0xff, 0xdb, 0x00, 0x43, 0x00, 0x0d, 0x09, 0x0a, 0x0b, 0x0a, 0x08, 0x0d,
    0x0b, 0x0a, 0x0b, 0x0e, 0x0e, 0x0d, 0x0f, 0x13, 0x20, 0x15, 0x13, 0x12, 0x12, 0x13, 0x27, 0x1c,
    0x1e, 0x17, 0x20, 0x2e, 0x29, 0x31, 0x30, 0x2e, 0x29, 0x2d, 0x2c, 0x33, 0x3a, 0x4a, 0x3e, 0x33,
    0x36, 0x46, 0x37, 0x2c, 0x2d, 0x40, 0x57, 0x41, 0x46, 0x4c, 0x4e, 0x52, 0x53, 0x52, 0x32, 0x3e,
    0x5a, 0x61, 0x5a, 0x50, 0x60, 0x4a, 0x51, 0x52, 0x4f, 0xff, 0xdb, 0x00, 0x43, 0x01, 0x0e, 0x0e,
    0x0e, 0x13, 0x11, 0x13, 0x26, 0x15, 0x15, 0x26, 0x4f, 0x35, 0x2d, 0x35, 0x4f, 0x4f, 0x4f, 0x4f,
    0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f,
    0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f,
    0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0x4f, 0xff, 0xc2,
    0x00, 0x11, 0x08, 0x00, 0x10, 0x00, 0x18, 0x03, 0x01, 0x22, 0x00, 0x02, 0x11, 0x01, 0x03, 0x11,
    0x01, 0xff, 0xc4, 0x00, 0x16, 0x00, 0x01, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x03, 0x05, 0xff, 0xc4, 0x00, 0x15, 0x01, 0x01, 0x01,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04,
    0xff, 0xda, 0x00, 0x0c, 0x03, 0x01, 0x00, 0x02, 0x10, 0x03, 0x10, 0x00, 0x00, 0x01, 0xcb, 0x41,
    0x65, 0xf7, 0x40, 0x7f, 0xff, 0xc4, 0x00, 0x15, 0x10, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x11, 0xff, 0xda, 0x00, 0x08, 0x01,
    0x01, 0x00, 0x01, 0x05, 0x02, 0xaa, 0xaa, 0xaa, 0xff, 0xc4, 0x00, 0x15, 0x11, 0x01, 0x01, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x14, 0xff,
    0xda, 0x00, 0x08, 0x01, 0x03, 0x01, 0x01, 0x3f, 0x01, 0xb5, 0x6b, 0xff, 0xc4, 0x00, 0x15, 0x11,
    0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x14, 0xff, 0xda, 0x00, 0x08, 0x01, 0x02, 0x01, 0x01, 0x3f, 0x01, 0x81, 0x03, 0xff, 0xc4,
    0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x20, 0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x06, 0x3f, 0x02, 0x5f, 0xff,
    0xc4, 0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x20, 0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x01, 0x3f, 0x21, 0x5f,
    0xff, 0x00, 0xff, 0xda, 0x00, 0x0c, 0x03, 0x01, 0x00, 0x02, 0x00, 0x03, 0x00, 0x00, 0x00, 0x10,
    0xc7, 0x1f, 0xff, 0xc4, 0x00, 0x15, 0x11, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x71, 0xff, 0xda, 0x00, 0x08, 0x01, 0x03, 0x01,
    0x01, 0x3f, 0x10, 0xa5, 0x3f, 0xff, 0xc4, 0x00, 0x15, 0x11, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x71, 0xff, 0xda, 0x00, 0x08,
    0x01, 0x02, 0x01, 0x01, 0x3f, 0x10, 0x84, 0x3f, 0xff, 0xc4, 0x00, 0x16, 0x10, 0x01, 0x01, 0x01,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x71, 0x00, 0x20,
    0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x01, 0x3f, 0x10, 0x52, 0x96, 0x07, 0xff, 0xd9,
};

std::vector<int> pixel(const Image8& image, uint32_t x, uint32_t y) {
  return {image.at(x, y), image.at(x, y) + 4};
}

TEST(ImageFile, PngRoundTripKeepsEveryBit) {
  TemporaryFolder folder;
  for (const bool opaque : {true, false}) {
    const Image8 image = make_image(37, 23, opaque);
    const std::string path = folder.path("a.png");
    ASSERT_TRUE(write_png(path, image, {{"Software", "sinew"}, {"Title", "W\xc3\xa4lder"}}));
    const Result<Image8> back = read_png(path);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->width, 37u);
    EXPECT_EQ(back->height, 23u);
    EXPECT_EQ(back->pixels, image.pixels);
    const std::string bytes = slurp(path);
    EXPECT_NE(bytes.find(std::string("tEXtSoftware\0sinew", 18)), std::string::npos);
    EXPECT_NE(bytes.find("iTXtTitle"), std::string::npos);
    EXPECT_EQ(bytes[25], opaque ? 2 : 6) << "colour type";
  }
}

TEST(ImageFile, EveryColourTypeAndDepthBecomesRgba8) {
  using Pixel = std::vector<int>;
  const auto gray1 = decode(make_png(3, 1, 1, 0, std::string("\x00\xa0", 2)));
  ASSERT_TRUE(gray1);
  EXPECT_EQ(pixel(*gray1, 0, 0), (Pixel{255, 255, 255, 255}));
  EXPECT_EQ(pixel(*gray1, 1, 0), (Pixel{0, 0, 0, 255}));
  const auto gray16 = decode(make_png(1, 1, 16, 0, std::string("\x00\x80\x80", 3)));
  ASSERT_TRUE(gray16);
  EXPECT_EQ(pixel(*gray16, 0, 0), (Pixel{128, 128, 128, 255}));
  const auto gray_alpha = decode(make_png(1, 1, 8, 4, std::string("\x00\x40\x20", 3)));
  ASSERT_TRUE(gray_alpha);
  EXPECT_EQ(pixel(*gray_alpha, 0, 0), (Pixel{64, 64, 64, 32}));
  const std::string palette = chunk("PLTE", "\x01\x02\x03\x0a\x0b\x0c") + chunk("tRNS", "\x7f");
  const auto indexed = decode(make_png(2, 1, 8, 3, std::string("\x00\x00\x01", 3), palette));
  ASSERT_TRUE(indexed);
  EXPECT_EQ(pixel(*indexed, 0, 0), (Pixel{1, 2, 3, 127}));
  EXPECT_EQ(pixel(*indexed, 1, 0), (Pixel{10, 11, 12, 255}));
  // A gamma chunk must not change texture values.
  const auto gamma = decode(
      make_png(1, 1, 8, 2, std::string("\x00\x40\x50\x60", 4), chunk("gAMA", big_endian(100000))));
  ASSERT_TRUE(gamma);
  EXPECT_EQ(pixel(*gamma, 0, 0), (Pixel{64, 80, 96, 255}));
}

TEST(ImageFile, JpegsAreDecoded) {
  const auto image = decode(make_jpeg(40, 30));
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->width, 40u);
  EXPECT_EQ(image->height, 30u);
  EXPECT_NEAR(image->at(20, 10)[0], 80, 6);
  EXPECT_NEAR(image->at(20, 10)[1], 40, 6);
  EXPECT_NEAR(image->at(20, 10)[2], 128, 6);
  EXPECT_EQ(image->at(20, 10)[3], 255);

  const auto progressive =
      decode({reinterpret_cast<const char*>(kProgressiveJpeg), sizeof(kProgressiveJpeg)});
  ASSERT_TRUE(progressive) << progressive.error().message();
  EXPECT_EQ(progressive->width, 24u);
  EXPECT_GT(progressive->at(0, 0)[0], 230);
  EXPECT_LT(progressive->at(0, 0)[2], 25);
  EXPECT_GT(progressive->at(23, 15)[2], 230);
}

TEST(ImageFile, EveryTruncationIsAnError) {
  TemporaryFolder folder;
  ASSERT_TRUE(write_png(folder.path("a.png"), make_image(9, 7, false)));
  const std::string progressive(reinterpret_cast<const char*>(kProgressiveJpeg),
                                sizeof(kProgressiveJpeg));
  for (const std::string& whole : {slurp(folder.path("a.png")), make_jpeg(20, 20), progressive}) {
    ASSERT_TRUE(decode(whole));
    for_every_truncation(whole, [](const std::string& bytes) {
      const auto image = decode(bytes);
      ASSERT_FALSE(image);
      EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
      EXPECT_EQ(image.error().file, "texture");
    });
  }
}

TEST(ImageFile, RandomPatchesNeverCrash) {
  TemporaryFolder folder;
  ASSERT_TRUE(write_png(folder.path("a.png"), make_image(9, 7, false)));
  const std::string progressive(reinterpret_cast<const char*>(kProgressiveJpeg),
                                sizeof(kProgressiveJpeg));
  uint32_t seed = 20;
  for (const std::string& whole : {slurp(folder.path("a.png")), make_jpeg(20, 20), progressive}) {
    for_random_patches(whole, 3000, ++seed, [](const std::string& bytes) {
      const auto image = decode(bytes);
      if (image) {
        EXPECT_EQ(image->pixels.size(), size_t{4} * image->width * image->height);
      } else {
        EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
      }
    });
  }
}

TEST(ImageFile, BombsAreRefusedBeforeMemoryIsTaken) {
  const std::string row(100, '\0');
  for (const std::string& bomb :
       {make_png(16384, 16384, 8, 6, row), make_png(0x7fffffff, 1, 8, 6, row),
        make_png(16385, 1, 8, 0, row), make_png(0, 1, 8, 0, row)}) {
    EXPECT_FALSE(size_of(bomb));
    EXPECT_FALSE(decode(bomb));
  }
  std::string jpeg = make_jpeg(16, 16);
  const size_t frame_header = jpeg.find("\xff\xc0");
  ASSERT_NE(frame_header, std::string::npos);
  jpeg[frame_header + 5] = 0x3f;  // 16144 x 16144 pixels
  jpeg[frame_header + 7] = 0x3f;
  EXPECT_FALSE(size_of(jpeg));
  const auto image = decode(jpeg);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().problem.find("too short"), std::string::npos) << image.error().problem;
}

TEST(ImageFile, SizesComeFromTheHeaderAlone) {
  EXPECT_EQ(size_of(make_jpeg(40, 30))->height, 30u);
  const std::string png = make_png(3, 1, 1, 0, std::string("\x00\xa0", 2));
  EXPECT_EQ(size_of(png)->width, 3u);
  EXPECT_FALSE(size_of("GIF89a"));
  EXPECT_FALSE(decode(""));
}

TEST(ImageFile, PngErrorsNameTheFile) {
  TemporaryFolder folder;
  EXPECT_FALSE(write_png(folder.path("a.png"), Image8{}));
  const auto unwritable = write_png(folder.path("none/a.png"), make_image(2, 2, true));
  ASSERT_FALSE(unwritable);
  EXPECT_EQ(unwritable.error().kind, ErrorKind::output);
  const std::string jpeg = folder.write("a.jpg", make_jpeg(8, 8));
  const auto not_png = read_png(jpeg);
  ASSERT_FALSE(not_png);
  EXPECT_EQ(not_png.error().file, jpeg);
  EXPECT_FALSE(read_png(folder.path("missing.png")));
}

TEST(ImageFile, ComparisonMatchesHandComputedNumbers) {
  Image8 a{2, 1, {10, 20, 30, 255, 0, 0, 0, 255}};
  Image8 b{2, 1, {13, 20, 30, 255, 0, 0, 2, 251}};
  const auto result = compare_images(a, b);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->mean, 5.0 / 6.0 / 255.0, 1e-12);
  EXPECT_NEAR(result->largest, 4.0 / 255.0, 1e-12);
  EXPECT_NEAR(result->psnr, 10.0 * std::log10(255.0 * 255.0 * 6.0 / 13.0), 1e-9);
  EXPECT_EQ(result->pixels_over, 2u);
  EXPECT_EQ(compare_images(a, b, 3)->pixels_over, 1u);
  EXPECT_EQ(compare_images(a, a)->psnr, std::numeric_limits<double>::infinity());

  const auto sizes = compare_images(a, make_image(3, 5, true));
  ASSERT_FALSE(sizes);
  EXPECT_NE(sizes.error().problem.find("2 x 1 and 3 x 5"), std::string::npos);
}

}  // namespace
}  // namespace sinew
