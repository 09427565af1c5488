#include "sinew/bvh/frames/frame_choice.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

constexpr uint32_t kMostCandidates = 96;  // frames between which distances are measured
constexpr uint32_t kSample = 1024;        // primitives of the small trees
constexpr double kLeastGain = 1e-3;       // of another medoid, of the average cost
constexpr size_t kBuffers = 8;            // frames that are held at once while they are sampled

// By half the time to both neighbours within [first, last]; what does not rise counts nothing.
std::vector<double> time_around(std::span<const double> times, uint32_t first, uint32_t last) {
  std::vector<double> out(last - first + 1, 0.0);
  for (uint32_t f = first; f < last; ++f) {
    const double gap = times[f + 1] - times[f];
    const double half = std::isfinite(gap) ? std::max(0.5 * gap, 0.0) : 0.0;
    out[f - first] += half;
    out[f + 1 - first] += half;
  }
  return out;
}

// Gives the weights of frames that are bit for bit like an earlier one to that one, and drops them.
void merge_equal(const AnimatedBoxes& animation, std::vector<uint32_t>& frames,
                 std::vector<double>& weights) {
  std::vector<std::vector<Box>> kept;
  size_t count = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    std::vector<Box> boxes(animation.primitive_count);
    animation.boxes(frames[f], boxes);
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const std::vector<Box>& other) {
      return boxes.empty() ||
             std::memcmp(other.data(), boxes.data(), boxes.size() * sizeof(Box)) == 0;
    });
    if (same != kept.end()) {
      weights[static_cast<size_t>(same - kept.begin())] += weights[f];
      continue;
    }
    frames[count] = frames[f];
    weights[count] = weights[f];
    ++count;
    kept.push_back(std::move(boxes));
  }
  frames.resize(count);
  weights.resize(count);
}

// costs[m * n + f]: what frame f costs in the tree of frame m, never less than in its own.
std::vector<double> cost_matrix(const FrameBoxes& frames) {
  const size_t n = frames.frame_count();
  std::vector<Tree> trees(n);
  std::vector<double> costs(n * n);
  parallel_for(n, 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) trees[f] = build_binned(frames.frames[f], {.max_leaf = 1});
  });
  parallel_for(n, 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      const double own = sah_cost(trees[f], refit(trees[f], frames.frames[f]));
      for (size_t m = 0; m < n; ++m) {
        const double there = m == f ? own : sah_cost(trees[m], refit(trees[m], frames.frames[f]));
        costs[m * n + f] = std::max(there, own);
      }
    }
  });
  return costs;
}

// k-medoids by PAM: greedy BUILD, then SWAPs while one helps. The k are few, the frames at most
// kMostCandidates, so every swap is tried.
class Medoids {
 public:
  Medoids(std::vector<double> costs, std::vector<double> weights, std::vector<uint8_t> eligible)
      : costs_(std::move(costs)), weights_(std::move(weights)), eligible_(std::move(eligible)) {}

  std::vector<uint32_t> run(uint32_t count) {
    for (double total = 0.0; chosen_.size() < count;) {
      const Change best = best_addition();
      if (!best.found) break;
      if (!chosen_.empty() && total - best.total <= kLeastGain * total) break;
      chosen_.push_back(best.frame);
      total = best.total;
    }
    while (swap_once()) {
    }
    std::sort(chosen_.begin(), chosen_.end());
    return chosen_;
  }

  // Which of the chosen serves the frame best.
  size_t nearest(size_t frame) const {
    size_t best = 0;
    for (size_t i = 1; i < chosen_.size(); ++i) {
      if (cost(chosen_[i], frame) < cost(chosen_[best], frame)) best = i;
    }
    return best;
  }

 private:
  struct Change {
    bool found = false;
    uint32_t frame = 0;
    double total = 0.0;
  };

  double cost(size_t medoid, size_t frame) const {
    return costs_[medoid * weights_.size() + frame];
  }

  // What every frame costs in the best tree of the chosen ones, without one of them.
  std::vector<double> costs_without(std::optional<size_t> left_out) const {
    std::vector<double> out(weights_.size(), std::numeric_limits<double>::infinity());
    for (size_t i = 0; i < chosen_.size(); ++i) {
      if (left_out == i) continue;
      for (size_t f = 0; f < out.size(); ++f) out[f] = std::min(out[f], cost(chosen_[i], f));
    }
    return out;
  }

