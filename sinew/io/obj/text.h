// The text that OBJ and MTL files are made of: lines of words separated by blanks, with comments
// (#), continuation lines (\) and either kind of line end.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace sinew {

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

inline std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Gives logical lines, without comments and line ends. `text` must outlive it.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {
    if (rest_.substr(0, 3) == "\xef\xbb\xbf") rest_.remove_prefix(3);  // a byte order mark
  }

  // The view holds until the next call.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    number_ = next_number_;
    line = take_line();
    if (line.empty() || line.back() != '\\') return true;
    joined_.clear();
    while (!line.empty() && line.back() == '\\') {
      joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      line = rest_.empty() ? std::string_view() : take_line();
    }
    joined_.append(line);
    line = joined_;
    return true;
  }
  uint64_t number() const { return number_; }  // of the line's first part, from 1

 private:
  std::string_view take_line() {
    const size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++next_number_;
    // A # within a word belongs to it (names of materials and files).
    for (size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
      if (at > 0 && !is_blank(line[at - 1])) continue;
      line = line.substr(0, at);
      break;
    }
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

  std::string_view rest_;
  std::string joined_;
  uint64_t number_ = 0;
  uint64_t next_number_ = 1;
};

enum class ObjNumber : uint8_t { none, ok, not_finite };

// Takes words and numbers from the front of a line.
class ObjWords {
 public:
  explicit ObjWords(std::string_view line) : at_(line.data()), end_(line.data() + line.size()) {
    skip_blanks();
  }

  bool at_end() const { return at_ == end_; }
  std::string_view rest() const { return trim({at_, static_cast<size_t>(end_ - at_)}); }

  std::string_view word() {
    const char* begin = at_;
    while (at_ != end_ && !is_blank(*at_)) ++at_;
    const std::string_view result(begin, static_cast<size_t>(at_ - begin));
    skip_blanks();
    return result;
  }

  // Consumes a whole word if it is a number; else nothing. A number too small for a float is
  // rounded as usual, one too large is not finite.
  ObjNumber number(float& out) {
    const char* begin = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
    auto [stop, problem] = std::from_chars(begin, end_, out);
    if (problem == std::errc::result_out_of_range) {
      double wide = HUGE_VAL;
      if (std::from_chars(begin, end_, wide).ec != std::errc()) return ObjNumber::not_finite;
      out = static_cast<float>(wide);
    } else if (problem != std::errc()) {
      return ObjNumber::none;
    }
    if (stop != end_ && !is_blank(*stop)) return ObjNumber::none;
    if (!std::isfinite(out)) return ObjNumber::not_finite;
    at_ = stop;
    skip_blanks();
    return ObjNumber::ok;
  }

  // Consumes an integer of any length (saturated) and nothing after it; false if there is none.
  bool integer(int64_t& out) {
    const bool negative = at_ != end_ && *at_ == '-';
    const char* digits = negative ? at_ + 1 : at_;
    const char* stop = digits;
    int64_t value = 0;
    for (; stop != end_ && *stop >= '0' && *stop <= '9'; ++stop) {
      value = value < (int64_t{1} << 40) ? value * 10 + (*stop - '0') : value;
    }
    if (stop == digits) return false;
    out = negative ? -value : value;
    at_ = stop;
    return true;
  }
  // Consumes one character if it is next, without blanks before it.
  bool take(char c) {
    if (at_ == end_ || *at_ != c) return false;
    ++at_;
    return true;
  }
  // After integers: whether the word ends here; then goes to the next.
  bool end_word() {
    if (at_ != end_ && !is_blank(*at_)) return false;
    skip_blanks();
    return true;
  }

 private:
  void skip_blanks() {
    while (at_ != end_ && is_blank(*at_)) ++at_;
  }

  const char* at_;
  const char* end_;
};

// Fills `out` from the rest of the line, which must be `least` to out.size() finite numbers; gives
// how many there are, or what is wrong.
tl::expected<size_t, std::string> take_numbers(ObjWords& words, std::span<float> out, size_t least);

// Statements that a reader passes over, for one warning each.
class IgnoredStatements {
 public:
  // False if these are more kinds of statements than any such file has.
  bool add(std::string_view statement, uint64_t line);
  // "line 7: statement "curv" is not supported: ignored 3 times", by first line.
  void append_warnings(const std::string& prefix, std::vector<std::string>& warnings) const;

 private:
  struct Entry {
    std::string name;
    uint64_t line = 0;
    uint64_t count = 0;
  };
  std::vector<Entry> entries_;
};

}  // namespace sinew
