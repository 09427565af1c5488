// Several of L's bodies in one world, and hierarchies that are switched over time.
// Based on: Larsson, Akenine-Moller 2003, section 3.3 (bodies sorted along the axes) and section 4,
// second experiment (one hierarchy a key of the animation).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/larsson/larsson.h"

namespace sinew::larsson {

// One hierarchy a key, all over the same triangles; the one whose time is nearest is in use.
class KeyHierarchies {
 public:
  // For a body that keeps one hierarchy.
  explicit KeyHierarchies(Hierarchy hierarchy);
  // Times ascend; one a hierarchy, at least one.
  KeyHierarchies(std::vector<float> times, std::vector<Hierarchy> hierarchies);

  // Which key is in use at this time: the nearest, of two equally near ones the later.
  static uint32_t nearest(std::span<const float> times, float time);

  // The chosen hierarchy has the positions of its own last update: update it.
  void select(float time) { active_ = nearest(times_, time); }
  Hierarchy& active() { return hierarchies_[active_]; }
  const Hierarchy& active() const { return hierarchies_[active_]; }

 private:
  std::vector<float> times_;
  std::vector<Hierarchy> hierarchies_;
  uint32_t active_ = 0;
};

class Bodies {
 public:
  uint32_t add(KeyHierarchies body);  // its number: what Hit::object says
  KeyHierarchies& body(uint32_t number) { return bodies_[number]; }
  const KeyHierarchies& body(uint32_t number) const { return bodies_[number]; }

  // Call once a frame when all bodies are updated. Nearly free if little moved.
  void sort();

  // The bodies are asked in the order of their centres along the ray's dominant axis.
  Hit closest_hit(const Ray& ray);
  bool any_hit(const Ray& ray);

 private:
  template <class AskBody>
  void in_order(const Ray& ray, const AskBody& ask);

  std::vector<KeyHierarchies> bodies_;
  std::array<std::vector<uint32_t>, 3> order_;  // of the bodies, one an axis
};

}  // namespace sinew::larsson