  Change best_added_to(std::span<const double> costs) const {
    Change best;
    for (uint32_t m = 0; m < weights_.size(); ++m) {
      if (!eligible_[m] || std::find(chosen_.begin(), chosen_.end(), m) != chosen_.end()) continue;
      double total = 0.0;
      for (size_t f = 0; f < costs.size(); ++f) {
        total += weights_[f] * std::min(costs[f], cost(m, f));
      }
      if (!best.found || total < best.total) best = {true, m, total};
    }
    return best;
  }

  Change best_addition() const { return best_added_to(costs_without(std::nullopt)); }

  bool swap_once() {
    const std::vector<double> now = costs_without(std::nullopt);
    double total = 0.0;
    for (size_t f = 0; f < now.size(); ++f) total += weights_[f] * now[f];
    Change best;
    size_t out = 0;
    for (size_t i = 0; i < chosen_.size(); ++i) {
      const Change change = best_added_to(costs_without(i));
      if (change.found && (!best.found || change.total < best.total)) {
        best = change;
        out = i;
      }
    }
    // Rounding must not let two swaps undo each other for ever.
    if (!best.found || !(best.total < total * (1.0 - 1e-9))) return false;
    chosen_[out] = best.frame;
    return true;
  }

  std::vector<double> costs_;
  std::vector<double> weights_;
  std::vector<uint8_t> eligible_;
  std::vector<uint32_t> chosen_;
};

// Whether a frame may be a medoid: where nearly as many boxes are finite as in the best one.
std::vector<uint8_t> eligible_frames(std::span<const uint32_t> finite_boxes) {
  const uint32_t most = *std::max_element(finite_boxes.begin(), finite_boxes.end());
  std::vector<uint8_t> out(finite_boxes.size());
  for (size_t f = 0; f < out.size(); ++f) out[f] = finite_boxes[f] >= most - most / 100;
  return out;
}

std::vector<uint32_t> choose_medoids(const AnimatedBoxes& animation, uint32_t first, uint32_t last,
                                     uint32_t count, std::span<const double> all_weights,
                                     std::vector<double>& weights) {
  const std::vector<uint32_t> candidates = evenly_spread(first, last, kMostCandidates);
  std::vector<uint32_t> finite_boxes;
  const FrameBoxes boxes = sample_boxes(
      animation, candidates, sample_primitives(animation.primitive_count, kSample), &finite_boxes);
  const std::vector<double> shares = weights_by_nearness(candidates, first, all_weights);
  Medoids medoids(cost_matrix(boxes), shares, eligible_frames(finite_boxes));
  std::vector<uint32_t> chosen = medoids.run(count);
  weights.assign(chosen.size(), 0.0);
  for (size_t f = 0; f < candidates.size(); ++f) weights[medoids.nearest(f)] += shares[f];
  for (uint32_t& frame : chosen) frame = candidates[frame];
  return chosen;
}

void normalize_sum(std::vector<double>& values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  for (double& value : values) value /= sum;
}

}  // namespace

AnimatedBoxes join_clips(std::vector<AnimatedBoxes> clips) {
  AnimatedBoxes joined;
  std::vector<uint32_t> begins;
  double weight_sum = 0.0;
  size_t weighted_frames = 0;
  std::vector<std::pair<size_t, size_t>> without_length;
  for (const AnimatedBoxes& clip : clips) {
    SINEW_CHECK(clip.primitive_count == clips.front().primitive_count);
    begins.push_back(joined.frame_count());
    if (clip.frame_count() == 0) continue;
    const std::vector<double> weights =
        clip.weights.empty() ? time_around(clip.times, 0, clip.frame_count() - 1) : clip.weights;
    SINEW_CHECK(weights.size() == clip.times.size());
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (sum > 0.0) {
      weight_sum += sum;
      weighted_frames += weights.size();
    } else {
      without_length.emplace_back(joined.times.size(), joined.times.size() + weights.size());
    }
    joined.times.insert(joined.times.end(), clip.times.begin(), clip.times.end());
    joined.weights.insert(joined.weights.end(), weights.begin(), weights.end());
  }
  const double average =
      weighted_frames > 0 ? weight_sum / static_cast<double>(weighted_frames) : 1.0;
  for (const auto& [begin, end] : without_length) {
    std::fill(joined.weights.begin() + static_cast<ptrdiff_t>(begin),
              joined.weights.begin() + static_cast<ptrdiff_t>(end), average);
  }
  joined.primitive_count = clips.empty() ? 0 : clips.front().primitive_count;
  joined.boxes = [clips = std::move(clips), begins](uint32_t frame, std::span<Box> out) {
    const auto clip = std::upper_bound(begins.begin(), begins.end(), frame) - begins.begin() - 1;
    const auto index = static_cast<size_t>(clip);
    clips[index].boxes(frame - begins[index], out);
  };
  return joined;
}

