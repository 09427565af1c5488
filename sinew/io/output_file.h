// Atomic file output: bytes go to a temporary file beside the target, which is renamed into place
// on commit and removed otherwise.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sinew/base/error.h"

namespace sinew {

// Writes all bytes or nothing. "-" is standard output. A link is followed; a device or pipe is
// written to directly.
Result<void> write_file(const std::string& path, std::span<const uint8_t> bytes);
Result<void> write_file(const std::string& path, std::string_view text);

// A file that another program writes: it grows under a temporary name beside `path`, takes its
// place on commit, and is gone without a trace if destroyed before that.
class PendingFile {
 public:
  // Refuses "-", devices and pipes, which can be neither replaced nor written twice.
  static Result<PendingFile> create(const std::string& path);
  PendingFile(PendingFile&&) noexcept;
  PendingFile& operator=(PendingFile&&) noexcept;
  ~PendingFile();

  const std::string& temporary() const;  // its name; the file is there, and empty
  Result<void> commit();

 private:
  struct Impl;
  explicit PendingFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Whether write_file(path) can work: to be asked before long work whose result goes there.
Result<void> check_writable(const std::string& path);

// The whole file in memory; an error if it is missing, no regular file, or larger than `limit`.
Result<std::string> read_file(const std::string& path, uint64_t limit);

}  // namespace sinew
