// CHECK and DCHECK: programmer errors end the process with the place and the broken condition.
// Nothing a user or a file can do may reach them; those are Result's business (error.h).
#pragma once

namespace sinew {
[[noreturn]] void check_failed(const char* condition, const char* file, int line);
}

#define SINEW_CHECK(condition) \
  ((condition) ? (void)0 : ::sinew::check_failed(#condition, __FILE__, __LINE__))
#ifdef NDEBUG
#define SINEW_DCHECK(condition) ((void)0)
#else
#define SINEW_DCHECK(condition) SINEW_CHECK(condition)
#endif
