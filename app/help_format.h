// How help is laid out: text wrapped to lines that fit a narrow terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sinew::app {

inline constexpr size_t kHelpWidth = 96;  // columns

// Breaks the text between words, but not after a colon, into lines of at most `width` characters
// (more if a word has more); all but the first begin with `indent` spaces, which do not count.
std::string wrap(std::string_view text, size_t width, size_t indent = 0);

}  // namespace sinew::app
