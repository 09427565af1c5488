// Values of options: numbers, sizes, amounts of memory, colours. Every parser takes the whole text
// or gives a usage error that names the option and shows the right spelling.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/image_file.h"

namespace sinew::app {

Result<ImageSize> parse_size(std::string_view text);  // "1024x768", each side 1..kMaxImageSide

// "2G", "512M", "1.5GiB", "4096"; errors name the option.
Result<uint64_t> parse_bytes(std::string_view text, const char* option = "--memory-limit");

using Rgb = std::array<uint8_t, 3>;
Result<Rgb> parse_color(std::string_view text);  // "#3a6ea5" or "3a6ea5"

// A whole number, nothing before or after it.
std::optional<uint64_t> parse_whole(std::string_view text);

// A finite number, nothing before or after it.
std::optional<double> parse_number(std::string_view text);

// "1,2.5,-3"; nothing if some part is not a finite number.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

// Of `words`, the one that `typed` was probably meant to be; empty if none is near.
std::string nearest_word(std::string_view typed, const std::vector<std::string>& words);

}  // namespace sinew::app
