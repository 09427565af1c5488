// HLBVH: primitives are sorted along a Morton curve, whose bits then say where ranges are split.
// Based on: J. Pantaleoni, D. Luebke, "HLBVH", 2010; K. Garanzha, J. Pantaleoni, D. McAllister,
// "Simpler and Faster HLBVH with Work Queues", 2011. Differs: the codes' box is that of the
// centroids; bits that all codes of a range share are skipped; a range of few primitives from
// several clusters is one leaf.
//
//            [ ]            top: medians down to ranges of some thousand primitives (median),
//           /   \                or SAH over clusters (sah); one entry for each such range
//        [ ]     range 2
//       /   \                    then all ranges are built at once, and their nodes moved to their
//   range 0  range 1             places in depth-first order
#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/bvh/builders/build_bins.h"
#include "sinew/bvh/builders/radix_sort.h"

namespace sinew {
namespace {

using build_detail::Binning;
using build_detail::Bins;
using build_detail::PrimitiveRef;
using build_detail::Rows;

constexpr uint32_t kCodeCells = 1024;  // of an axis: ten bits
constexpr int kInsideBits = 15;        // of a code that say where in its cluster it is
constexpr size_t kChunk = 16384;       // primitives of one task
constexpr uint32_t kRangeSize = 8192;  // ranges larger than this are split in the top

// Two zeros between any two of the lowest ten bits.
uint32_t spread_bits(uint32_t x) {
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

Rows centers_box(std::span<const Box> boxes) {
  std::vector<Rows> parts((boxes.size() + kChunk - 1) / kChunk);
  parallel_for(boxes.size(), kChunk, [&](size_t begin, size_t end) {
    vec3 low(Rows::kInfinity), high(-Rows::kInfinity);
    for (size_t i = begin; i < end; ++i) {
      const vec3 center = boxes[i].min + boxes[i].max;
      low = glm::min(low, center);
      high = glm::max(high, center);
    }
    for (int axis = 0; axis < 3; ++axis) {
      parts[begin / kChunk].low[axis] = low[axis];
      parts[begin / kChunk].high[axis] = high[axis];
    }
  });
  Rows all;
  for (const Rows& part : parts) all.extend(part);
  return all;
}

std::vector<CodedPrimitive> code_primitives(std::span<const Box> boxes) {
  Binning cells;
  cells.centers = centers_box(boxes);
  cells.prepare(kCodeCells);
  const auto cell = [&](vec3 center2, int axis) {
    if (cells.scale[axis] == 0.0f) return 0u;
    const float place = (center2[axis] - cells.centers.low[axis]) * cells.scale[axis];
    return spread_bits(static_cast<uint32_t>(static_cast<int32_t>(place)));  // below kCodeCells
  };
  std::vector<CodedPrimitive> coded(boxes.size());
  parallel_for(boxes.size(), kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const vec3 center2 = boxes[i].min + boxes[i].max;
      coded[i] = {cell(center2, 0) << 2 | cell(center2, 1) << 1 | cell(center2, 2),
                  static_cast<uint32_t>(i)};
    }
  });
  return coded;
}

struct Range {
  uint32_t begin = 0, end = 0;  // of sorted primitives
  uint32_t count() const { return end - begin; }
};

// Where the right half of a range begins: at the first code with the highest bit set that not all
// share, or in the middle if they are equal.
uint32_t split_range(std::span<const CodedPrimitive> coded, Range range) {
  const uint32_t first = coded[range.begin].code, last = coded[range.end - 1].code;
  if (first == last) return range.begin + range.count() / 2;
  const uint32_t bit = std::bit_floor(first ^ last);
  uint32_t below = range.begin, above = range.end - 1;  // bit clear, bit set
  while (above - below > 1) {
    const uint32_t middle = below + (above - below) / 2;
    (coded[middle].code & bit ? above : below) = middle;
  }
  return above;
}

// The tree's upper part in depth-first order: inner nodes, and ranges that become subtrees.
struct Top {
  static constexpr uint32_t kInner = 0xffffffffu;
  std::vector<uint32_t> entries;  // kInner, or a range
  std::vector<Range> ranges;      // in order
};

void add_medians(std::span<const CodedPrimitive> coded, Range all, Top& top) {
  std::vector<Range> stack = {all};
  while (!stack.empty()) {
    const Range range = stack.back();
    stack.pop_back();
    if (range.count() <= kRangeSize) {
      top.entries.push_back(static_cast<uint32_t>(top.ranges.size()));
      top.ranges.push_back(range);
      continue;
    }
    const uint32_t middle = split_range(coded, range);
    top.entries.push_back(Top::kInner);
    stack.push_back({middle, range.end});
    stack.push_back({range.begin, middle});
  }
}

// Builds the subtree of a range by medians, in depth-first order; links count from its root.
void build_range(std::span<const CodedPrimitive> coded, Range all, uint32_t max_leaf,
                 std::vector<TreeNode>& nodes) {
  struct Pending {
    Range range;
    uint32_t parent;  // whose right child it is, or kNone
  };
  constexpr uint32_t kNone = 0xffffffffu;
  const size_t base = nodes.size();
  Pending stack[64];  // 30 bits and then halves: no deeper than 30 + 32
  int depth = 0;
  stack[depth++] = {all, kNone};
  while (depth > 0) {
    const Pending item = stack[--depth];
    const auto node = static_cast<uint32_t>(nodes.size() - base);
    if (item.parent != kNone) nodes[base + item.parent].b = node;
    if (item.range.count() <= max_leaf) {
      nodes.push_back(TreeNode::leaf(item.range.begin, item.range.count()));
      continue;
    }
    const uint32_t middle = split_range(coded, item.range);
    nodes.push_back(TreeNode::inner(node + 1, 0));
    stack[depth++] = {{middle, item.range.end}, node};
    stack[depth++] = {{item.range.begin, middle}, kNone};
  }
}

// Runs of consecutive ranges with about kChunk primitives; the last entry is the end.
std::vector<uint32_t> runs_of(std::span<const Range> ranges) {
  std::vector<uint32_t> runs = {0};
  uint32_t first = 0;
  for (uint32_t r = 0; r < ranges.size(); ++r) {
    if (ranges[r].end - first < kChunk && r + 1 < ranges.size()) continue;
    runs.push_back(r + 1);
    first = ranges[r].end;
  }
  return runs;
}

// The top's entries with their places: a range's nodes follow each other.
struct Places {
  std::vector<uint32_t> range;  // of each range's root
  uint32_t count = 0;           // nodes of the tree
};

Places place_top(const Top& top, std::span<const uint32_t> sizes, std::vector<TreeNode>& nodes) {
  Places places;
  places.range.resize(top.ranges.size());
  for (const uint32_t size : sizes) places.count += size;
  places.count += static_cast<uint32_t>(top.entries.size() - top.ranges.size());
  nodes.resize(places.count);
  std::vector<uint32_t> open;  // inner nodes whose right child is yet to come
  uint32_t node = 0;
  bool right = false;
  for (const uint32_t entry : top.entries) {
    if (right) {
      nodes[open.back()].b = node;
      open.pop_back();
    }
    if (entry == Top::kInner) {
      nodes[node] = TreeNode::inner(node + 1, 0);
      open.push_back(node++);
    } else {
      places.range[entry] = node;
      node += sizes[entry];
    }
    right = entry != Top::kInner;
  }
  return places;
}

Tree build_ranges(std::span<const CodedPrimitive> coded, const Top& top, uint32_t max_leaf) {
  const std::vector<uint32_t> runs = runs_of(top.ranges);
  std::vector<std::vector<TreeNode>> built(runs.size() - 1);
  std::vector<uint32_t> sizes(top.ranges.size());
  parallel_for(built.size(), 1, [&](size_t begin, size_t end) {
    for (size_t run = begin; run < end; ++run) {
      for (uint32_t r = runs[run]; r < runs[run + 1]; ++r) {
        const size_t before = built[run].size();
        build_range(coded, top.ranges[r], max_leaf, built[run]);
        sizes[r] = static_cast<uint32_t>(built[run].size() - before);
      }
    }
  });

  Tree tree;
  const Places places = place_top(top, sizes, tree.nodes);
  tree.primitives.resize(coded.size());
  parallel_for(built.size(), 1, [&](size_t begin, size_t end) {
    for (size_t run = begin; run < end; ++run) {
      const TreeNode* from = built[run].data();
      for (uint32_t r = runs[run]; r < runs[run + 1]; ++r) {
        const uint32_t root = places.range[r];
        for (uint32_t i = 0; i < sizes[r]; ++i, ++from) {
          tree.nodes[root + i] =
              from->is_leaf() ? *from : TreeNode::inner(root + from->a, root + from->b);
        }
        for (uint32_t i = top.ranges[r].begin; i < top.ranges[r].end; ++i) {
          tree.primitives[i] = coded[i].primitive;
        }
      }
    }
  });
  return tree;
}

// Primitives whose codes share the upper 15 bits.
std::vector<Range> find_clusters(std::span<const CodedPrimitive> coded) {
  std::vector<Range> clusters;
  uint32_t begin = 0;
  for (uint32_t i = 1; i <= coded.size(); ++i) {
    if (i < coded.size() && coded[i].code >> kInsideBits == coded[begin].code >> kInsideBits) {
      continue;
    }
    clusters.push_back({begin, i});
    begin = i;
  }
  return clusters;
}

std::vector<PrimitiveRef> cluster_refs(std::span<const Range> clusters,
                                       std::span<const CodedPrimitive> coded,
                                       std::span<const Box> boxes) {
  constexpr size_t kClustersPerTask = 64;
  std::vector<PrimitiveRef> refs(clusters.size());
  parallel_for(clusters.size(), kClustersPerTask, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      Box box;
      for (uint32_t i = clusters[c].begin; i < clusters[c].end; ++i) {
        box.extend(boxes[coded[i].primitive]);
      }
      for (int axis = 0; axis < 3; ++axis) {
        refs[c].box.low[axis] = box.min[axis];
        refs[c].box.high[axis] = box.max[axis];
      }
      refs[c].index = static_cast<uint32_t>(c);
    }
  });
  return refs;
}

