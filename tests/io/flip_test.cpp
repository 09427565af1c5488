// FLIP against numbers from the paper's equations worked by hand, and properties that it promises.
#include "sinew/io/flip.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/math/random.h"

namespace sinew {
namespace {

using Rgb = std::array<uint8_t, 3>;

Image8 plain(Rgb color, uint32_t width = 24, uint32_t height = 16) {
  Image8 image{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), {color[0], color[1], color[2], 255});
  }
  return image;
}

Image8 noise(uint32_t seed, int amplitude) {
  Image8 image = plain({128, 128, 128}, 40, 30);
  Random random(seed);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    if (i % 4 == 3) continue;
    image.pixels[i] = static_cast<uint8_t>(
        128 + static_cast<int>(random.next() % 201) * amplitude / 100 - amplitude);
  }
  return image;
}

double flip(const Image8& a, const Image8& b, float pixels_per_degree = 67.0f) {
  return mean_error(*flip_errors(a, b, {pixels_per_degree}));
}

TEST(Flip, EqualImagesDoNotDiffer) {
  const Image8 image = noise(3, 100);
  const auto errors = *flip_errors(image, image);
  EXPECT_EQ(*std::max_element(errors.begin(), errors.end()), 0.0f);
}

// Plain images have no features and no detail to filter, so only the distance of colours is left.
// Black against white: HyAB = 100, 100^0.7 = 25.1189. The largest difference is that of green (L
// 87.735, a -86.183, b 83.180; Hunt: -75.612, 72.977) and blue (L 32.301, a 79.196, b -107.857;
// Hunt: 25.581, -34.839): HyAB = 55.434 + |(-101.193, 107.816)| = 203.298; ^0.7 = 41.273; its 0.4
// is 16.509, so 0.95 + 0.05 (25.1189 - 16.509) / (41.273 - 16.509) = 0.96738.
TEST(Flip, BlackAgainstWhiteByHand) {
  const auto errors = *flip_errors(plain({0, 0, 0}), plain({255, 255, 255}));
  for (const float error : errors) {
    ASSERT_NEAR(error, 0.96738f, 2e-4f);
  }
}

// Greys of L = 53.585 (128) and 54.368 (130): 0.783^0.7 = 0.8427; 0.95 / 16.509 * 0.8427 = 0.04849.
TEST(Flip, NearGreysByHand) {
  EXPECT_NEAR(flip(plain({128, 128, 128}), plain({130, 130, 130})), 0.04849, 3e-4);
}

TEST(Flip, GreenAgainstBlueIsTheLargest) {
  EXPECT_NEAR(flip(plain({0, 255, 0}), plain({0, 0, 255})), 1.0, 1e-4);
}

TEST(Flip, IsSymmetric) {
  const Image8 a = noise(5, 90), b = noise(6, 30);
  EXPECT_NEAR(flip(a, b), flip(b, a), 1e-6);
  EXPECT_GT(flip(a, b), 0.05);
}

TEST(Flip, GrowsWithTheDifference) {
  const Image8 grey = plain({128, 128, 128}, 40, 30);
  double last = 0.0;
  for (const int amplitude : {5, 15, 40, 100}) {
    const double error = flip(grey, noise(9, amplitude));
    EXPECT_GT(error, last) << amplitude;
    last = error;
  }
}

TEST(Flip, FineNoiseFadesWithDistance) {
  const Image8 grey = plain({128, 128, 128}, 40, 30), noisy = noise(9, 60);
  EXPECT_LT(flip(grey, noisy, 120.0f), flip(grey, noisy, 40.0f));
  EXPECT_LT(flip(grey, noisy, 40.0f), flip(grey, noisy, 10.0f));
}

TEST(Flip, OnePixelIsAPointFeatureThatSpreads) {
  const Image8 grey = plain({60, 60, 60}, 41, 41);
  Image8 firefly = grey;
  std::fill_n(firefly.at(20, 20), 3, uint8_t{255});
  const auto errors = *flip_errors(grey, firefly);
  const auto at = [&](size_t x, size_t y) { return errors[41 * y + x]; };
  EXPECT_EQ(std::max_element(errors.begin(), errors.end()) - errors.begin(), 41 * 20 + 20);
  EXPECT_GT(at(20, 20), 0.3f);
  EXPECT_GT(at(21, 20), 0.1f);
  EXPECT_EQ(at(2, 2), 0.0f);
  for (size_t d = 1; d < 12; ++d) {
    EXPECT_NEAR(at(20 + d, 20), at(20 - d, 20), 1e-4f);
    EXPECT_NEAR(at(20 + d, 20), at(20, 20 + d), 1e-4f);
  }
}

TEST(Flip, AnyDistanceAndSizeIsFinite) {
  for (const float pixels_per_degree : {1.0f, 5.0f, 300.0f}) {
    for (const auto& [width, height] : {std::pair(1u, 1u), {1u, 9u}, {9u, 1u}}) {
      const auto errors = *flip_errors(plain({10, 200, 30}, width, height),
                                       plain({200, 10, 99}, width, height), {pixels_per_degree});
      for (const float error : errors) ASSERT_TRUE(error > 0.0f && error <= 1.0f) << error;
    }
  }
}

TEST(Flip, DifferentSizesAreAnError) {
  const auto errors = flip_errors(plain({0, 0, 0}, 3, 2), plain({0, 0, 0}, 2, 3));
  ASSERT_FALSE(errors.has_value());
  EXPECT_NE(errors.error().problem.find("3 x 2 and 2 x 3"), std::string::npos);
}

}  // namespace
}  // namespace sinew
