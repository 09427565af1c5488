#include "sinew/io/text.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {
namespace {

TEST(Text, NumbersEndWhereTheyEnd) {
  const auto expect_number = [](std::string_view text, double value, size_t length) {
    double out = -7.0;
    EXPECT_EQ(take_number(text, out), length) << text;
    EXPECT_EQ(out, value) << text;
  };
  expect_number("1.5", 1.5, 3);
  expect_number("+2e3 4", 2000.0, 4);
  expect_number("-3}", -3.0, 2);
  expect_number("1e-999 ", 0.0, 6);
  expect_number("-1e-999", 0.0, 7);
  expect_number("1e999", HUGE_VAL, 5);
  for (const char* none : {"", "+", "x1", "+-1", "++1", " 1", "e5"}) {
    expect_number(none, -7.0, 0);
  }
}

TEST(Text, NamesFitForMessages) {
  EXPECT_EQ(printable(std::string_view("a\0\n\xff b", 6)), "a??? b");
  EXPECT_EQ(printable(std::string(100, 'x')).size(), 40u);
  EXPECT_EQ(extension_of("a.b/Walk.OBJ"), ".obj");
  EXPECT_EQ(extension_of("a.b/walk"), "");
}

}  // namespace
}  // namespace sinew