// Splits ranges of clusters at the best plane between bins; clusters count by their primitives.
class ClusterSplit {
 public:
  ClusterSplit(std::vector<PrimitiveRef>& refs, std::span<const Range> clusters,
               const BuildConfig& config)
      : refs_(refs), clusters_(clusters), config_(config) {}

  size_t operator()(size_t begin, size_t end, int depth) const {
    uint32_t count = 0;
    Binning binning;
    for (size_t i = begin; i < end; ++i) {
      count += clusters_[refs_[i].index].count();
      for (int axis = 0; axis < 3; ++axis) {
        const float center2 = refs_[i].center2(axis);
        binning.centers.low[axis] = std::min(binning.centers.low[axis], center2);
        binning.centers.high[axis] = std::max(binning.centers.high[axis], center2);
      }
    }
    if (count <= config_.max_leaf) return begin;
    const size_t halves = begin + (end - begin) / 2;
    if (depth >= build_detail::kBalanceDepth) return halves;
    binning.prepare(config_.bins);
    Bins bins;
    for (size_t i = begin; i < end; ++i) {
      bins.add(refs_[i], binning, clusters_[refs_[i].index].count());
    }
    const build_detail::Split best = best_split(bins, binning, config_);
    if (best.axis < 0) return halves;
    return build_detail::partition_at(refs_, begin, end, binning, best);
  }

