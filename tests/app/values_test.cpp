#include "app/values.h"

#include <gtest/gtest.h>

namespace sinew::app {
namespace {

TEST(Values, Sizes) {
  EXPECT_EQ(parse_size("1024x768")->width, 1024u);
  EXPECT_EQ(parse_size("1024X768")->height, 768u);
  EXPECT_TRUE(parse_size("16384x1").has_value());
  for (const char* text : {"", "x", "800", "800x", "x600", "0x600", "800x0", "-1x5", "1x16385",
                           "99999999999999999999x1", "8x8x8", "8.5x8", " 8x8", "8x8 "}) {
    const auto size = parse_size(text);
    ASSERT_FALSE(size.has_value()) << text;
    EXPECT_EQ(size.error().kind, ErrorKind::usage) << text;
  }
}

TEST(Values, AmountsOfMemory) {
  EXPECT_EQ(*parse_bytes("2G"), uint64_t{2} << 30);
  EXPECT_EQ(*parse_bytes("512M"), uint64_t{512} << 20);
  EXPECT_EQ(*parse_bytes("1.5gib"), uint64_t{3} << 29);
  EXPECT_EQ(*parse_bytes("4096"), 4096u);
  EXPECT_EQ(*parse_bytes("64KB"), 65536u);
  EXPECT_EQ(*parse_bytes("100B"), 100u);
  for (const char* text : {"", "G", "0", "-1G", "1X", "1GG", "1e3", "nan", "inf", "99999999999T"}) {
    EXPECT_FALSE(parse_bytes(text).has_value()) << text;
  }
}

TEST(Values, Colours) {
  EXPECT_EQ(*parse_color("#3a6ea5"), (Rgb{0x3a, 0x6e, 0xa5}));
  EXPECT_EQ(*parse_color("FFffFF"), (Rgb{255, 255, 255}));
  for (const char* text : {"", "#", "fff", "red", "12345g", "#1234567", "-12345"}) {
    EXPECT_FALSE(parse_color(text).has_value()) << text;
  }
}

TEST(Values, Numbers) {
  EXPECT_EQ(parse_number("-1.5"), -1.5);
  for (const char* text : {"", "nan", "inf", "-inf", "1e999", "1x", " 1", "1,2"}) {
    EXPECT_FALSE(parse_number(text).has_value()) << text;
  }
}

TEST(Values, NearestWordForgivesSlips) {
  const std::vector<std::string> commands = {"info", "render", "compare", "bench"};
  EXPECT_EQ(nearest_word("rendr", commands), "render");
  EXPECT_EQ(nearest_word("inf", commands), "info");
  EXPECT_EQ(nearest_word("comapre", commands), "compare");
  EXPECT_EQ(nearest_word("zebra", commands), "");
  EXPECT_EQ(nearest_word("", commands), "");
}

}  // namespace
}  // namespace sinew::app
