#include "sinew/io/gltf/graph.h"

#include <fmt/format.h>

namespace sinew::gltf {
namespace {

using Children = std::vector<std::vector<uint32_t>>;

std::vector<uint32_t> nodes_without_parent(const Children& children) {
  std::vector<bool> has_parent(children.size(), false);
  for (const std::vector<uint32_t>& list : children) {
    for (const uint32_t child : list) has_parent[child] = true;
  }
  std::vector<uint32_t> roots;
  for (uint32_t node = 0; node < children.size(); ++node) {
    if (!has_parent[node]) roots.push_back(node);
  }
  return roots;
}

Result<std::vector<uint32_t>> find_roots(const Json& root, const Children& children) {
  SINEW_TRY(const std::vector<Json> scenes, root.objects("scenes", "scene"));
  if (scenes.empty()) {
    std::vector<uint32_t> roots = nodes_without_parent(children);
    if (roots.empty() && !children.empty()) return root.error("all its nodes form cycles");
    return roots;
  }
  SINEW_TRY(const auto index, root.index("scene", scenes.size()));
  return scenes[index.value_or(0)].indices("nodes", children.size());
}

}  // namespace

Result<NodeGraph> read_graph(const Json& root) {
  NodeGraph graph;
  SINEW_TRY(graph.nodes, root.objects("nodes", "node"));
  graph.parent.assign(graph.nodes.size(), -1);
  Children children;
  children.reserve(graph.nodes.size());
  for (const Json& node : graph.nodes) {
    SINEW_TRY(children.emplace_back(), node.indices("children", graph.nodes.size()));
  }
  SINEW_TRY(const std::vector<uint32_t> roots, find_roots(root, children));

  std::vector<bool> visited(graph.nodes.size(), false);
  std::vector<uint32_t> stack(roots.rbegin(), roots.rend());
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    if (visited[node]) {
      return graph.nodes[node].error("has two parents, or is its own ancestor",
                                     "nodes must form trees; export the file again");
    }
    visited[node] = true;
    graph.order.push_back(node);
    for (auto child = children[node].rbegin(); child != children[node].rend(); ++child) {
      graph.parent[*child] = static_cast<int32_t>(node);
      stack.push_back(*child);
    }
  }
  return graph;
}

}  // namespace sinew::gltf
