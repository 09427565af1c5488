#include "sinew/base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
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

// A file descriptor that closes itself.
struct Descriptor {
  explicit Descriptor(int number) : fd(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  int fd;
};

// Fills `out` from the file's begin; false if it has fewer bytes.
bool read_all(int fd, std::span<uint8_t> out) {
  size_t done = 0;
  while (done < out.size()) {
    const ssize_t count = ::read(fd, out.data() + done, out.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<size_t>(count);
  }
  return true;
}

}  // namespace

Result<MappedFile> MappedFile::open(const std::string& path, uint64_t limit) {
  // Not blocking: opening a pipe that nobody writes to must not wait for ever.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.fd < 0 && (errno == ENOENT || errno == ENOTDIR)) {
    return failure(path, "does not exist", "check the path");
  }
  struct stat status = {};
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) {
    return failure(path, std::string("cannot be opened: ") + std::strerror(errno), "");
  }
  if (!S_ISREG(status.st_mode)) return failure(path, "is not a regular file", "give a file");
  const uint64_t size = static_cast<uint64_t>(status.st_size);
  if (size > limit) {
    return failure(path,
                   "has " + std::to_string(size) + " bytes, but at most " + std::to_string(limit) +
                       " are allowed",
                   "raise the memory limit or use a smaller file");
  }
  MappedFile result;
  if (size == 0) return result;
  void* const mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (mapped != MAP_FAILED) {
    result.mapped_ = mapped;
    result.bytes_ = {static_cast<const uint8_t*>(mapped), size};
    return result;
  }
  result.read_.resize(size);
  if (!read_all(file.fd, result.read_)) {
    return failure(path, "shrank while it was read", "try again");
  }
  result.bytes_ = result.read_;
  return result;
}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  std::swap(mapped_, other.mapped_);
  std::swap(read_, other.read_);
  return *this;
}

MappedFile::~MappedFile() {
  if (mapped_ != nullptr) ::munmap(mapped_, bytes_.size());
}

}  // namespace sinew
