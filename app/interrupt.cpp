#include "app/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <mutex>
#include <thread>

namespace sinew::app {
namespace {

struct State {
  std::mutex mutex;
  std::function<void()> clean_up;
};

// Never destroyed: the waiting thread may still look at it while the program ends.
State& state() {
  static State* const shared = new State;
  return *shared;
}

void wait_and_leave(sigset_t signals) {
  int signal_number = 0;
  if (sigwait(&signals, &signal_number) != 0) return;
  // A second signal, from someone who does not want to wait, takes its default action.
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  state().mutex.lock();
  if (state().clean_up) state().clean_up();
  _exit(128 + signal_number);
}

}  // namespace

void watch_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals, number);  // nohup stays in force
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A reader that closed its end of a pipe is an output error, not a silent death.
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // writing too large a file is an error like others
  std::thread(wait_and_leave, signals).detach();
}

Uninterrupted::Uninterrupted() {
  state().mutex.lock();
}
Uninterrupted::~Uninterrupted() {
  state().mutex.unlock();
}

OnInterrupt::OnInterrupt(std::function<void()> clean_up) {
  const std::lock_guard lock(state().mutex);
  state().clean_up = std::move(clean_up);
}
OnInterrupt::~OnInterrupt() {
  const std::lock_guard lock(state().mutex);
  state().clean_up = nullptr;
}

}  // namespace sinew::app
