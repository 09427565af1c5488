#include "sinew/svo/leaves.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/svo/file/stream.h"
#include "sinew/svo/leaves_kernels.h"

namespace sinew {
namespace {

// A box that contains the corners of cells also contains their voxels if it is larger by this: of
// the three axes of its cell a voxel reaches kRayMargin beyond, and no edge of a cell is longer
// than the box; and then there is rounding.
Box grown(const Box& box) {
  if (box.empty()) return box;
  constexpr float kShare = 3.1f * kRayMargin / static_cast<float>(kCellSide) + 0x1p-14f;
  const vec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
  const vec3 pad = kShare * box.extent() + 0x1p-19f * reach;
  return {box.min - pad, box.max + pad};
}

// Eight at most of `packets` packets, as evenly as can be.
uint32_t packets_a_child(uint32_t packets) {
  return (packets + kWidth - 1) / kWidth;
}

}  // namespace

void SvoLeaves::set_pose(const SvoLeafLayout& layout, PosedSvo& posed,
                         std::span<const uint8_t> resident) {
  const Svo& svo = *layout.svo;
  SINEW_DCHECK(&posed.svo() == &svo);
  SINEW_DCHECK(resident.empty() || resident.size() == svo.block_count());
  const uint32_t parts = 1 + svo.block_count();
  const bool same = layout_ == &layout && posed_ == &posed && part_state_.size() == parts &&
                    nodes_.size() == layout.node_count && cells_.size() == svo.cells.size();
  if (!same) {
    part_state_.assign(parts, 0);
    nodes_ = Buffer<Node8>(layout.node_count);
    cells_ = Buffer<BoxDetail>(svo.cells.size());
    body_.epoch = 0;
  }
  // What nothing moves is made once for all poses.
  const bool still = svo.joints == 0 && svo.morph_targets == 0;
  const bool kept = body_.epoch > 0 && still && resident.empty() && resident_.empty();
  layout_ = &layout;
  posed_ = &posed;
  resident_ = resident;
  body_.wishes = svo.paging ? svo.paging->wishes() : nullptr;
  if (kept) return;
  if (++body_.epoch > 0x7fffffffu) {
    std::ranges::fill(part_state_, 0);
    body_.epoch = 1;
  }
  body_.nodes = nodes_.data();
  body_.root = svo.cells.empty() ? kNoChild : treelet_word(layout.first_block > 0 ? 0 : 1);
  body_.parts = parts;
  body_.part_state = part_state_.data();
  body_.part_root = layout.part_roots.data();
  body_.details = cells_.data();
  body_.context = this;
  body_.make_part = [](void* context, uint32_t part) {
    auto& leaves = *static_cast<SvoLeaves*>(context);
    if (part == 0) leaves.make_upper();
    if (part > 0) leaves.make_block(part - 1);
  };
  body_.make_detail = [](void* context, uint32_t detail, uint32_t level) {
    return static_cast<SvoLeaves*>(context)->make_cell(detail, level);
  };
}

Box SvoLeaves::bounds() const {
  if (body_.root == kNoChild) return {};
  return grown(posed_->bounds(0));
}

void SvoLeaves::make_upper() {
  for (uint32_t n = 0; n < layout_->first_block; ++n) {
    const auto& children = layout_->children[n];
    const SvoNode& of = layout_->svo->nodes[n];
    Node8& node = nodes_[n];
    node = empty_node();
    for (uint32_t i = 0; i < of.count; ++i) {
      node.child[i] = children[i];
      set_lane_box(node, i, grown(posed_->bounds(of.first + i)));
    }
  }
}

void SvoLeaves::make_block(uint32_t block) {
  posed_->make_block(block);
  const Svo& svo = *layout_->svo;
  const vec3* const positions = posed_->block(block).positions.data();
  const bool is_resident = resident_.empty() || resident_[block] != 0;
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    const CellBox shape = cell_box(cell_corners(svo.cells[c], positions));
    BoxDetail& out = cells_[c];
    for (int axis = 0; axis < 3; ++axis) {
      out.low[axis] = shape.box.min[axis];
      out.high[axis] = shape.box.max[axis];
    }
    out.size = shape.longest / static_cast<float>(kCellSide);
    out.made = 0;
    out.whole = voxel_primitive(c, kFirstCode[kCellLevel]);
    out.finest = is_resident ? 0 : kCellLevel;
    out.wish = block;
  }
  const SvoLeafLayout::Part& part = layout_->parts[1 + block];
  const uint32_t first_cell = body_.parts;
  for (uint32_t n = layout_->parts[2 + block].first_child - part.first_child; n-- > 0;) {
    Node8& node = nodes_[part.first_node + n];
    node = empty_node();
    for (uint32_t i = 0; i < kWidth; ++i) {
      const uint32_t word = layout_->children[part.first_child + n][i];
      if (word == kNoChild) break;
      node.child[i] = word;
      if (is_inner_word(word)) {
        set_lane_box(node, i, node_box(nodes_[word]));
      } else {
        const BoxDetail& cell = cells_[treelet_of(word) - first_cell];
        set_lane_box(node, i,
                     {vec3(cell.low[0], cell.low[1], cell.low[2]),
                      vec3(cell.high[0], cell.high[1], cell.high[2])});
      }
    }
  }
}

