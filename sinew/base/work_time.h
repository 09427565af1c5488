// WorkTime: nanoseconds that threads spent on something, summed over them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace sinew {

class WorkTime {
 public:
  void reset() { ns_.store(0, std::memory_order_relaxed); }
  double ns() const { return static_cast<double>(ns_.load(std::memory_order_relaxed)); }

  // Adds the time from its construction to its destruction.
  class Part {
   public:
    explicit Part(WorkTime& sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
    ~Part() {
      const auto spent = std::chrono::steady_clock::now() - start_;
      const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count();
      sum_.ns_.fetch_add(static_cast<uint64_t>(ns), std::memory_order_relaxed);
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    WorkTime& sum_;
    std::chrono::steady_clock::time_point start_;
  };

 private:
  std::atomic<uint64_t> ns_ = 0;
};

}  // namespace sinew
