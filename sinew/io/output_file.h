// Atomic file output: bytes go to a temporary file beside the target, which is renamed into place
// on commit and removed otherwise.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "sinew/base/error.h"

namespace sinew {

// Writes all bytes or nothing. "-" is standard output. A link is followed; a device or pipe is
// written to directly.
Result<void> write_file(const std::string& path, std::span<const uint8_t> bytes);
Result<void> write_file(const std::string& path, std::string_view text);

// A file written piece by piece that appears whole or not at all: what is not published is removed.
// "-" is standard output; a link is followed; a device or pipe is written to directly.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::string& path);
  OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  Result<void> write(std::span<const uint8_t> bytes);
  // Ends the writing. What a full disk has to say has been said by then, so that of several files
  // all can be closed before the first is published.
  Result<void> close();
  Result<void> publish();  // closes, then renames into place

  const std::string& path() const { return path_; }
  // Where it grows until it is published, for other programs to write to; empty if nothing is
  // replaced in the end.
  const std::string& temporary() const { return temporary_; }
  uint64_t size() const { return size_; }  // bytes written

 private:
  OutputFile() = default;
  std::string path_;       // as the user named it
  std::string target_;     // what is renamed to; empty: nothing is
  std::string temporary_;  // what is removed; empty: nothing is
  int fd_ = -1;
  bool owns_fd_ = false;
  uint64_t size_ = 0;
};

// Bytes that wait on disk for their place in an output: a file beside it that has no name, so that
// nothing is left of it, whatever happens.
class SpoolFile {
 public:
  // `path` is the output's: the spool goes into its folder, or to the folder for temporary files if
  // the output is "-", a device or a pipe.
  static Result<SpoolFile> create(const std::string& path);
  SpoolFile(SpoolFile&& other) noexcept { *this = std::move(other); }
  SpoolFile& operator=(SpoolFile&& other) noexcept;
  ~SpoolFile();

  Result<void> write(std::span<const uint8_t> bytes);
  Result<void> copy_to(OutputFile& file) const;  // all of it
  uint64_t size() const { return size_; }

 private:
  SpoolFile() = default;
  std::string path_;  // as the user named it
  int fd_ = -1;
  uint64_t size_ = 0;
};

// Whether write_file(path) can work: to be asked before long work whose result goes there.
Result<void> check_writable(const std::string& path);

// The whole file in memory; an error if it is missing, no regular file, or larger than `limit`.
Result<std::string> read_file(const std::string& path, uint64_t limit);

}  // namespace sinew
