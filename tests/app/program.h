// Runs the program as a user does, and keeps what it says.
#pragma once

#include <sys/types.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "io/hostile.h"  // TemporaryFolder, slurp

namespace sinew {

struct Outcome {
  int exit_code = -1;  // 1000 + signal if a signal ended it
  std::string out;
  std::string err;
};

// A running `sinew`; its output goes to files, so no pipe can fill up.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);
  // Uses `out_path` as standard output.
  Program(const std::vector<std::string>& arguments, const std::string& out_path);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void send(int signal) const;
  std::string err_so_far() const { return slurp(folder_.path("err")); }
  Outcome wait();

 private:
  TemporaryFolder folder_;
  std::string out_path_;
  pid_t process_ = -1;
};

Outcome run_sinew(const std::vector<std::string>& arguments);

// A tetrahedron with corners at 0 and at `size` on each axis.
std::string small_obj(float size = 1.0f);

}  // namespace sinew
