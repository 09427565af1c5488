// The boxes of a world's hierarchy at one level: a cut through the top tree and the trees of the
// objects, for pictures that show how tightly they fit.
#include <vector>

#include "sinew/bvh/box_body.h"
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

struct Place {
  uint32_t word;  // child word
  uint32_t level;
  Box box;
};

// What a treelet's word stands for, if rays have come to it; else the word itself, which is then a
// leaf.
uint32_t made_so_far(const VisitedBody& body, uint32_t word) {
  const uint32_t link =
      std::atomic_ref(body.bvh->links[treelet_of(word)]).load(std::memory_order_acquire);
  return link < kBeingMade ? link : word;
}
// Cells are leaves, whatever is made of them.
uint32_t made_so_far(const BoxBody& body, uint32_t word) {
  const uint32_t part = treelet_of(word);
  if (part >= body.parts) return word;
  const uint32_t state = std::atomic_ref(body.part_state[part]).load(std::memory_order_acquire);
  return state == 2 * body.epoch + 1 ? body.part_root[part] : word;
}

// The cut through one tree from its root down: leaf(place) gets leaves at or above the level,
// box(box) the inner nodes at it. Boxes of triangles that are not finite are empty and left out.
template <class Body, class Leaf, class Inner>
void cut(const Node8* nodes, const Body* body, const Place& root, uint32_t level, const Leaf& leaf,
         const Inner& inner) {
  std::vector<Place> stack = {root};
  while (!stack.empty()) {
    Place here = stack.back();
    stack.pop_back();
    if (body != nullptr && here.word != kNoChild && is_treelet_word(here.word)) {
      here.word = made_so_far(*body, here.word);
    }
    if (!is_inner_word(here.word)) {
      leaf(here);
    } else if (here.level == level) {
      inner(here.box);
    } else {
      const Node8& node = nodes[here.word];
      for (uint32_t lane = 0; lane < kWidth; ++lane) {
        const Box box = lane_box(node, lane);
        if (!box.empty()) stack.push_back({node.child[lane], here.level + 1, box});
      }
    }
  }
}

}  // namespace

std::vector<TreeBox> World::boxes(uint32_t level) const {
  const Impl& w = *impl_;
  const WorldFrame& frame = w.now();
  std::vector<TreeBox> found;
  const auto visit_object = [&](uint32_t index, uint32_t at_level) {
    const Instance& instance = frame.instances[index];
    const Object& object = w.objects[instance.object];
    const Body& body = w.bodies[object.body];
    const PosedObject& posed = frame.objects[instance.object];
    const auto keep = [&](const Box& box) { found.push_back({box, instance.object}); };
    if (instance.boxes != nullptr) {
      const BoxBody& boxes = *instance.boxes;
      return cut(
          boxes.nodes, &boxes, {boxes.root, at_level, posed.local_box}, level,
          [&](const Place& leaf) { keep(leaf.box); }, keep);
    }
    const VisitedBody* const visited = instance.body;
    const bool ready = visited == nullptr || is_ready(*visited);
    const Place root{!ready               ? kNoChild
                     : visited == nullptr ? instance.root
                                          : visited->upper.load(std::memory_order_acquire),
                     at_level, body.deforms ? posed.local_box : body.bvh.box};
    cut(
        instance.nodes, visited, root, level, [&](const Place& leaf) { keep(leaf.box); }, keep);
  };
  if (frame.instances.size() == 1 && frame.leaves.empty()) visit_object(0, 0);
  if (frame.instances.size() < 2 && frame.leaves.empty()) return found;
  const auto visit_leaf = [&](const Place& place) {
    const uint32_t index = place.word & ~kLeafBit;
    if (frame.leaves.empty()) return visit_object(index, place.level);
    const TopLeaf& leaf = frame.leaves[index];
    if (leaf.word == kNoChild) return visit_object(leaf.instance, place.level);
    found.push_back({place.box, kNoObject});
  };
  cut(
      frame.top.data(), static_cast<const VisitedBody*>(nullptr), {inner_word(0), 0, frame.box},
      level, [&](const Place& leaf) { visit_leaf(leaf); },
      [&](const Box& box) {
        found.push_back({box, kNoObject});
      });
  return found;
}

}  // namespace sinew
