#include "app/help_format.h"

namespace sinew::app {

std::string wrap(std::string_view text, size_t width, size_t indent) {
  std::string out;
  size_t column = 0;
  while (!text.empty()) {
    size_t end = text.find(' ');
    while (end != text.npos && end > 0 && text[end - 1] == ':') end = text.find(' ', end + 1);
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(word.size() < text.size() ? word.size() + 1 : word.size());
    if (!out.empty() && column + 1 + word.size() > width) {
      out += '\n' + std::string(indent, ' ');
      column = 0;
    } else if (!out.empty()) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

}  // namespace sinew::app
