// A program that this one starts, feeds and waits for. Internal to sinew/io.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"

namespace sinew {

// Found on the PATH, started without a shell, in a process group of its own, so that a Ctrl-C meant
// for us does not end it first. Destroyed while it runs, it is killed.
class ChildProcess {
 public:
  // words[0] is the program. An Error with ErrorKind::runtime if it cannot be started.
  static Result<ChildProcess> start(const std::vector<std::string>& words);
  ChildProcess(ChildProcess&&) noexcept;
  ChildProcess& operator=(ChildProcess&&) noexcept;
  ~ChildProcess();

  // To its standard input, in turn; false if it no longer reads.
  bool write(std::span<const uint8_t> bytes);
  // Ends its input and waits for it: the exit code, or 128 + the signal that ended it. The same
  // again if it is called again.
  int wait();
  // What it has written to its standard output and error, at most the first 64 KiB.
  std::string output() const;

 private:
  struct Impl;
  explicit ChildProcess(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
