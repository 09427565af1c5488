#include "sinew/base/error.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(Error, MessageNamesFileElementProblemAndRemedy) {
  const Error error{ErrorKind::bad_input, "a.glb", "accessor 3", "is cut off", "export it again"};
  EXPECT_EQ(error.message(), "a.glb: accessor 3: is cut off (export it again)");
  EXPECT_EQ((Error{ErrorKind::usage, "", "", "no clip", ""}.message()), "no clip");
}

Result<int> positive(int x) {
  if (x <= 0) return fail({ErrorKind::usage, "", "", "not positive", ""});
  return x;
}
Result<int> sum(int a, int b) {
  SINEW_TRY(const int x, positive(a));
  SINEW_TRY(const int y, positive(b));
  return x + y;
}

TEST(Error, TryPassesValuesAndErrorsOn) {
  EXPECT_EQ(*sum(1, 2), 3);
  EXPECT_EQ(sum(1, -2).error().problem, "not positive");
}

}  // namespace
}  // namespace sinew
