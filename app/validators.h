// Checks of option values that CLI11 has not got.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "app/values.h"

namespace sinew::app {

// A finite number in [low, high]. (CLI::Range lets NaN pass.)
inline CLI::Validator number_in(double low, double high) {
  return CLI::Validator(
      [low, high](std::string& text) -> std::string {
        const auto number = parse_number(text);
        if (number && *number >= low && *number <= high) return "";
        return fmt::format("'{}' is not a number from {} to {}", text, low, high);
      },
      "");
}

// A whole number in [low, high].
inline CLI::Validator whole_number_in(uint64_t low, uint64_t high) {
  return CLI::Validator(
      [low, high](std::string& text) -> std::string {
        const auto number = parse_whole(text);
        if (number && *number >= low && *number <= high) return "";
        return fmt::format("'{}' is not a whole number from {} to {}", text, low, high);
      },
      "");
}

}  // namespace sinew::app
