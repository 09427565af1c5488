#include "sinew/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <thread>
#include <vector>
#endif

namespace sinew {
namespace {

#ifdef __SANITIZE_THREAD__
// libtbb itself is not built for ThreadSanitizer, which then cannot see that its joins order
// anything and reports every result as a race. Plain threads stand in for it there; chunks that run
// at the same time stay unordered, so real races are found.
void for_each_chunk(size_t chunks, const auto& run) {
  static std::atomic<int> helpers_alive{0};
  const int limit = thread_count() - 1;
  std::atomic<size_t> next{0};
  const auto work = [&] {
    for (size_t chunk; (chunk = next.fetch_add(1, std::memory_order_relaxed)) < chunks;) run(chunk);
  };
  std::vector<std::thread> helpers;
  while (helpers.size() + 1 < chunks) {
    if (helpers_alive.fetch_add(1, std::memory_order_relaxed) >= limit) {
      helpers_alive.fetch_sub(1, std::memory_order_relaxed);
      break;
    }
    helpers.emplace_back(work);
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  helpers_alive.fetch_sub(static_cast<int>(helpers.size()), std::memory_order_relaxed);
}
#else
void for_each_chunk(size_t chunks, const auto& run) {
  tbb::parallel_for(size_t{0}, chunks, run);
}
#endif

}  // namespace

void parallel_for(size_t count, size_t grain, RangeFunction body) {
  if (count == 0) return;
  grain = std::max<size_t>(grain, 1);
  const size_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) return body(0, count);
  for_each_chunk(chunks,
                 [&](size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); });
}

void parallel_invoke_impl(RangeFunction a, RangeFunction b) {
#ifdef __SANITIZE_THREAD__
  for_each_chunk(2, [&](size_t which) { which == 0 ? a(0, 0) : b(0, 0); });
#else
  tbb::parallel_invoke([&] { a(0, 0); }, [&] { b(0, 0); });
#endif
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
