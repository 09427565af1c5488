#include "sinew/io/image_exr.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "io/hostile.h"

namespace sinew {
namespace {

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

struct Sample {
  static constexpr ImageSize kSize{17, 9};
  std::vector<float> color, depth;
  std::vector<uint32_t> id;
  TemporaryFolder folder;
  std::string path = folder.path("a.exr");

  Sample() {
    for (uint32_t i = 0; i < kSize.width * kSize.height; ++i) {
      for (uint32_t c = 0; c < 3; ++c)
        color.push_back(static_cast<float>(i) * 0.25f + static_cast<float>(c));
      depth.push_back(1.0f / (1.0f + static_cast<float>(i)));
      id.push_back(0xfffffff0u + i);
    }
  }
  std::vector<ExrChannel> channels() const {
    return {{"B", ExrType::half, color.data() + 2, 3},
            {"G", ExrType::half, color.data() + 1, 3},
            {"R", ExrType::half, color.data(), 3},
            {"depth.Z", ExrType::float32, depth.data()},
            {"object.id", ExrType::uint32, id.data()}};
  }
  Result<void> write(const ExrAttributes& attributes = {}) const {
    return write_exr(path, kSize, channels(), attributes);
  }
};

TEST(Exr, ComesBackAsItWent) {
  const Sample sample;
  ExrAttributes attributes{{{"Clip", "Walk"}, {"Source", "B\xc3\xa4r.glb"}}, {}, {}};
  mat4 matrix;
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(i);
  attributes.world_to_camera = matrix;
  ASSERT_TRUE(sample.write(attributes));
  const Result<ExrImage> image = read_exr(sample.path);
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->size.width, 17u);
  EXPECT_EQ(image->size.height, 9u);
  ASSERT_EQ(image->planes.size(), 5u);
  for (size_t i = 0; i < sample.id.size(); ++i) {
    ASSERT_EQ(image->find("R")->floats[i], sample.color[3 * i]);
    ASSERT_EQ(image->find("B")->floats[i], sample.color[3 * i + 2]);
  }
  EXPECT_EQ(image->find("R")->type, ExrType::half);
  EXPECT_EQ(image->find("depth.Z")->floats, sample.depth);
  EXPECT_EQ(image->find("object.id")->integers, sample.id);
  EXPECT_TRUE(image->find("object.id")->floats.empty());
  EXPECT_EQ(image->find("depth"), nullptr);
  EXPECT_EQ(image->attributes.texts, attributes.texts);
  EXPECT_EQ(image->attributes.world_to_camera, matrix);
  EXPECT_FALSE(image->attributes.world_to_ndc);
  EXPECT_EQ(sample.folder.file_count(), 1u);
}

TEST(Exr, HalvesAreClampedButInfinityStays) {
  const TemporaryFolder folder;
  const std::vector<float> values = {1e9f, -1e9f, INFINITY, NAN, 0.0f, 65504.0f};
  const ExrChannel channel{"Y", ExrType::half, values.data()};
  ASSERT_TRUE(write_exr(folder.path("a.exr"), {6, 1}, {&channel, 1}));
  const auto read = read_exr(folder.path("a.exr"))->planes[0].floats;
  EXPECT_EQ(read[0], 65504.0f);
  EXPECT_EQ(read[1], -65504.0f);
  EXPECT_EQ(read[2], INFINITY);
  EXPECT_TRUE(std::isnan(read[3]));
  EXPECT_EQ(read[5], 65504.0f);
}

TEST(Exr, TheSameBytesEveryTime) {
  const Sample a, b;
  ASSERT_TRUE(a.write() && b.write());
  EXPECT_EQ(slurp(a.path), slurp(b.path));
}

TEST(Exr, UnwritablePlacesAndEmptyPicturesAreErrors) {
  const Sample sample;
  const auto channels = sample.channels();
  EXPECT_EQ(write_exr(sample.folder.path("no/a.exr"), Sample::kSize, channels).error().kind,
            ErrorKind::output);
  EXPECT_FALSE(write_exr(sample.path, {0, 4}, channels));
  EXPECT_FALSE(write_exr(sample.path, Sample::kSize, {}));
  EXPECT_EQ(sample.folder.file_count(), 0u);
}

TEST(Exr, DamagedFilesAreErrors) {
  const Sample sample;
  ASSERT_TRUE(sample.write({{{"Clip", "Walk"}}, {}, {}}));
  const std::string whole = slurp(sample.path);
  for_every_truncation(whole, [](const std::string& bytes) {
    const auto image = decode_exr(bytes_of(bytes), "a.exr");
    ASSERT_FALSE(image.has_value());
    EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
  });
  int errors = 0;
  for_random_patches(whole, 1000, 11, [&](const std::string& bytes) {
    const auto image = decode_exr(bytes_of(bytes), "a.exr");
    errors += !image.has_value();
    ASSERT_LE(image ? image->size.width : 0u, kMaxImageSide);
  });
  EXPECT_GT(errors, 150);
  EXPECT_FALSE(decode_exr({}, "a.exr"));
  EXPECT_EQ(read_exr(sample.folder.path("missing.exr")).error().kind, ErrorKind::bad_input);
}

// Writes a box of the given corners over the data window (and display window) of the file.
std::string with_window(std::string bytes, int32_t max_x, int32_t max_y) {
  for (const char* name : {"dataWindow", "displayWindow"}) {
    const size_t at = bytes.find(name) + std::strlen(name) + 1 + sizeof("box2i") + 4;
    const int32_t box[4] = {0, 0, max_x, max_y};
    std::memcpy(bytes.data() + at, box, sizeof(box));
  }
  return bytes;
}

TEST(Exr, AbsurdSizesAreRefusedBeforeMemoryIsSpent) {
  const Sample sample;
  ASSERT_TRUE(sample.write());
  const std::string whole = slurp(sample.path);
  EXPECT_TRUE(decode_exr(bytes_of(with_window(whole, 16, 8)), "same.exr"));
  for (const auto& [x, y] : {std::pair(16383, 16383),
                             {2000000000, 8},
                             {16, 2000000000},
                             {2147483647, 2147483647},
                             {-5, 8},
                             {100000, 100000}}) {
    const auto image = decode_exr(bytes_of(with_window(whole, x, y)), "a.exr");
    ASSERT_FALSE(image.has_value()) << x << " x " << y;
    EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
  }
}

}  // namespace
}  // namespace sinew
