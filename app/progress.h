// Progress and messages, all on standard error. On a terminal: one line that is rewritten, with the
// time left. As JSON on request: one object a line. Otherwise silent.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace sinew::app {

void print_error(const std::string& message);
void print_warnings(const std::vector<std::string>& warnings);
void print_note(const std::string& message);

enum class ProgressMode { automatic, json, none };

class Progress {
 public:
  Progress(ProgressMode mode, size_t frames);
  ~Progress();  // takes the line away
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void frame_done(int frame, double frame_ms);
  void clear();
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool json_ = false;
  bool terminal_ = false;
  size_t frames_ = 0;
  size_t done_ = 0;
  Clock::time_point start_ = Clock::now();
};

// A line on a terminal that says what is being done, for work without frames.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine();  // takes the line away
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void show(const std::string& text);

 private:
  bool terminal_ = false;
  bool shown_ = false;
};

// "8.4 s", "2 min 5 s", "1 h 12 min"
std::string format_duration(double seconds);

}  // namespace sinew::app
