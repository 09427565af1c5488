// Real data for tests lies outside the project and may be absent: then the test skips, aloud.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#define SINEW_DATA_OR_SKIP(variable, relative)                                \
  const std::string variable = std::string(SINEW_TEST_DATA "/") + (relative); \
  if (!std::filesystem::exists(variable)) GTEST_SKIP() << "no test data at " << variable
