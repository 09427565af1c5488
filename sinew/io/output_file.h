// Atomic file output: bytes go to a temporary file beside the target, which is renamed into place
// on commit and removed otherwise.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sinew/base/error.h"

namespace sinew {

// Writes all bytes or nothing. "-" is standard output. A link is followed; a device or pipe is
// written to directly.
Result<void> write_file(const std::string& path, std::span<const uint8_t> bytes);
Result<void> write_file(const std::string& path, std::string_view text);

// Whether write_file(path) can work: to be asked before long work whose result goes there.
Result<void> check_writable(const std::string& path);

// The whole file in memory; an error if it is missing, no regular file, or larger than `limit`.
Result<std::string> read_file(const std::string& path, uint64_t limit);

}  // namespace sinew
