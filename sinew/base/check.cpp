#include "sinew/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace sinew {

void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: sinew bug: CHECK(%s) failed\n", file, line, condition);
  std::abort();
}

}  // namespace sinew
