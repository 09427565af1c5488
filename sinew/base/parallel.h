// The one door to threads (oneTBB behind it). Work runs in the caller's arena, so it respects a
// host's task_arena, CPU affinity and cgroup limits.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace sinew {

// A view of a callable `void(size_t begin, size_t end)`; no allocation, no ownership.
class RangeFunction {
 public:
  template <class F>
  RangeFunction(const F& function)
      : context_(&function), call_([](const void* context, size_t begin, size_t end) {
          (*static_cast<const F*>(context))(begin, end);
        }) {}
  void operator()(size_t begin, size_t end) const { call_(context_, begin, end); }

 private:
  const void* context_;
  void (*call_)(const void*, size_t, size_t);
};

// Calls body(begin, end) over [0, count) in chunks of exactly `grain` items (the last may be
// smaller). Chunk boundaries do not depend on the thread count, so per-chunk results are
// deterministic.
void parallel_for(size_t count, size_t grain, RangeFunction body);

// Runs both, in parallel if a thread is free.
void parallel_invoke_impl(RangeFunction a, RangeFunction b);
template <class A, class B>
void parallel_invoke(const A& a, const B& b) {
  const auto call_a = [&](size_t, size_t) { a(); };
  const auto call_b = [&](size_t, size_t) { b(); };
  parallel_invoke_impl(RangeFunction(call_a), RangeFunction(call_b));
}

// How many threads parallel_for may use now.
int thread_count();

// While it lives, at most `threads` threads work for the whole process (0: no limit).
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
