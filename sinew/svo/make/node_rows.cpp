#include "sinew/svo/make/node_rows.h"

#include <utility>

namespace sinew {

void NodeRow::add_child(uint64_t morton, uint32_t level, uint32_t index, const AttributeSum& sum) {
  if (mortons.empty() || mortons.back() != morton) {
    nodes.push_back({index, 0, static_cast<uint8_t>(level)});
    mortons.push_back(morton);
    sums.emplace_back();
  }
  ++nodes.back().count;
  sums.back().add(sum);
}

void NodeRow::complete() {
  const size_t first = nodes.size() - sums.size();
  for (size_t i = means.normals.size(); i < nodes.size(); ++i) append_mean(sums[i - first], means);
}

void NodeRows::add(const BlockPart& part) {
  size_t from = rows_[0].nodes.size();
  for (size_t c = 0; c < part.cells.size(); ++c) {
    const uint64_t cell = part.morton << 9 | cell_order().of_place[part.cells[c].place];
    rows_[0].add_child(cell >> 3, kCellLevel + 1, cells_++, part.sums[c]);
  }
  for (size_t r = 1; r < kRows; ++r) {
    NodeRow& below = rows_[r - 1];
    const size_t next = rows_[r].nodes.size();
    for (size_t i = 0; i < below.sums.size(); ++i) {
      rows_[r].add_child(below.mortons[i] >> 3, kCellLevel + 1 + static_cast<uint32_t>(r),
                         static_cast<uint32_t>(from + i), below.sums[i]);
    }
    // Its nodes lie in this block: nothing can come to them any more.
    below.complete();
    below.mortons.clear();
    below.sums.clear();
    from = next;
  }
}

void NodeRows::add(std::span<const BlockPart> parts) {
  for (const BlockPart& part : parts) add(part);
}

void NodeRows::finish(Svo& svo) {
  std::vector<NodeRow> rows;
  for (NodeRow& row : rows_) rows.push_back(std::move(row));
  while (rows.back().nodes.front().level < svo.root_level) {
    const NodeRow& below = rows.back();
    NodeRow row;
    for (uint32_t i = 0; i < below.nodes.size(); ++i) {
      row.add_child(below.mortons[i] >> 3, below.nodes.front().level + 1u, i, below.sums[i]);
    }
    rows.back().complete();
    rows.push_back(std::move(row));
  }
  rows.back().complete();
  for (size_t r = rows.size(); r-- > 0;) {
    const NodeRow& row = rows[r];
    const uint32_t below = static_cast<uint32_t>(svo.nodes.size() + row.nodes.size());
    for (SvoNode node : row.nodes) {
      if (r > 0) node.first += below;  // children are counted from the beginning of all nodes
      svo.nodes.push_back(node);
    }
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(svo.node_level.normals, row.means.normals);
    append(svo.node_level.colors, row.means.colors);
    append(svo.node_level.spreads, row.means.spreads);
  }
}

}  // namespace sinew
