#include "sinew/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace sinew {

void parallel_for(size_t count, size_t grain, RangeFunction body) {
  if (count == 0) return;
  grain = std::max<size_t>(grain, 1);
  const size_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) return body(0, count);
  tbb::parallel_for(size_t{0}, chunks, [&](size_t chunk) {
    body(chunk * grain, std::min(count, (chunk + 1) * grain));
  });
}

void parallel_invoke_impl(RangeFunction a, RangeFunction b) {
  tbb::parallel_invoke([&] { a(0, 0); }, [&] { b(0, 0); });
}

int thread_count() {
  const size_t limit =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(
      std::min<size_t>(limit, static_cast<size_t>(tbb::this_task_arena::max_concurrency())));
}

struct ThreadLimit::Impl {
  tbb::global_control control;
  explicit Impl(size_t threads) : control(tbb::global_control::max_allowed_parallelism, threads) {}
};

ThreadLimit::ThreadLimit(int threads) {
  if (threads > 0) impl_ = std::make_unique<Impl>(static_cast<size_t>(threads));
}
ThreadLimit::~ThreadLimit() = default;

}  // namespace sinew