uint32_t SvoLeaves::make_cell(uint32_t cell, uint32_t level) {
  const Svo& svo = *layout_->svo;
  const SvoCell& c = svo.cells[cell];
  const auto bricks = static_cast<uint32_t>(std::popcount(c.bricks));
  const uint32_t coarse = std::min<uint32_t>(8 * bricks, c.voxels);
  uint32_t first = layout_->first_node[cell];
  if (level < 2) ++first;
  if (level < 1) first += (coarse + kWidth - 1) / kWidth + (coarse > kWidth ? 1 : 0);
  return make_voxels(cell, level, first);
}

uint32_t SvoLeaves::make_voxels(uint32_t cell, uint32_t level, uint32_t first) {
  const Svo& svo = *layout_->svo;
  const SvoCell& c = svo.cells[cell];
  const auto after = std::upper_bound(
      svo.blocks.begin(), svo.blocks.end() - 1, cell,
      [](uint32_t value, const SvoBlock& block) { return value < block.first_cell; });
  const auto block = static_cast<uint32_t>(after - svo.blocks.begin() - 1);
  const CellCorners corners = cell_corners(c, posed_->block(block).positions.data());
  const uint64_t* const bricks = svo.bricks.data() + svo.blocks[block].first_brick + c.first_brick;
  const auto most = level == 0 ? c.voxels : 8u * static_cast<uint32_t>(std::popcount(c.bricks));
  // There is no node above a single packet.
  const bool may_be_one = level == 2 || most <= kWidth || c.voxels <= kWidth;
  const uint32_t packets_at = may_be_one ? first : first + 1;
  const uint32_t boxes =
      box_voxels(corners, c, bricks, level, voxel_primitive(cell, 0), nodes_.data() + packets_at);
  const uint32_t packets = (boxes + kWidth - 1) / kWidth;
  if (packets == 1) return leaf_word(packets_at, 1);
  SINEW_DCHECK(!may_be_one);
  Node8& node = nodes_[first];
  node = empty_node();
  const uint32_t each = packets_a_child(packets);
  for (uint32_t p = 0, lane = 0; p < packets; p += each, ++lane) {
    const uint32_t count = std::min(each, packets - p);
    Box box;
    for (uint32_t k = 0; k < count; ++k) box.extend(node_box(nodes_[packets_at + p + k]));
    set_lane_box(node, lane, box);
    node.child[lane] = leaf_word(packets_at + p, count);
  }
  return inner_word(first);
}

SvoLeaves::Counts SvoLeaves::made() const {
  Counts out;
  if (body_.root == kNoChild) return out;
  const Svo& svo = *layout_->svo;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    if (part_state_[1 + b] != 2 * body_.epoch + 1) continue;
    ++out.blocks;
    for (uint32_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      for (uint32_t l = 0; l < kCellLevel; ++l) out.cells[l] += cells_[c].made >> l & 1;
    }
  }
  return out;
}

size_t SvoLeaves::bytes_made() const {
  if (body_.root == kNoChild) return 0;
  const Svo& svo = *layout_->svo;
  size_t nodes = 0, cells = 0;
  const auto count_below = [&](uint32_t word) {
    if (is_leaf_word(word)) return leaf_packets(word);
    uint32_t count = 1;
    for (const uint32_t child : nodes_[word].child) {
      if (child != kNoChild) count += leaf_packets(child);
    }
    return count;
  };
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    if (part_state_[1 + b] != 2 * body_.epoch + 1) continue;
    nodes += layout_->parts[2 + b].first_child - layout_->parts[1 + b].first_child;
    for (uint32_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c, ++cells) {
      for (uint32_t l = 0; l < kCellLevel; ++l) {
        if (cells_[c].made >> l & 1) nodes += count_below(cells_[c].root[l]);
      }
    }
  }
  return nodes * sizeof(Node8) + cells * sizeof(BoxDetail);
}

void SvoLeaves::make_all(uint32_t level) {
  if (body_.root == kNoChild) return;
  for (uint32_t p = 0; p < body_.parts; ++p) make_box_part(body_, p);
  for (uint32_t c = 0; c < cells_.size() && level < kCellLevel; ++c) {
    bool made = false;
    if (cells_[c].finest <= level) visit_box_detail(body_, c, level, made);
  }
}

}  // namespace sinew
