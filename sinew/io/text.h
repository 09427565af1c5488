// Text that readers of all formats handle.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sinew {

// ".obj" of "Walk.OBJ"
std::string extension_of(const std::string& path);

// The start of a word, fit for a message whatever the file holds.
std::string printable(std::string_view word);

// Reads the number that `text` begins with, after a + if there is one; too small a number is zero,
// too large a one infinite. Gives its length, 0 if there is none.
size_t take_number(std::string_view text, double& out);

}  // namespace sinew
