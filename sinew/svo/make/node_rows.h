// Inner nodes of an octree, from its cells up, while blocks come one after another.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/make/block_part.h"

namespace sinew {

// Nodes of one level in Morton order.
struct NodeRow {
  std::vector<SvoNode> nodes;  // `first`: in the row of their children
  SvoLevel means;              // of nodes that are complete
  // Of the last nodes, those whose sums somebody still needs.
  std::vector<uint64_t> mortons;
  std::vector<AttributeSum> sums;

  // Adds a child, the `index`th of its row, to the node that holds it: the last one, or a new one.
  void add_child(uint64_t morton, uint32_t level, uint32_t index, const AttributeSum& sum);
  void complete();  // writes the means of nodes that have none
};

class NodeRows {
 public:
  // Parts in Morton order, behind those that came before.
  void add(std::span<const BlockPart> parts);
  // Fills nodes and node_level, from svo.root_level down.
  void finish(Svo& svo);
  size_t cells() const { return cells_; }

 private:
  static constexpr size_t kRows = kBlockLevel - kCellLevel;  // within blocks
  void add(const BlockPart& part);

  std::array<NodeRow, kRows> rows_;
  uint32_t cells_ = 0;
};

}  // namespace sinew