std::vector<double> frame_weights(const AnimatedBoxes& animation, uint32_t first, uint32_t last) {
  SINEW_CHECK(first <= last && last < animation.frame_count());
  SINEW_CHECK(animation.weights.empty() || animation.weights.size() == animation.times.size());
  std::vector<double> weights = animation.weights.empty()
                                    ? time_around(animation.times, first, last)
                                    : std::vector<double>(animation.weights.begin() + first,
                                                          animation.weights.begin() + last + 1);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(sum > 0.0) || !std::isfinite(sum)) std::fill(weights.begin(), weights.end(), 1.0);
  normalize_sum(weights);
  return weights;
}

std::vector<double> weights_by_nearness(std::span<const uint32_t> chosen, uint32_t first,
                                        std::span<const double> weights) {
  std::vector<double> out(chosen.size(), 0.0);
  size_t next = 0;  // the first chosen frame that is not before `frame`
  for (uint32_t i = 0; i < weights.size(); ++i) {
    const uint32_t frame = first + i;
    while (next < chosen.size() && chosen[next] < frame) ++next;
    if (next == 0 || next == chosen.size()) {
      out[next == 0 ? 0 : next - 1] += weights[i];
      continue;
    }
    const uint32_t before = frame - chosen[next - 1], after = chosen[next] - frame;
    const double share = before < after ? 0.0 : before > after ? 1.0 : 0.5;
    out[next] += share * weights[i];
    out[next - 1] += (1.0 - share) * weights[i];
  }
  return out;
}

std::vector<uint32_t> evenly_spread(uint32_t first, uint32_t last, uint32_t count) {
  SINEW_CHECK(first <= last && count > 0);
  const uint64_t gaps = last - first;
  std::vector<uint32_t> out;
  if (count > gaps) {
    for (uint32_t i = first; i <= last; ++i) out.push_back(i);
    return out;
  }
  if (count == 1) return {first + static_cast<uint32_t>(gaps / 2)};
  const uint64_t steps = count - 1;
  for (uint64_t i = 0; i <= steps; ++i) {
    out.push_back(first + static_cast<uint32_t>((2 * i * gaps + steps) / (2 * steps)));
  }
  return out;
}

std::vector<uint32_t> choose_frames(const AnimatedBoxes& animation, uint32_t first, uint32_t last,
                                    uint32_t count, FrameChoice choice,
                                    std::vector<double>* weights) {
  const std::vector<double> all_weights = frame_weights(animation, first, last);
  std::vector<double> chosen_weights;
  std::vector<uint32_t> chosen;
  if (choice == FrameChoice::medoids && last - first >= count) {
    chosen = choose_medoids(animation, first, last, count, all_weights, chosen_weights);
  } else {
    chosen = evenly_spread(first, last, count);
    chosen_weights = weights_by_nearness(chosen, first, all_weights);
    merge_equal(animation, chosen, chosen_weights);
  }
  normalize_sum(chosen_weights);
  if (weights) *weights = std::move(chosen_weights);
  return chosen;
}

FrameBoxes sample_frames(const AnimatedBoxes& animation, std::span<const uint32_t> frames,
                         std::span<const double> weights) {
  SINEW_CHECK(weights.size() == frames.size());
  std::vector<std::vector<Box>> boxes(frames.size());
  parallel_for(frames.size(), 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      boxes[f].resize(animation.primitive_count);
      animation.boxes(frames[f], boxes[f]);
    }
  });
  FrameBoxes out = make_frame_boxes(std::move(boxes));
  out.weights.assign(weights.begin(), weights.end());
  return out;
}

