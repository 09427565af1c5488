// posix_spawnp. Input goes through a socket pair rather than a pipe, because writing to a socket
// whose other end is closed can be told to raise no SIGPIPE. Output goes to an unnamed temporary
// file, so the child never waits for us to read.
#include "sinew/io/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

extern char** environ;

namespace sinew {
namespace {

constexpr size_t kMostOutput = 64 * 1024;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// How the child differs from us: its streams, no blocked or ignored signals, its own group.
class SpawnSettings {
 public:
  SpawnSettings(int input, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  // 0 or the error number.
  int spawn(const std::vector<std::string>& words, pid_t& process) const {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    return posix_spawnp(&process, arguments[0], &actions_, &attributes_, arguments.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

}  // namespace

struct ChildProcess::Impl {
  pid_t process = -1;
  int input = -1;  // our end
  int result = 0;  // once it has been waited for
  std::unique_ptr<std::FILE, FileCloser> output;

  ~Impl() {
    if (input >= 0) ::close(input);
    if (process < 0) return;
    ::kill(process, SIGKILL);
    wait_for_end();
  }
  int wait_for_end() {
    if (process < 0) return result;
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    process = -1;
    result = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result;
  }
};

ChildProcess::ChildProcess(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ChildProcess::ChildProcess(ChildProcess&&) noexcept = default;
ChildProcess& ChildProcess::operator=(ChildProcess&&) noexcept = default;
ChildProcess::~ChildProcess() = default;

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words) {
  const auto failure = [&](int number) {
    const std::string why =
        number == ENOENT ? "it is not on the PATH" : std::string(std::strerror(number));
    return fail({ErrorKind::runtime, "", "",
                 "the program " + words[0] + " cannot be started: " + why, "install it"});
  };
  auto impl = std::make_unique<Impl>();
  impl->output.reset(std::tmpfile());
  if (!impl->output) return failure(errno);
  const int output = ::fileno(impl->output.get());
  ::fcntl(output, F_SETFD, FD_CLOEXEC);
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return failure(errno);
  }
  impl->input = ends[0];
  const int problem = SpawnSettings(ends[1], output).spawn(words, impl->process);
  ::close(ends[1]);
  if (problem != 0) {
    impl->process = -1;
    return failure(problem);
  }
  return ChildProcess(std::move(impl));
}

bool ChildProcess::write(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(impl_->input, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(sent));
  }
  return true;
}

int ChildProcess::wait() {
  if (impl_->input >= 0) ::close(impl_->input);
  impl_->input = -1;
  return impl_->wait_for_end();
}

std::string ChildProcess::output() const {
  std::string text(kMostOutput, '\0');
  const ssize_t size = ::pread(::fileno(impl_->output.get()), text.data(), text.size(), 0);
  text.resize(size > 0 ? static_cast<size_t>(size) : 0);
  return text;
}

}  // namespace sinew
