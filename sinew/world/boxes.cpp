// The boxes of a world's hierarchy at one level: a cut through the top tree and the trees of the
// objects, for pictures that show how tightly they fit.
#include <vector>

#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

struct Place {
  uint32_t word;  // child word
  uint32_t level;
  Box box;
};

// The cut through one tree from its root down: leaf(place) gets leaves at or above the level,
// box(box) the inner nodes at it. Boxes of triangles that are not finite are empty and left out.
template <class Leaf, class Inner>
void cut(const Node8* nodes, const Place& root, uint32_t level, const Leaf& leaf,
         const Inner& inner) {
  std::vector<Place> stack = {root};
  while (!stack.empty()) {
    const Place here = stack.back();
    stack.pop_back();
    if (is_leaf_word(here.word)) {
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
  std::vector<TreeBox> found;
  const auto visit_object = [&](uint32_t index, uint32_t at_level) {
    const Instance& instance = w.instances[index];
    const Object& object = w.objects[instance.object];
    const Body& body = w.bodies[object.body];
    const auto keep = [&](const Box& box) { found.push_back({box, instance.object}); };
    const Place root{instance.root, at_level, body.deforms ? object.bvh.box : body.bvh.box};
    cut(
        instance.nodes, root, level, [&](const Place& leaf) { keep(leaf.box); }, keep);
  };
  if (w.instances.size() == 1) visit_object(0, 0);
  if (w.instances.size() < 2) return found;
  cut(
      w.top.data(), {inner_word(0), 0, w.box}, level,
      [&](const Place& leaf) { visit_object(leaf.word & ~kLeafBit, leaf.level); },
      [&](const Box& box) {
        found.push_back({box, kNoObject});
      });
  return found;
}

}  // namespace sinew
