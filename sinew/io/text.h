// Text that readers of all formats handle.
#pragma once

#include <string>
#include <string_view>

namespace sinew {

// ".obj" of "Walk.OBJ"
std::string extension_of(const std::string& path);

// The start of a word, fit for a message whatever the file holds.
std::string printable(std::string_view word);

}  // namespace sinew
