#include "sinew/io/text.h"

#include <charconv>
#include <cmath>
#include <filesystem>

namespace sinew {

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 'a' - 'A') : c;
  return extension;
}

std::string printable(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text) c = c >= ' ' && c <= '~' ? c : '?';
  return text;
}

size_t take_number(std::string_view text, double& out) {
  const size_t plus = text.starts_with('+') && !text.starts_with("+-") ? 1 : 0;
  const auto [stop, problem] = std::from_chars(text.data() + plus, text.data() + text.size(), out);
  if (problem == std::errc::invalid_argument) return 0;
  const std::string_view number = text.substr(0, static_cast<size_t>(stop - text.data()));
  if (problem == std::errc::result_out_of_range) {
    const size_t exponent = number.find_first_of("eE");
    const bool small = exponent != std::string_view::npos && number.substr(exponent + 1, 1) == "-";
    out = small ? 0.0 : HUGE_VAL;
  }
  return number.size();
}

}  // namespace sinew
