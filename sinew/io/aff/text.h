// The text that AFF files are made of: words separated by blanks and line ends, braces, and
// comments from # or % to the end of the line.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/math/vec.h"

namespace sinew::aff {

// Takes words and numbers off the front of a file's text, which must outlive it.
class Words {
 public:
  Words(std::string_view text, const std::string& path) : text_(text), path_(path) {
    skip_blanks();
  }

  bool at_end() const { return at_ == text_.size(); }
  bool next_is(std::string_view word) const;
  bool next_is_number() const;
  // A brace is a word by itself. Empty at the end.
  std::string_view word();

  Result<void> expect(std::string_view word);
  Result<std::string> name(std::string_view what);
  Result<void> number(double& out);
  Result<void> numbers(std::span<double> out);
  Result<void> numbers(std::span<float> out);
  template <int N>
  Result<void> vector(glm::vec<N, float>& out) {
    return numbers(std::span<float>(&out.x, N));
  }
  Result<void> integer(int64_t& out);
  Result<void> index(uint32_t& out, size_t below, std::string_view what);
  // How many `what` follow; an error if the rest of the file cannot hold them at
  // `numbers_each` numbers apiece.
  Result<uint32_t> count(std::string_view what, uint64_t numbers_each);

  const std::string& path() const { return path_; }
  size_t position() const { return last_begin_; }  // of the word taken last
  uint64_t line() const { return line_of(last_begin_); }
  uint64_t line_of(size_t position) const;  // from 1; reads all the text before it
  // An error at that line.
  tl::unexpected<Error> error(std::string problem, std::string remedy = "") const;

 private:
  void skip_blanks();
  std::string_view peek() const;
  tl::unexpected<Error> unexpected(std::string_view wanted) const;

  std::string_view text_;
  const std::string& path_;
  size_t at_ = 0;          // where the next word begins
  size_t last_begin_ = 0;  // where the last one began
};

// A reader names no more things that it passes over.
inline constexpr size_t kMostWarnings = 200;

}  // namespace sinew::aff
