#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace sinew::app {
namespace {

// One write, so that lines of several processes do not mix.
void write_stderr(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

void print_error(const std::string& message) {
  write_stderr("sinew: " + message + "\n");
}

void print_warnings(const std::vector<std::string>& warnings) {
  constexpr size_t kShown = 20;
  std::string text;
  for (size_t i = 0; i < warnings.size() && i < kShown; ++i) {
    text += "sinew: warning: " + warnings[i] + "\n";
  }
  if (warnings.size() > kShown) {
    text += fmt::format("sinew: warning: ... and {} more (`sinew info` lists all)\n",
                        warnings.size() - kShown);
  }
  if (!text.empty()) write_stderr(text);
}

void print_note(const std::string& message) {
  write_stderr(message + "\n");
}

std::string format_duration(double seconds) {
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const long whole = std::lround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(ProgressMode mode, size_t frames)
    : json_(mode == ProgressMode::json),
      terminal_(mode == ProgressMode::automatic && isatty(STDERR_FILENO) == 1),
      frames_(frames) {}

Progress::~Progress() {
  clear();
}

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Progress::frame_done(int frame, double frame_ms) {
  ++done_;
  const double elapsed = elapsed_s();
  const double left = elapsed / static_cast<double>(done_) * static_cast<double>(frames_ - done_);
  if (json_) {
    write_stderr(
        fmt::format("{{\"frame\": {}, \"done\": {}, \"of\": {}, \"frame_ms\": {:.3f}, "
                    "\"elapsed_s\": {:.3f}, \"eta_s\": {:.3f}}}\n",
                    frame, done_, frames_, frame_ms, elapsed, left));
  } else if (terminal_) {
    write_stderr(fmt::format("\r\033[Kframe {} ({} of {}), {:.0f} ms a frame, {} left", frame,
                             done_, frames_, frame_ms, format_duration(left)));
  }
}

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

StatusLine::~StatusLine() {
  if (shown_) write_stderr("\r\033[K");
}

void StatusLine::show(const std::string& text) {
  if (!terminal_) return;
  shown_ = true;
  write_stderr("\r\033[K" + text);
}

void Progress::clear() {
  if (terminal_ && done_ > 0) write_stderr("\r\033[K");
}

}  // namespace sinew::app
