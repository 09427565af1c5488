#include "sinew/bvh/frames/frame_tree.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/wide.h"

namespace sinew {
namespace {

constexpr uint32_t kSlotsPerTask = 4096;

// Inner nodes from the root to a leaf that a move may make. Eight-wide nodes are never deeper than
// the binary ones that they are made of.
constexpr uint32_t kMostHeight = kMaxDepth - 8;

double power(double base, uint32_t exponent) {
  double out = 1.0;
  for (; exponent > 0; --exponent) out *= base;
  return out;
}

}  // namespace

FrameTree::FrameTree(const Tree& tree, const FrameBoxes& frames, const OptimizeConfig& config)
    : records_(frames.primitive_count()),
      frames_(frames.frame_count()),
      padding_(row_padding(frames_)),
      boxes_(size_t{2} * records_ * kBoxRows * padding_),
      areas_(size_t{2} * records_),
      child_(size_t{2} * records_),
      parent_(records_),
      changed_(records_, 0),
      height_(records_, 0),
      g_(padding_),
      config_(config),
      weights_(frames.weights),
      rest_(size_t{kBoxRows} * padding_),
      saved_(padding_) {
  SINEW_CHECK(records_ >= 2 && tree.nodes.size() == 2 * size_t{records_} - 1);
  std::fill_n(boxes_.data(), size_t{2} * kBoxRows * padding_, 0.0f);
  std::fill_n(areas_.data(), areas_.size(), 0.0f);
  std::fill_n(g_.data(), padding_, 0.0f);
  copy_topology(tree);
  const RelativeFrames relative(frames);
  parallel_for(slot_count() - 2, kSlotsPerTask, [&](size_t begin, size_t end) {
    for (auto slot = static_cast<uint32_t>(begin) + 2; slot < end + 2; ++slot) {
      if (!is_primitive(child_[slot])) continue;
      relative.write_rows(child_[slot] & ~kPrimitiveBit, view().box(slot));
    }
  });
  combine_records(view(), 1, records_);
  for (uint32_t record = records_; record-- > 1;) {
    height_[record] = 1 + std::max(height_of(2 * record), height_of(2 * record + 1));
  }
  refresh();
}

// Depth first, so that the records of a subtree stand together.
void FrameTree::copy_topology(const Tree& tree) {
  struct Pending {
    uint32_t node, slot;
  };
  child_[1] = kPrimitiveBit;
  parent_[0] = kNoSlot;
  uint32_t next_record = 1;
  std::vector<Pending> stack = {{Tree::kRoot, 0}};
  while (!stack.empty()) {
    const Pending next = stack.back();
    stack.pop_back();
    const TreeNode& node = tree.nodes[next.node];
    if (node.is_leaf()) {
      SINEW_CHECK(node.count() == 1);
      child_[next.slot] = kPrimitiveBit | tree.primitives[node.first()];
      continue;
    }
    const uint32_t record = next_record++;
    child_[next.slot] = record;
    parent_[record] = next.slot;
    stack.push_back({node.right(), 2 * record + 1});
    stack.push_back({node.left(), 2 * record});
  }
}

FrameView FrameTree::view() {
  return {boxes_.data(),   areas_.data(), child_.data(), parent_.data(),
          changed_.data(), g_.data(),     padding_,      frames_};
}

void FrameTree::refresh() {
  const size_t tasks = (slot_count() + kSlotsPerTask - 1) / kSlotsPerTask;
  std::vector<double> parts(tasks * frames_, 0.0);
  parallel_for(slot_count(), kSlotsPerTask, [&](size_t begin, size_t end) {
    add_costs(view(), static_cast<uint32_t>(begin), static_cast<uint32_t>(end), config_.cost,
              parts.data() + begin / kSlotsPerTask * frames_);
  });
  costs_.assign(frames_, 0.0);
  for (size_t i = 0; i < parts.size(); ++i) costs_[i % frames_] += parts[i];

  most_ = *std::max_element(costs_.begin(), costs_.end());
  for (uint32_t f = 0; f < frames_ && most_ > 0.0; ++f) {
    g_[f] = static_cast<float>(weights_[f] * power(costs_[f] / most_, config_.exponent));
  }
  parallel_for(slot_count(), kSlotsPerTask, [&](size_t begin, size_t end) {
    weigh_slots(view(), static_cast<uint32_t>(begin), static_cast<uint32_t>(end));
  });
}

// Whether the sum of v_i C_i^(k+1) falls when the areas fall by saved_, by at least `least` in
// units of the areas that searches see. These go by the slope of the sum, so where a cheap frame
// would become dear they are too hopeful.
bool FrameTree::worth_it(float least) const {
  double gain = 0.0;
  for (uint32_t f = 0; f < frames_; ++f) {
    const double before = costs_[f] / most_;
    const double change = double(config_.cost.traversal) * double(saved_[f]) / most_;
    gain += weights_[f] *
            (power(before, config_.exponent + 1) - power(before - change, config_.exponent + 1));
  }
  const double slope = double(config_.cost.traversal) / most_ * (config_.exponent + 1.0);
  return gain > double(least) * slope;
}

void FrameTree::copy_slot(uint32_t from, uint32_t to) {
  const FrameView tree = view();
  child_[to] = child_[from];
  areas_[to] = areas_[from];
  std::copy_n(tree.box(from), kBoxRows * padding_, tree.box(to));
  if (!is_primitive(child_[to])) parent_[child_[to]] = to;
}

uint32_t FrameTree::height_of(uint32_t slot) const {
  return is_primitive(child_[slot]) ? 0 : height_[child_[slot]];
}

// Whether a new parent of both at `to` would reach too deep.
bool FrameTree::too_deep(uint32_t slot, uint32_t to) const {
  uint32_t above = 0;
  for (uint32_t at = to; at > 1; at = parent_[at >> 1]) ++above;
  return above + 1 + std::max(height_of(slot), height_of(to)) > kMostHeight;
}

// Heights of the record and its ancestors, up to where nothing changes.
void FrameTree::set_heights(uint32_t record) {
  while (record != 0) {
    const uint32_t height = 1 + std::max(height_of(2 * record), height_of(2 * record + 1));
    if (height == height_[record]) break;
    height_[record] = height;
    record = parent_[record] >> 1;
  }
}

bool FrameTree::move(uint32_t slot, uint32_t to, float least) {
  const uint32_t record = slot >> 1, sibling = slot ^ 1, from = parent_[record];
  if (!move_savings(view(), slot, to, rest_.data(), saved_.data()) ||
      !worth_it(std::max(least, kLeastGain * areas_[from])) || too_deep(slot, to)) {
    return false;
  }
  for (uint32_t f = 0; f < frames_; ++f) {
    costs_[f] -= double(config_.cost.traversal) * double(saved_[f]);
  }
  copy_slot(sibling, from);
  copy_slot(to, sibling);
  child_[to] = record;
  parent_[record] = to;
  // The new place first: then boxes above both places do not shrink before they grow again.
  combine_upwards(view(), record);
  combine_upwards(view(), from >> 1);
  height_[record] = 1 + std::max(height_of(slot), height_of(sibling));
  set_heights(to >> 1);
  set_heights(from >> 1);
  return true;
}

Tree FrameTree::tree() const {
  struct Pending {
    uint32_t child, parent;
    bool right;
  };
  Tree out;
  out.nodes.reserve(2 * size_t{records_} - 1);
  out.primitives.reserve(records_);
  std::vector<Pending> stack = {{child_[0], 0, false}};
  while (!stack.empty()) {
    const Pending next = stack.back();
    stack.pop_back();
    const auto node = static_cast<uint32_t>(out.nodes.size());
    if (node > 0) (next.right ? out.nodes[next.parent].b : out.nodes[next.parent].a) = node;
    if (is_primitive(next.child)) {
      out.nodes.push_back(TreeNode::leaf(static_cast<uint32_t>(out.primitives.size()), 1));
      out.primitives.push_back(next.child & ~kPrimitiveBit);
      continue;
    }
    out.nodes.push_back(TreeNode::inner(0, 0));
    stack.push_back({child_[2 * next.child + 1], node, true});
    stack.push_back({child_[2 * next.child], node, false});
  }
  return out;
}

}  // namespace sinew
