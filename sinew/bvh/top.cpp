// Splits ranges of boxes top-down, with the binned SAH over box centres, until a node has eight.
// Based on: I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.
// Differs: eight-wide at once (the range whose split gains most is next), serial, and without
// allocations.
#include "sinew/bvh/top.h"

#include <algorithm>

#include "sinew/base/check.h"

namespace sinew {
namespace {

constexpr int kBins = 8;
constexpr int kBlindDepth = 24;  // from here on ranges are halved, so that no tree is too deep

struct Range {
  uint32_t begin = 0, end = 0;
  Box box;
  uint32_t count() const { return end - begin; }
};

void set_child(Node8& node, uint32_t lane, const Box& box, uint32_t word) {
  set_lane_box(node, lane, box);
  node.child[lane] = word;
}

class TopBuilder {
 public:
  TopBuilder(std::span<const Box> boxes, TopScratch& scratch, std::vector<Node8>& out)
      : boxes_(boxes), scratch_(scratch), nodes_(out) {}

  void run() {
    const auto count = static_cast<uint32_t>(boxes_.size());
    scratch_.order.resize(count);
    scratch_.centers.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
      scratch_.order[i] = i;
      scratch_.centers[i] = boxes_[i].min + boxes_[i].max;
    }
    scratch_.pending.clear();
    push(0, count, 0);
    for (size_t node = 0; node * 3 < scratch_.pending.size(); ++node) make_node(node);
  }

 private:
  void push(uint32_t begin, uint32_t end, uint32_t depth) {
    nodes_.push_back(empty_node());
    for (const uint32_t word : {begin, end, depth}) scratch_.pending.push_back(word);
  }

  void make_node(size_t node) {
    const uint32_t* const item = &scratch_.pending[node * 3];
    const uint32_t depth = item[2];
    std::array<Range, kWidth> parts;
    parts[0] = with_box(item[0], item[1]);
    uint32_t count = 1;
    while (count < kWidth) {
      const uint32_t largest = largest_part({parts.data(), count});
      if (parts[largest].count() == 1) break;
      const uint32_t middle = split(parts[largest], depth);
      parts[count++] = with_box(middle, parts[largest].end);
      parts[largest] = with_box(parts[largest].begin, middle);
    }
    for (uint32_t lane = 0; lane < count; ++lane) {
      const Range& part = parts[lane];
      if (part.count() == 1) {
        set_child(nodes_[node], lane, part.box, kLeafBit | scratch_.order[part.begin]);
      } else {
        set_child(nodes_[node], lane, part.box, inner_word(static_cast<uint32_t>(nodes_.size())));
        push(part.begin, part.end, depth + 1);
      }
    }
  }

  Range with_box(uint32_t begin, uint32_t end) const {
    Range range{begin, end, {}};
    for (uint32_t i = begin; i < end; ++i) range.box.extend(boxes_[scratch_.order[i]]);
    return range;
  }

  // The part whose box is largest among those that can be split; any if none can.
  static uint32_t largest_part(std::span<const Range> parts) {
    uint32_t best = 0;
    float best_area = -1.0f;
    for (uint32_t i = 0; i < parts.size(); ++i) {
      const float area = parts[i].count() > 1 ? half_area(parts[i].box) : -1.0f;
      if (area > best_area) {
        best = i;
        best_area = area;
      }
    }
    return best;
  }

  // Reorders the range and returns where its second half begins.
  uint32_t split(const Range& range, uint32_t depth) {
    const uint32_t middle = range.begin + range.count() / 2;
    if (range.count() == 2 || depth >= kBlindDepth) return middle;
    Box centers;
    for (uint32_t i = range.begin; i < range.end; ++i) {
      centers.extend(scratch_.centers[scratch_.order[i]]);
    }
    const Plane plane = best_plane(range, centers);
    if (plane.axis < 0) return middle;
    const auto split_at = std::partition(
        scratch_.order.begin() + range.begin, scratch_.order.begin() + range.end,
        [&](uint32_t i) { return bin_of(scratch_.centers[i], centers, plane.axis) < plane.bin; });
    const auto at = static_cast<uint32_t>(split_at - scratch_.order.begin());
    return at == range.begin || at == range.end ? middle : at;
  }

  struct Plane {
    int axis = -1;
    int bin = 0;  // the first of the second half
  };

  static int bin_of(vec3 center, const Box& centers, int axis) {
    const float extent = centers.max[axis] - centers.min[axis];
    const float place = (center[axis] - centers.min[axis]) / extent * kBins;
    return std::min(static_cast<int>(place), kBins - 1);
  }

  Plane best_plane(const Range& range, const Box& centers) const {
    Plane best;
    float best_cost = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centers.max[axis] - centers.min[axis];
      if (!(extent > 0.0f) || !std::isfinite(extent)) continue;
      std::array<Box, kBins> boxes;
      std::array<uint32_t, kBins> counts{};
      for (uint32_t i = range.begin; i < range.end; ++i) {
        const uint32_t index = scratch_.order[i];
        const int bin = bin_of(scratch_.centers[index], centers, axis);
        boxes[bin].extend(boxes_[index]);
        ++counts[bin];
      }
      std::array<float, kBins> right_cost{};
      Box right;
      uint32_t right_count = 0;
      for (int bin = kBins; bin-- > 1;) {
        right.extend(boxes[bin]);
        right_count += counts[bin];
        right_cost[bin] = half_area(right) * static_cast<float>(right_count);
      }
      Box left;
      uint32_t left_count = 0;
      for (int bin = 1; bin < kBins; ++bin) {
        left.extend(boxes[bin - 1]);
        left_count += counts[bin - 1];
        const float cost = half_area(left) * static_cast<float>(left_count) + right_cost[bin];
        if (left_count > 0 && left_count < range.count() && cost < best_cost) {
          best = {axis, bin};
          best_cost = cost;
        }
      }
    }
    return best;
  }

  std::span<const Box> boxes_;
  TopScratch& scratch_;
  std::vector<Node8>& nodes_;
};

}  // namespace

void build_top(std::span<const Box> boxes, TopScratch& scratch, std::vector<Node8>& out) {
  out.clear();
  if (!boxes.empty()) TopBuilder(boxes, scratch, out).run();
}

}  // namespace sinew
