// What every format's tests need: a folder that vanishes, and files made bad in every way.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "sinew/math/random.h"

namespace sinew {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew_test_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::filesystem::remove(path_ / name);  // truncating would make some file systems flush
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path(name);
  }
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Calls read(bytes) with every proper prefix of `whole`.
template <class Read>
void for_every_truncation(const std::string& whole, const Read& read) {
  for (size_t size = 0; size < whole.size(); ++size) {
    SCOPED_TRACE("truncated to " + std::to_string(size) + " bytes");
    read(whole.substr(0, size));
  }
}

// Calls read(bytes) with `count` copies of `whole` in which one to four bytes are changed.
template <class Read>
void for_random_patches(const std::string& whole, int count, uint32_t seed, const Read& read) {
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", patch " + std::to_string(i));
    std::string bytes = whole;
    for (uint32_t patches = 1 + random.next() % 4; patches > 0; --patches) {
      bytes[random.next() % bytes.size()] = static_cast<char>(random.next() >> 24);
    }
    read(bytes);
  }
}

}  // namespace sinew
