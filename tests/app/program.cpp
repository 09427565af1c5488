#include "app/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sinew {
namespace {

pid_t start(const std::vector<std::string>& arguments, const std::string& out_path,
            const std::string& err_path) {
  std::vector<std::string> words = {SINEW_BINARY};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int in = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int out = open(out_path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  const int err = open(err_path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  const pid_t process = fork();
  if (process == 0) {
    dup2(in, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  for (const int descriptor : {in, out, err}) close(descriptor);
  return process;
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments) : out_path_(folder_.path("out")) {
  process_ = start(arguments, out_path_, folder_.path("err"));
}

Program::Program(const std::vector<std::string>& arguments, const std::string& out_path)
    : out_path_(out_path) {
  process_ = start(arguments, out_path_, folder_.path("err"));
}

Program::~Program() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

void Program::send(int signal) const {
  kill(process_, signal);
}

Outcome Program::wait() {
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  if (std::filesystem::is_regular_file(out_path_)) outcome.out = slurp(out_path_);
  outcome.err = err_so_far();
  return outcome;
}

Outcome run_sinew(const std::vector<std::string>& arguments) {
  return Program(arguments).wait();
}

std::string small_obj(float size) {
  return fmt::format(
      "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\n"
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
      size);
}

}  // namespace sinew
