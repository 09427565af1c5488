// Ctrl-C and SIGTERM end the program at once, even in the middle of a long frame, yet cleanly:
// never while a file is being written, and not before unfinished files are gone.
//
// One thread waits for the signals, which all other threads block. When one comes it waits until
// no Uninterrupted lives, runs the clean-up that stands registered, and leaves with 128 + signal.
#pragma once

#include <functional>

namespace sinew::app {

// Call first in main: threads started before it would still take the signals.
void watch_signals();

// While it lives, no signal ends the program. Not to be nested.
class Uninterrupted {
 public:
  Uninterrupted();
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;
};

// While it lives, `clean_up` runs before a signal ends the program. One at a time.
class OnInterrupt {
 public:
  explicit OnInterrupt(std::function<void()> clean_up);
  ~OnInterrupt();
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;
};

}  // namespace sinew::app
