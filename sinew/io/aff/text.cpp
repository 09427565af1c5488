#include "sinew/io/aff/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/io/text.h"

namespace sinew::aff {
namespace {

constexpr uint32_t kMostElements = uint32_t{1} << 30;

bool is_blank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}
bool is_comment(char c) {
  return c == '#' || c == '%';
}
bool is_brace(char c) {
  return c == '{' || c == '}';
}

}  // namespace

void Words::skip_blanks() {
  while (at_ < text_.size()) {
    if (is_comment(text_[at_])) {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (is_blank(text_[at_])) {
      ++at_;
    } else {
      return;
    }
  }
}

// A # or % within a word belongs to it (names of files).
std::string_view Words::peek() const {
  if (at_end()) return {};
  size_t end = at_;
  while (end < text_.size() && !is_blank(text_[end]) && !is_brace(text_[end])) ++end;
  return text_.substr(at_, std::max(end - at_, size_t{1}));
}

bool Words::next_is(std::string_view word) const {
  return peek() == word;
}

bool Words::next_is_number() const {
  if (at_end()) return false;
  const char c = text_[at_];
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
}

std::string_view Words::word() {
  const std::string_view result = peek();
  last_begin_ = at_;
  at_ += result.size();
  skip_blanks();
  return result;
}

uint64_t Words::line_of(size_t position) const {
  const auto end = text_.begin() + static_cast<ptrdiff_t>(position);
  return 1 + static_cast<uint64_t>(std::count(text_.begin(), end, '\n'));
}

tl::unexpected<Error> Words::error(std::string problem, std::string remedy) const {
  return fail({ErrorKind::bad_input, path_, fmt::format("line {}", line()), std::move(problem),
               std::move(remedy)});
}

tl::unexpected<Error> Words::unexpected(std::string_view wanted) const {
  if (at_end()) {
    return error(fmt::format("the file ends where {} is expected", wanted),
                 "check that the file is complete");
  }
  Words here = *this;
  const std::string found = printable(here.word());
  return here.error(fmt::format("\"{}\" stands where {} is expected", found, wanted));
}

Result<void> Words::expect(std::string_view wanted) {
  if (!next_is(wanted)) return unexpected(fmt::format("\"{}\"", wanted));
  word();
  return {};
}

Result<std::string> Words::name(std::string_view what) {
  if (at_end() || is_brace(text_[at_])) return unexpected(what);
  return std::string(word());
}

Result<void> Words::number(double& out) {
  const size_t end = at_ + take_number(text_.substr(at_), out);
  const bool whole =
      end == text_.size() || is_blank(text_[end]) || is_brace(text_[end]) || is_comment(text_[end]);
  if (end == at_ || !whole) return unexpected("a number");
  if (!std::isfinite(static_cast<float>(out))) return unexpected("a finite number");
  last_begin_ = at_;
  at_ = end;
  skip_blanks();
  return {};
}

Result<void> Words::numbers(std::span<double> out) {
  for (double& value : out) SINEW_CHECKED(number(value));
  return {};
}

Result<void> Words::numbers(std::span<float> out) {
  for (float& value : out) {
    double wide = 0.0;
    SINEW_CHECKED(number(wide));
    value = static_cast<float>(wide);
  }
  return {};
}

Result<void> Words::integer(int64_t& out) {
  double value = 0.0;
  Words here = *this;
  SINEW_CHECKED(here.number(value));
  if (value != std::floor(value) || std::abs(value) > 1e15) return unexpected("a whole number");
  at_ = here.at_;
  last_begin_ = here.last_begin_;
  out = static_cast<int64_t>(value);
  return {};
}

Result<void> Words::index(uint32_t& out, size_t below, std::string_view what) {
  int64_t value = 0;
  SINEW_CHECKED(integer(value));
  if (value < 0 || static_cast<uint64_t>(value) >= below) {
    return error(fmt::format("{} {} is asked for where {} exist", what, value, below));
  }
  out = static_cast<uint32_t>(value);
  return {};
}

Result<uint32_t> Words::count(std::string_view what, uint64_t numbers_each) {
  int64_t value = 0;
  SINEW_CHECKED(integer(value));
  if (value < 0 || value > kMostElements) {
    return error(fmt::format("claims {} {}", value, what));
  }
  // A number takes a digit and, but for the last, a blank.
  const uint64_t room = (text_.size() - at_ + 1) / 2;
  if (static_cast<uint64_t>(value) * numbers_each > room) {
    return error(fmt::format("claims {} {}, more than the rest of the file can hold", value, what),
                 "check that the file is complete");
  }
  return static_cast<uint32_t>(value);
}

}  // namespace sinew::aff
