#include "app/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

namespace sinew::app {
namespace {

tl::unexpected<Error> bad_value(const char* option, std::string_view text, std::string problem,
                                std::string remedy) {
  return fail({ErrorKind::usage, "", fmt::format("{} '{}'", option, text), std::move(problem),
               std::move(remedy)});
}

// The number of insertions, deletions and exchanges that make `b` of `a` (Levenshtein).
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t exchanged = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

Result<ImageSize> parse_size(std::string_view text) {
  const size_t cross = text.find_first_of("xX");
  const auto width = parse_whole(text.substr(0, cross));
  const auto height =
      cross == std::string_view::npos ? std::nullopt : parse_whole(text.substr(cross + 1));
  if (!width || !height) {
    return bad_value("--size", text, "is not a size in pixels", "write 1024x768");
  }
  if (*width < 1 || *height < 1 || *width > kMaxImageSide || *height > kMaxImageSide) {
    return bad_value("--size", text, "no such picture can be made",
                     fmt::format("each side has 1 to {} pixels", kMaxImageSide));
  }
  return ImageSize{static_cast<uint32_t>(*width), static_cast<uint32_t>(*height)};
}

Result<uint64_t> parse_bytes(std::string_view text, const char* option) {
  constexpr std::string_view kUnits = "KMGT";
  constexpr const char* kRemedy = "write 2G, 512M or a number of bytes";
  const size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  const auto number = parse_number(text.substr(0, digits));
  std::string unit(text.substr(digits));
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  double factor = 1.0;
  if (const size_t power = unit.empty() ? kUnits.npos : kUnits.find(unit[0]);
      power != kUnits.npos) {
    factor = std::pow(1024.0, static_cast<double>(power + 1));
    unit.erase(0, 1);
  }
  if (!number || !(unit.empty() || unit == "B" || unit == "IB")) {
    return bad_value(option, text, "is not an amount of memory", kRemedy);
  }
  const double bytes = *number * factor;
  if (!(bytes >= 1.0 && bytes < 0x1p63)) {
    return bad_value(option, text, "is out of range", kRemedy);
  }
  return static_cast<uint64_t>(bytes);
}

Result<Rgb> parse_color(std::string_view text) {
  std::string_view digits = text;
  if (digits.starts_with('#')) digits.remove_prefix(1);
  uint32_t value = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, status] = std::from_chars(digits.data(), end, value, 16);
  if (digits.size() != 6 || status != std::errc() || stop != end) {
    return bad_value("--background", text, "is not a colour", "write 3a6ea5: red, green, blue");
  }
  return Rgb{static_cast<uint8_t>(value >> 16), static_cast<uint8_t>(value >> 8 & 0xff),
             static_cast<uint8_t>(value & 0xff)};
}

std::optional<uint64_t> parse_whole(std::string_view text) {
  uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    const size_t comma = text.find(',');
    const auto number = parse_number(text.substr(0, comma));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

std::string nearest_word(std::string_view typed, const std::vector<std::string>& words) {
  std::string best;
  size_t least = std::max<size_t>(1, typed.size() / 3) + 1;
  for (const std::string& word : words) {
    const size_t distance = edit_distance(typed, word);
    if (distance < least) {
      least = distance;
      best = word;
    }
  }
  return best;
}

}  // namespace sinew::app
