// Where the nodes of an octree's leaves stand: blocks' hierarchies with lanes as full as can be.
#include <algorithm>

#include "sinew/svo/leaves.h"

namespace sinew {
namespace {

constexpr uint32_t packets_of(uint32_t boxes) {
  return (boxes + kWidth - 1) / kWidth;
}
// Nodes for so many boxes at most: packets, and one above them if they are several.
constexpr uint32_t nodes_of(uint32_t boxes) {
  return packets_of(boxes) + (boxes > kWidth ? 1 : 0);
}

uint32_t nodes_of(const SvoCell& cell) {
  const auto bricks = static_cast<uint32_t>(std::popcount(cell.bricks));
  return 1 + nodes_of(std::min<uint32_t>(8 * bricks, cell.voxels)) + nodes_of(cell.voxels);
}

class LayoutMaker {
 public:
  explicit LayoutMaker(const Svo& svo) : svo_(svo) {
    out_.svo = &svo;
    out_.first_block = svo.first_block_node();
  }

  SvoLeafLayout make() {
    const uint32_t blocks = svo_.block_count();
    out_.first_node.reserve(svo_.cells.size());
    begin_part();
    for (uint32_t n = 0; n < out_.first_block; ++n) add_upper(n);
    out_.part_roots.push_back(blocks == 0 ? kNoChild : word_above_blocks(0));
    for (uint32_t b = 0; b < blocks; ++b) {
      begin_part();
      out_.part_roots.push_back(add_below(out_.first_block + b));
      for (uint32_t c = svo_.blocks[b].first_cell; c < svo_.blocks[b + 1].first_cell; ++c) {
        out_.first_node.push_back(next_);
        next_ += nodes_of(svo_.cells[c]);
      }
    }
    begin_part();
    out_.node_count = next_;
    return std::move(out_);
  }

 private:
  void begin_part() { out_.parts.push_back({static_cast<uint32_t>(out_.children.size()), next_}); }

  uint32_t add_node() {
    out_.children.emplace_back().fill(kNoChild);
    return next_++;
  }
  // Of a node of the part that was begun last.
  uint32_t& child(uint32_t node, uint32_t lane) {
    const SvoLeafLayout::Part& part = out_.parts.back();
    return out_.children[part.first_child + node - part.first_node][lane];
  }

  uint32_t word_above_blocks(uint32_t node) const {
    if (node < out_.first_block) return inner_word(node);
    return treelet_word(1 + node - out_.first_block);
  }
  // Node n of part 0 is the octree's node n.
  void add_upper(uint32_t n) {
    add_node();
    const SvoNode& node = svo_.nodes[n];
    for (uint32_t c = 0; c < node.count; ++c) child(n, c) = word_above_blocks(node.first + c);
  }

  uint32_t cell_word(uint32_t cell) const { return treelet_word(1 + svo_.block_count() + cell); }

  // A node of the octree, or a cell.
  struct Below {
    bool cell;
    uint32_t index;
  };
  Below below(const SvoNode& node, uint32_t c) const {
    return {node.level == kCellLevel + 1, node.first + c};
  }

  // Opens children while they fit into one node, those with the most children first. Returns the
  // child word of what is made.
  uint32_t add_below(uint32_t n) {
    const SvoNode& node = svo_.nodes[n];
    if (node.count > kWidth) return add_cells(node.first, node.first + node.count);
    std::vector<Below> open;
    for (uint32_t c = 0; c < node.count; ++c) open.push_back(below(node, c));
    for (;;) {
      const auto count = [&](const Below& b) { return b.cell ? 0u : svo_.nodes[b.index].count; };
      size_t best = open.size();
      for (size_t i = 0; i < open.size(); ++i) {
        if (count(open[i]) == 0 || open.size() - 1 + count(open[i]) > kWidth) continue;
        if (best == open.size() || count(open[i]) > count(open[best])) best = i;
      }
      if (best == open.size()) break;
      const SvoNode& opened = svo_.nodes[open[best].index];
      open[best] = below(opened, 0);
      for (uint32_t c = 1; c < opened.count; ++c) open.push_back(below(opened, c));
    }
    if (open.size() == 1) return word_of(open[0]);
    const uint32_t made = add_node();
    for (uint32_t i = 0; i < open.size(); ++i) {
      const uint32_t word = word_of(open[i]);  // may move `children`
      child(made, i) = word;
    }
    return inner_word(made);
  }
  uint32_t word_of(const Below& b) { return b.cell ? cell_word(b.index) : add_below(b.index); }

  // More cells than eight, some of which are copies.
  uint32_t add_cells(uint32_t begin, uint32_t end) {
    if (end - begin == 1) return cell_word(begin);
    const uint32_t made = add_node(), count = end - begin;
    const uint32_t lanes = std::min(count, kWidth);
    for (uint32_t i = 0; i < lanes; ++i) {
      const uint32_t word = add_cells(begin + count * i / lanes, begin + count * (i + 1) / lanes);
      child(made, i) = word;
    }
    return inner_word(made);
  }

  const Svo& svo_;
  SvoLeafLayout out_;
  uint32_t next_ = 0;  // node
};

}  // namespace

size_t SvoLeafLayout::bytes() const {
  return parts.size() * sizeof(Part) + children.size() * sizeof(children[0]) +
         (part_roots.size() + first_node.size()) * sizeof(uint32_t);
}

Result<SvoLeafLayout> make_leaf_layout(const Svo& svo) {
  if (svo.cells.size() > kMostRayCells) {
    return fail({ErrorKind::bad_input, "", svo.name,
                 std::to_string(svo.cells.size()) + " cells are more than rays can tell apart (" +
                     std::to_string(kMostRayCells) + ")",
                 "voxelize at a lower resolution"});
  }
  return LayoutMaker(svo).make();
}

}  // namespace sinew
