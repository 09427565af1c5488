// Atomic writing and checked reading of whole files, with POSIX calls (whose error numbers tell
// what a user can do). The temporary file is made by open(2), so the umask decides about its
// permissions, as for any new file.
#include "sinew/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <vector>

#include "sinew/base/check.h"

namespace sinew {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return fd_; }
  // 0 or the error number; some file systems report a full disk only here.
  int close() {
    const int fd = std::exchange(fd_, -1);
    return fd >= 0 && ::close(fd) != 0 ? errno : 0;
  }

 private:
  int fd_;
};

tl::unexpected<Error> output_error(const std::string& path, int error_number) {
  Error error{ErrorKind::output, path, "", "cannot be written: ", ""};
  switch (error_number) {
    case ENOENT:
      error.problem += "its folder does not exist";
      error.remedy = "make the folder first";
      break;
    case ENOTDIR:
      error.problem += "a part of its path is a file, not a folder";
      error.remedy = "give another path";
      break;
    case EISDIR:
      error.problem += "it is a folder";
      error.remedy = "give the name of a file in it";
      break;
    case EACCES:
    case EPERM:
    case EROFS:
      error.problem += "no permission";
      error.remedy = "choose a folder you may write to";
      break;
    case EFBIG:
      error.problem += "it would be larger than files may be here";
      error.remedy = "raise the limit (ulimit -f) or choose another disk";
      break;
    case ENOSPC:
    case EDQUOT:
      error.problem += "the disk is full";
      error.remedy = "free some space or choose another disk";
      break;
    default:
      error.problem += std::strerror(error_number);
      error.remedy = "give another path";
  }
  return fail(std::move(error));
}

// 0 or the error number.
int write_all(int fd, std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return 0;
}

struct Target {
  std::filesystem::path path;  // links followed, so that renaming replaces the file, not the link
  bool special = false;        // a device or pipe: it is written to, never replaced
};

Result<Target> find_target(const std::string& path) {
  if (path.empty()) {
    return fail({ErrorKind::output, "", "", "the output has no name", "give a file name"});
  }
  std::error_code ignored;
  Target target{std::filesystem::weakly_canonical(path, ignored)};
  if (ignored || path.back() == '/') target.path = path;
  struct stat status {};
  if (::stat(target.path.c_str(), &status) != 0) {
    if (errno != ENOENT) return output_error(path, errno);
    if (path.back() == '/') return output_error(path, EISDIR);
    return target;
  }
  if (S_ISDIR(status.st_mode)) return output_error(path, EISDIR);
  target.special = !S_ISREG(status.st_mode);
  return target;
}

// Makes a new file beside `target` and opens it; -1 and errno if that fails.
int open_temporary(const std::filesystem::path& target, std::filesystem::path& name) {
  static std::atomic<uint32_t> counter{0};
  for (int attempt = 0; attempt < 1000; ++attempt) {
    name = target.parent_path() / (".sinew-" + std::to_string(::getpid()) + "-" +
                                   std::to_string(counter.fetch_add(1)) + ".tmp");
    const int fd = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::string& path) {
  OutputFile file;
  file.path_ = path;
  if (path == "-") {
    file.fd_ = STDOUT_FILENO;
    file.path_ = "standard output";
    return file;
  }
  SINEW_TRY(const Target target, find_target(path));
  file.owns_fd_ = true;
  if (target.special) {
    file.fd_ = ::open(target.path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file.fd_ < 0) return output_error(path, errno);
    return file;
  }
  std::filesystem::path temporary;
  file.fd_ = open_temporary(target.path, temporary);
  if (file.fd_ < 0) return output_error(path, errno);
  file.target_ = target.path.string();
  file.temporary_ = temporary.string();
  return file;
}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(target_, other.target_);
  std::swap(temporary_, other.temporary_);
  std::swap(fd_, other.fd_);
  std::swap(owns_fd_, other.owns_fd_);
  std::swap(size_, other.size_);
  return *this;
}

