#include "sinew/base/random_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace sinew {
namespace {

tl::unexpected<Error> failure(const std::string& path, std::string problem, std::string remedy) {
  return fail({ErrorKind::bad_input, path, "", std::move(problem), std::move(remedy)});
}

}  // namespace

Result<RandomFile> RandomFile::open(const std::string& path) {
  RandomFile file;
  file.path_ = path;
  // Not blocking: opening a pipe that nobody writes to must not wait for ever.
  file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file.descriptor_ < 0 && (errno == ENOENT || errno == ENOTDIR)) {
    return failure(path, "does not exist", "check the path");
  }
  struct stat status = {};
  if (file.descriptor_ < 0 || ::fstat(file.descriptor_, &status) != 0) {
    return failure(path, std::string("cannot be opened: ") + std::strerror(errno), "");
  }
  if (!S_ISREG(status.st_mode)) return failure(path, "is not a regular file", "give a file");
  file.size_ = static_cast<uint64_t>(status.st_size);
  return file;
}

RandomFile& RandomFile::operator=(RandomFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(path_, other.path_);
  return *this;
}

RandomFile::~RandomFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> RandomFile::read(uint64_t offset, std::span<uint8_t> out) const {
  size_t done = 0;
  while (done < out.size()) {
    const ssize_t count = ::pread(descriptor_, out.data() + done, out.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      return failure(path_, std::string("cannot be read: ") + std::strerror(errno), "");
    }
    if (count == 0) return failure(path_, "was cut while it was read", "make the file again");
    done += static_cast<size_t>(count);
  }
  return {};
}

}  // namespace sinew
