#include "app/output_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxDigits = 16;

struct Counter {
  size_t begin = 0;
  size_t size = 0;
  int digits = 0;
};

size_t skip_digits(std::string_view text, size_t at) {
  return std::min(text.find_first_not_of("0123456789", at), text.size());
}

// The width in "04", "4" or ""; too wide comes back as more than kMaxDigits.
int width_of(std::string_view digits) {
  int width = 0;
  if (digits.empty()) return 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), width);
  return status == std::errc() ? width : kMaxDigits + 1;
}

// The counter that begins at `at`, if one does: ####, %04d or {frame:04}.
std::optional<Counter> counter_at(std::string_view text, size_t at) {
  if (text[at] == '#') {
    const size_t end = std::min(text.find_first_not_of('#', at), text.size());
    return Counter{at, end - at, static_cast<int>(std::min<size_t>(end - at, kMaxDigits + 1))};
  }
  if (text[at] == '%') {
    const size_t end = skip_digits(text, at + 1);
    if (end == text.size() || text[end] != 'd') return std::nullopt;
    return Counter{at, end + 1 - at, width_of(text.substr(at + 1, end - at - 1))};
  }
  constexpr std::string_view kFrame = "{frame";
  if (text.substr(at, kFrame.size()) != kFrame) return std::nullopt;
  size_t end = at + kFrame.size();
  int digits = 0;
  if (end < text.size() && text[end] == ':') {
    const size_t first = end + 1;
    end = skip_digits(text, first);
    digits = width_of(text.substr(first, end - first));
    if (end < text.size() && text[end] == 'd') ++end;
  }
  if (end == text.size() || text[end] != '}') return std::nullopt;
  return Counter{at, end + 1 - at, digits};
}

tl::unexpected<Error> bad_name(std::string_view path, std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", fmt::format("output '{}'", path), std::move(problem),
               std::move(remedy)});
}

Result<OutputFormat> format_of(std::string_view path, std::string_view format) {
  std::string word(format);
  if (word.empty() && path == "-") return OutputFormat::png;
  if (word.empty()) {
    word = fs::path(path).extension().string();
    if (!word.empty()) word.erase(0, 1);
  }
  std::transform(word.begin(), word.end(), word.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  for (const OutputFormat known :
       {OutputFormat::png, OutputFormat::exr, OutputFormat::webp, OutputFormat::mp4}) {
    if (word == extension(known)) return known;
  }
  if (word.empty()) {
    return bad_name(path, "its name does not say which format",
                    "end it with .png, .exr, .webp or .mp4, or give --format");
  }
  return bad_name(path, fmt::format("'{}' files are not written", word),
                  "use .png or .exr for pictures, .webp or .mp4 for a movie");
}

}  // namespace

const char* extension(OutputFormat format) {
  switch (format) {
    case OutputFormat::png:
      return "png";
    case OutputFormat::exr:
      return "exr";
    case OutputFormat::webp:
      return "webp";
    case OutputFormat::mp4:
      return "mp4";
  }
  return "";
}

std::string OutputName::of_frame(int frame) const {
  if (!has_counter()) return path;
  return fmt::format("{}{:0{}}{}", path.substr(0, counter_begin), frame, digits,
                     path.substr(counter_begin + counter_size));
}

Result<OutputName> parse_output_name(std::string_view path, std::string_view format) {
  OutputName name;
  name.path = path;
  if (path.empty()) return bad_name(path, "is empty", "write -o out.webp");
  SINEW_TRY(name.format, format_of(path, format));
  const size_t slash = path.rfind('/');
  for (size_t at = slash == path.npos ? 0 : slash + 1; at < path.size(); ++at) {
    const auto counter = counter_at(path, at);
    if (!counter) continue;
    if (name.has_counter()) {
      return bad_name(path, "has two frame counters", "keep one of them");
    }
    if (counter->digits > kMaxDigits) {
      return bad_name(path, "its frame counter is too wide",
                      fmt::format("use at most {} digits", kMaxDigits));
    }
    name.counter_begin = counter->begin;
    name.counter_size = counter->size;
    name.digits = counter->digits;
    at += counter->size - 1;
  }
  if (name.has_counter() && is_movie(name.format)) {
    return bad_name(path,
                    fmt::format("a .{} holds all frames, so its name needs no frame counter",
                                extension(name.format)),
                    "use .png for one file a frame");
  }
  return name;
}

}  // namespace sinew::app
