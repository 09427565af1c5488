// MappedFile: the bytes of a file, mapped into memory where the system can, else read.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew {

class MappedFile {
 public:
  // An error if the file is missing, no regular file, or larger than `limit` bytes.
  static Result<MappedFile> open(const std::string& path, uint64_t limit);

  MappedFile(MappedFile&& other) noexcept { *this = std::move(other); }
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  // The file must not shrink while they are read. Files that are replaced by renaming do not.
  std::span<const uint8_t> bytes() const { return bytes_; }
  bool is_mapped() const { return mapped_ != nullptr; }

 private:
  MappedFile() = default;
  std::span<const uint8_t> bytes_;
  void* mapped_ = nullptr;
  std::vector<uint8_t> read_;  // if it could not be mapped
};

}  // namespace sinew
