#include "sinew/io/image_ppm.h"

#include <gtest/gtest.h>

#include "io/hostile.h"

namespace sinew {
namespace {

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

TEST(Ppm, EightAndSixteenBits) {
  const auto image = decode_ppm(bytes_of("P6#c\n2\t1 # d\n255\nabcdef"), "a.ppm");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->width, 2u);
  EXPECT_EQ(image->height, 1u);
  EXPECT_EQ(image->pixels, (std::vector<uint8_t>{'a', 'b', 'c', 255, 'd', 'e', 'f', 255}));

  const auto wide = decode_ppm(bytes_of(std::string("P6 1 1 65535\n\xff\xff\x80\0\0\1", 19)), "b");
  ASSERT_TRUE(wide) << wide.error().message();
  EXPECT_EQ(wide->pixels, (std::vector<uint8_t>{255, 128, 0, 255}));

  const auto scaled = decode_ppm(bytes_of(std::string("P6 1 1 10 \x0a\x05\xff", 13)), "c");
  ASSERT_TRUE(scaled) << scaled.error().message();
  EXPECT_EQ(scaled->pixels, (std::vector<uint8_t>{255, 128, 255, 255})) << "too bright is white";
}

TEST(Ppm, WhatItClaimsMustBeThere) {
  EXPECT_TRUE(is_ppm(bytes_of("P6")));
  EXPECT_FALSE(is_ppm(bytes_of("P5 1 1 255 a")));
  for (const char* bad : {"P6", "P6 1 1 255", "P6 0 1 255 abc", "P6 1 1 0 abc", "P6 1 1 70000 abc",
                          "P6 99999 99999 255 abc", "P6 4294967297 1 255 abc", "P6 -1 1 255 abc",
                          "P6 2 1 255 abcde"}) {
    const auto image = decode_ppm(bytes_of(bad), "bad.ppm");
    ASSERT_FALSE(image) << bad;
    EXPECT_EQ(image.error().file, "bad.ppm");
    EXPECT_FALSE(ppm_size(bytes_of(bad), "bad.ppm"));
  }
}

}  // namespace
}  // namespace sinew
