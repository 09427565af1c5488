// RandomFile: a file read piece by piece, from any thread. Unlike a mapped file, one that is cut
// while it is read is an error and not the end of the program.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sinew/base/error.h"

namespace sinew {

class RandomFile {
 public:
  // An error if the file is missing or no regular file.
  static Result<RandomFile> open(const std::string& path);

  RandomFile(RandomFile&& other) noexcept { *this = std::move(other); }
  RandomFile& operator=(RandomFile&& other) noexcept;
  ~RandomFile();

  uint64_t size() const { return size_; }  // when it was opened
  const std::string& path() const { return path_; }

  // Fills `out` from `offset` on. An error if the file ends before, or cannot be read.
  Result<void> read(uint64_t offset, std::span<uint8_t> out) const;

 private:
  RandomFile() = default;
  int descriptor_ = -1;
  uint64_t size_ = 0;
  std::string path_;
};

}  // namespace sinew
