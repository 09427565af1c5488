#include "app/contact_sheet.h"

#include <gtest/gtest.h>

#include <set>

namespace sinew::app {
namespace {

Image8 plain(uint32_t width, uint32_t height, std::array<uint8_t, 4> color) {
  Image8 image{width, height, {}};
  for (size_t i = 0; i < size_t{width} * height; ++i) {
    image.pixels.insert(image.pixels.end(), color.begin(), color.end());
  }
  return image;
}

// The reds in the sheet that are frames' (paper is bluish).
std::set<int> reds(const Image8& sheet) {
  std::set<int> found;
  for (size_t i = 0; i < sheet.pixels.size(); i += 4) {
    if (sheet.pixels[i + 2] == 0) found.insert(sheet.pixels[i]);
  }
  return found;
}

TEST(ContactSheet, ShowsEveryFrameOfAShortMovieInOrder) {
  ContactSheet sheet({64, 48}, 3);
  for (size_t i = 0; i < 3; ++i) {
    sheet.add(i, plain(64, 48, {static_cast<uint8_t>(100 + i), 0, 0, 255}));
  }
  EXPECT_EQ(reds(sheet.image()), std::set<int>({100, 101, 102}));
  EXPECT_EQ(sheet.image().at(10, 10)[0], 100);
  EXPECT_EQ(sheet.image().at(80, 10)[0], 101);
  EXPECT_EQ(sheet.image().at(10, 70)[0], 102);
}

TEST(ContactSheet, ChoosesEvenlyFromALongMovie) {
  ContactSheet sheet({8, 8}, 200);
  for (size_t i = 0; i < 200; ++i) sheet.add(i, plain(8, 8, {static_cast<uint8_t>(i), 0, 0, 255}));
  const std::set<int> found = reds(sheet.image());
  EXPECT_EQ(found.size(), ContactSheet::kMaxPictures);
  EXPECT_TRUE(found.count(0) && found.count(100) && found.count(190));
}

TEST(ContactSheet, ShrinksLargeFramesAndSurvivesThinOnes) {
  EXPECT_LT(ContactSheet({1600, 1200}, 4).image().width, 700u);
  ContactSheet thin({5000, 1}, 1);
  thin.add(0, plain(5000, 1, {9, 0, 0, 255}));
  EXPECT_EQ(reds(thin.image()), std::set<int>({9}));
}

TEST(ContactSheet, TransparentPixelsShowThePaper) {
  ContactSheet sheet({8, 8}, 1);
  const Image8 before = sheet.image();
  sheet.add(0, plain(8, 8, {255, 0, 0, 0}));
  EXPECT_EQ(sheet.image().pixels, before.pixels);
}

}  // namespace
}  // namespace sinew::app
