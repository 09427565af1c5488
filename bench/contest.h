// A contest: rivals do the same work in turn, frame by frame, so that noise hits all of them; what
// counts is the median of each.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sinew::bench {

struct Rival {
  std::string name;
  std::function<void(uint32_t frame)> run;  // what is timed
  std::vector<double> ms = {};              // one a repeat
  // What `run` may write: how much of it was spent on the pose. One a round, warmups included.
  std::vector<double> pose_ms = {};

  double median_ms() const;
};

struct Rounds {
  uint32_t warmups = 2;  // not counted
  uint32_t repeats = 7;
};

// Every round is a new frame: `prepare(frame)` is not timed, then every rival runs it. Who begins
// changes from round to round. Frames count on from `first_frame`; the next free one is returned.
uint32_t compete(std::span<Rival> rivals, const Rounds& rounds, uint32_t first_frame,
                 const std::function<void(uint32_t frame)>& prepare = {});

// The least median among the rivals whose name begins with `prefix`; nullptr if there is none.
const Rival* best_of(std::span<const Rival> rivals, std::string_view prefix);
const Rival* find(std::span<const Rival> rivals, std::string_view name);

}  // namespace sinew::bench
