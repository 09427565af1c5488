#include "app/help_format.h"

#include <gtest/gtest.h>

namespace sinew::app {
namespace {

TEST(HelpFormat, WrapsBetweenWords) {
  EXPECT_EQ(wrap("", 10), "");
  EXPECT_EQ(wrap("one two", 10), "one two");
  EXPECT_EQ(wrap("one two three", 7), "one two\nthree");
  EXPECT_EQ(wrap("one two three", 6, 2), "one\n  two\n  three");
  EXPECT_EQ(wrap("unbreakable a", 4), "unbreakable\na");
  EXPECT_EQ(wrap("rays (default: 8)", 15), "rays\n(default: 8)");
}

}  // namespace
}  // namespace sinew::app