std::vector<uint32_t> sample_primitives(uint32_t primitive_count, uint32_t count) {
  std::vector<uint32_t> out(std::min(primitive_count, count));
  if (primitive_count <= count) {
    std::iota(out.begin(), out.end(), 0u);
    return out;
  }
  Random random(primitive_count);
  for (uint64_t i = 0; i < count; ++i) {
    const auto begin = static_cast<uint32_t>(i * primitive_count / count);
    const auto end = static_cast<uint32_t>((i + 1) * primitive_count / count);
    out[i] = begin + random.next() % (end - begin);
  }
  return out;
}

FrameBoxes sample_boxes(const AnimatedBoxes& animation, std::span<const uint32_t> frames,
                        std::span<const uint32_t> primitives, std::vector<uint32_t>* finite_boxes) {
  std::vector<std::vector<Box>> boxes(frames.size(), std::vector<Box>(primitives.size()));
  std::vector<uint32_t> finite(frames.size(), 0);
  const size_t grain = (frames.size() + kBuffers - 1) / kBuffers;
  parallel_for(frames.size(), std::max<size_t>(grain, 1), [&](size_t begin, size_t end) {
    std::vector<Box> all(animation.primitive_count);
    for (size_t f = begin; f < end; ++f) {
      animation.boxes(frames[f], all);
      for (const Box& box : all) finite[f] += is_there(box) ? 1 : 0;
      for (size_t p = 0; p < primitives.size(); ++p) boxes[f][p] = all[primitives[p]];
    }
  });
  if (finite_boxes) *finite_boxes = std::move(finite);
  return make_frame_boxes(std::move(boxes));
}

std::vector<Box> repaired_frame(const AnimatedBoxes& animation, uint32_t frame,
                                std::span<const uint32_t> representatives,
                                const FrameBoxes& representative_boxes) {
  SINEW_CHECK(!representatives.empty());
  const auto distance = [&](uint32_t other) {
    return other > frame ? other - frame : frame - other;
  };
  size_t nearest = 0;
  for (size_t i = 1; i < representatives.size(); ++i) {
    if (distance(representatives[i]) < distance(representatives[nearest])) nearest = i;
  }
  std::vector<Box> boxes(animation.primitive_count);
  animation.boxes(frame, boxes);
  for (size_t p = 0; p < boxes.size(); ++p) {
    if (!is_there(boxes[p])) boxes[p] = representative_boxes.frames[nearest][p];
  }
  return boxes;
}

HeldOutCost held_out_cost(const Tree& tree, const AnimatedBoxes& animation, uint32_t first,
                          uint32_t last, std::span<const uint32_t> representatives,
                          const FrameBoxes& representative_boxes, const CostModel& model,
                          uint32_t most) {
  SINEW_CHECK(representatives.size() == representative_boxes.frames.size());
  const std::vector<double> all_weights = frame_weights(animation, first, last);
  HeldOutCost out;
  for (uint32_t f = first; f <= last; ++f) {
    if (std::find(representatives.begin(), representatives.end(), f) == representatives.end()) {
      out.frames.push_back(f);
    }
  }
  if (out.frames.empty()) return out;
  if (out.frames.size() > most) {
    std::vector<uint32_t> picked;
    for (const uint32_t i :
         evenly_spread(0, static_cast<uint32_t>(out.frames.size()) - 1, std::max(most, 1u))) {
      picked.push_back(out.frames[i]);
    }
    out.frames = std::move(picked);
  }
  out.costs.resize(out.frames.size());
  const size_t grain = (out.frames.size() + kBuffers - 1) / kBuffers;
  parallel_for(out.frames.size(), grain, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      const std::vector<Box> boxes =
          repaired_frame(animation, out.frames[f], representatives, representative_boxes);
      out.costs[f] = sah_cost(tree, refit(tree, boxes), model);
    }
  });
  const std::vector<double> weights = weights_by_nearness(out.frames, first, all_weights);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (size_t f = 0; f < out.costs.size(); ++f) {
    out.mean += weights[f] * out.costs[f] / sum;
    out.max = std::max(out.max, out.costs[f]);
  }
  return out;
}

}  // namespace sinew
