#include "app/output_name.h"

#include <gtest/gtest.h>

namespace sinew::app {
namespace {

std::string frame_name(const char* pattern, int frame) {
  const auto name = parse_output_name(pattern);
  return name ? name->of_frame(frame) : name.error().message();
}

TEST(OutputName, EveryCounterIsUnderstood) {
  EXPECT_EQ(frame_name("out_####.png", 7), "out_0007.png");
  EXPECT_EQ(frame_name("out_%04d.png", 7), "out_0007.png");
  EXPECT_EQ(frame_name("out_{frame:04}.png", 7), "out_0007.png");
  EXPECT_EQ(frame_name("out_{frame:04d}.png", 7), "out_0007.png");
  EXPECT_EQ(frame_name("out_%d.png", 7), "out_7.png");
  EXPECT_EQ(frame_name("out_{frame}.png", 7), "out_7.png");
  EXPECT_EQ(frame_name("#.png", 123), "123.png");
  EXPECT_EQ(frame_name("a/b##.png", 12345), "a/b12345.png");
}

TEST(OutputName, WhatIsNoCounterStays) {
  EXPECT_EQ(frame_name("still.png", 7), "still.png");
  EXPECT_EQ(frame_name("50%.png", 7), "50%.png");
  EXPECT_EQ(frame_name("{framed}.png", 7), "{framed}.png");
  EXPECT_EQ(frame_name("folder_##/a.png", 7), "folder_##/a.png");
  EXPECT_FALSE(parse_output_name("still.png")->has_counter());
}

TEST(OutputName, TheEndingOrTheOptionSaysTheFormat) {
  EXPECT_EQ(parse_output_name("a.png")->format, OutputFormat::png);
  EXPECT_EQ(parse_output_name("a.WebP")->format, OutputFormat::webp);
  EXPECT_EQ(parse_output_name("-")->format, OutputFormat::png);
  EXPECT_EQ(parse_output_name("-", "webp")->format, OutputFormat::webp);
  EXPECT_EQ(parse_output_name("a", "png")->format, OutputFormat::png);
}

TEST(OutputName, NonsenseIsAUsageErrorWithARemedy) {
  for (const char* path : {"", "a", "a.jpg", "a.avi", "a_##_##.png", "a_##_%d.png", "a_##.webp",
                           "a_##.mp4", "%0999999999999d.png", "{frame:99}.png", "a.png/"}) {
    const auto name = parse_output_name(path);
    ASSERT_FALSE(name.has_value()) << path;
    EXPECT_EQ(name.error().kind, ErrorKind::usage) << path;
    EXPECT_FALSE(name.error().remedy.empty()) << path;
  }
}

}  // namespace
}  // namespace sinew::app
