#include "sinew/bvh/update/visit.h"

#include "sinew/bvh/update/update.h"

namespace sinew {
namespace {

void positions_of(const VisitedBody& body, uint32_t treelet, vec3* out) {
  const Treelet& t = body.layout->treelets[treelet];
  const std::span<const uint32_t> vertices(body.layout->vertices.data() + t.first_vertex,
                                           t.vertex_count);
  if (body.positions == nullptr) {
    positions(*body.motion, *body.pose, vertices, {out, vertices.size()});
  } else {
    for (size_t i = 0; i < vertices.size(); ++i) out[i] = body.positions[vertices[i]];
  }
}

template <class T>
void prefetch(const T* first, uint32_t count, bool written) {
  constexpr uintptr_t kLine = 64;
  const auto begin = reinterpret_cast<uintptr_t>(first) & ~(kLine - 1);
  const auto end = reinterpret_cast<uintptr_t>(first + count);
  for (uintptr_t at = begin; at < end; at += kLine) {
    const auto* const line = reinterpret_cast<const char*>(at);
    written ? __builtin_prefetch(line, 1) : __builtin_prefetch(line);
  }
}

// What make_treelet() will read and write comes from memory while vertices are moved.
void prefetch_treelet(const VisitedBody& body, const Treelet& treelet) {
  prefetch(body.bvh->nodes.data() + treelet.first_node, treelet.node_count, true);
  prefetch(body.layout->children.data() + treelet.first_node, treelet.node_count, false);
  prefetch(body.layout->packet_corners.data() + treelet.first_packet, treelet.packet_count, false);
}

}  // namespace

bool visit_upper(VisitedBody& body, Threads threads) {
  uint32_t state = kUnmade;
  if (!body.upper.compare_exchange_strong(state, kBeingMade, std::memory_order_acquire)) {
    return state != kBeingMade;
  }
  const WorkTime::Part timed(body.upper_work);
  update_upper(
      *body.layout,
      [&](uint32_t first, std::span<Box> boxes) {
        derive_bounds(*body.clusters, *body.motion, *body.pose, first, boxes);
      },
      threads, *body.bvh);
  body.upper.store(body.bvh->root, std::memory_order_release);
  return true;
}

uint32_t visit_treelet(VisitedBody& body, uint32_t treelet) {
  const std::atomic_ref<uint32_t> link(body.bvh->links[treelet]);
  uint32_t word = kUnmade;
  if (!link.compare_exchange_strong(word, kBeingMade, std::memory_order_acquire)) {
    return word == kBeingMade ? kNoChild : word;
  }
  std::optional<WorkTime::Part> timed;
  if (is_timed(body.made.fetch_add(1, std::memory_order_relaxed))) timed.emplace(body.make_work);
  prefetch_treelet(body, body.layout->treelets[treelet]);
  vec3* const at = body.bvh->vertices.data() + place_of(*body.layout, treelet);
  positions_of(body, treelet, at);
  at[body.layout->treelets[treelet].vertex_count] = vec3(0.0f);
  make_treelet({body.layout, nullptr, body.bvh->nodes.data(), nullptr}, treelet, at);
  word = made_word(body.layout->treelets[treelet]);
  link.store(word, std::memory_order_release);
  return word;
}

Box look_at_box(const VisitedBody& body, uint32_t treelet) {
  Box box;
  derive_bounds(*body.clusters, *body.motion, *body.pose, treelet, {&box, 1});
  return box;
}

void look_at_packets(const VisitedBody& body, uint32_t treelet, TreeletPackets& out) {
  TreeletVertices at;
  positions_of(body, treelet, at.data());
  pack_treelet(*body.layout, treelet, at, out.data());
}

}  // namespace sinew