OutputFile::~OutputFile() {
  if (owns_fd_) Descriptor(std::exchange(fd_, -1)).close();
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<void> OutputFile::write(std::span<const uint8_t> bytes) {
  SINEW_CHECK(fd_ >= 0);
  if (const int problem = write_all(fd_, bytes); problem != 0) return output_error(path_, problem);
  size_ += bytes.size();
  return {};
}

Result<void> OutputFile::close() {
  if (!owns_fd_) return {};
  const int problem = Descriptor(std::exchange(fd_, -1)).close();
  if (problem != 0) return output_error(path_, problem);
  return {};
}

Result<void> OutputFile::publish() {
  SINEW_CHECKED(close());
  if (temporary_.empty()) return {};
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) return output_error(path_, errno);
  temporary_.clear();
  return {};
}

Result<SpoolFile> SpoolFile::create(const std::string& path) {
  std::filesystem::path beside;
  bool is_special = path == "-";
  if (!is_special) {
    SINEW_TRY(const Target target, find_target(path));
    beside = target.path;
    is_special = target.special;
  }
  if (is_special) {
    std::error_code ignored;
    beside = std::filesystem::temp_directory_path(ignored) / "spool";
  }
  SpoolFile file;
  file.path_ = path == "-" ? "standard output" : path;
  std::filesystem::path name;
  file.fd_ = open_temporary(beside, name);
  if (file.fd_ < 0) return output_error(file.path_, errno);
  ::unlink(name.c_str());
  return file;
}

SpoolFile& SpoolFile::operator=(SpoolFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  std::swap(size_, other.size_);
  return *this;
}

SpoolFile::~SpoolFile() {
  if (fd_ >= 0) Descriptor(std::exchange(fd_, -1)).close();
}

Result<void> SpoolFile::write(std::span<const uint8_t> bytes) {
  SINEW_CHECK(fd_ >= 0);
  if (const int problem = write_all(fd_, bytes); problem != 0) return output_error(path_, problem);
  size_ += bytes.size();
  return {};
}

Result<void> SpoolFile::copy_to(OutputFile& file) const {
  std::vector<uint8_t> buffer(1 << 20);
  for (uint64_t at = 0; at < size_;) {
    const size_t wanted = static_cast<size_t>(std::min<uint64_t>(buffer.size(), size_ - at));
    const ssize_t count = ::pread(fd_, buffer.data(), wanted, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return output_error(path_, count < 0 ? errno : EIO);
    SINEW_CHECKED(file.write({buffer.data(), static_cast<size_t>(count)}));
    at += static_cast<uint64_t>(count);
  }
  return {};
}

Result<void> write_file(const std::string& path, std::span<const uint8_t> bytes) {
  SINEW_TRY(OutputFile file, OutputFile::create(path));
  SINEW_CHECKED(file.write(bytes));
  return file.publish();
}

Result<void> write_file(const std::string& path, std::string_view text) {
  return write_file(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Result<void> check_writable(const std::string& path) {
  if (path == "-") return {};
  SINEW_TRY(const Target target, find_target(path));
  if (target.special) {
    if (::access(target.path.c_str(), W_OK) != 0) return output_error(path, errno);
    return {};
  }
  std::filesystem::path temporary;
  const Descriptor file(open_temporary(target.path, temporary));
  if (file.get() < 0) return output_error(path, errno);
  ::unlink(temporary.c_str());
  return {};
}

Result<std::string> read_file(const std::string& path, uint64_t limit) {
  const auto failure = [&](std::string problem, std::string remedy) {
    return fail({ErrorKind::bad_input, path, "", std::move(problem), std::move(remedy)});
  };
  // Not blocking: opening a pipe that nobody writes to must not wait for ever.
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0 && (errno == ENOENT || errno == ENOTDIR)) {
    return failure("does not exist", "check the path");
  }
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) {
    return failure(std::string("cannot be opened: ") + std::strerror(errno), "");
  }
  if (!S_ISREG(status.st_mode)) return failure("is not a regular file", "give a file");
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size > limit) {
    return failure("has " + std::to_string(size) + " bytes, but at most " + std::to_string(limit) +
                       " are allowed",
                   "raise the memory limit or use a smaller file");
  }
  std::string bytes;
  try {
    bytes.resize(size);
  } catch (const std::bad_alloc&) {
    return failure("is too large for this machine's memory", "");
  }
  size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t count = ::read(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(std::string("cannot be read: ") + std::strerror(errno), "");
    if (count == 0) return failure("shrank while it was read", "try again");
    filled += static_cast<size_t>(count);
  }
  return bytes;
}

}  // namespace sinew