 private:
  std::vector<PrimitiveRef>& refs_;
  std::span<const Range> clusters_;
  const BuildConfig& config_;
};

// Puts clusters in the order of their leaves; `clusters` follow. Codes then rise inside clusters
// only.
void reorder(std::vector<CodedPrimitive>& coded, std::vector<CodedPrimitive>& scratch,
             std::span<const uint32_t> order, std::vector<Range>& clusters) {
  std::vector<Range> moved(clusters.size());
  uint32_t end = 0;
  for (size_t c = 0; c < order.size(); ++c) {
    moved[c] = {end, end + clusters[order[c]].count()};
    end = moved[c].end;
  }
  constexpr size_t kClustersPerTask = 64;
  parallel_for(order.size(), kClustersPerTask, [&](size_t first, size_t last) {
    for (size_t c = first; c < last; ++c) {
      const Range from = clusters[order[c]];
      std::copy(coded.begin() + from.begin, coded.begin() + from.end,
                scratch.begin() + moved[c].begin);
    }
  });
  coded.swap(scratch);
  clusters.swap(moved);
}

Top sah_top(std::vector<CodedPrimitive>& coded, std::vector<CodedPrimitive>& scratch,
            std::span<const Box> boxes, const BuildConfig& config) {
  std::vector<Range> clusters = find_clusters(coded);
  std::vector<PrimitiveRef> refs = cluster_refs(clusters, coded, boxes);
  const ClusterSplit split(refs, clusters, config);
  const Tree upper = build_detail::TopDown(refs, split).run();
  reorder(coded, scratch, upper.primitives, clusters);
  Top top;
  for (const TreeNode& node : upper.nodes) {  // in depth-first order
    if (node.is_leaf()) {
      const uint32_t last = node.first() + node.count() - 1;
      add_medians(coded, {clusters[node.first()].begin, clusters[last].end}, top);
    } else {
      top.entries.push_back(Top::kInner);
    }
  }
  return top;
}

}  // namespace

Tree build_hlbvh(std::span<const Box> primitive_boxes, HlbvhSplit split,
                 const BuildConfig& config) {
  SINEW_CHECK(config.max_leaf >= 1 && config.leaf_block >= 1);
  SINEW_CHECK(config.bins >= 2 && config.bins <= build_detail::kMaxBins);
  if (primitive_boxes.empty()) return {};
  std::vector<CodedPrimitive> coded = code_primitives(primitive_boxes), scratch;
  radix_sort(coded, scratch);
  Top top;
  if (split == HlbvhSplit::sah) {
    top = sah_top(coded, scratch, primitive_boxes, config);
  } else {
    add_medians(coded, {0, static_cast<uint32_t>(coded.size())}, top);
  }
  return build_ranges(coded, top, config.max_leaf);
}

}  // namespace sinew
