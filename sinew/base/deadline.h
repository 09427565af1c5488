// A moment after which work that can be left out is left out.
#pragma once

#include <chrono>
#include <optional>

namespace sinew {

class Deadline {
 public:
  Deadline() = default;  // never
  static Deadline after_ms(double ms) {
    Deadline out;
    out.moment_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double, std::milli>(ms));
    return out;
  }

  bool is_set() const { return moment_.has_value(); }
  bool passed() const { return moment_ && Clock::now() >= *moment_; }

 private:
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> moment_;
};

}  // namespace sinew
