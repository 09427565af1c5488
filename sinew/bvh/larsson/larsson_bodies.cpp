#include "sinew/bvh/larsson/larsson_bodies.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew::larsson {

KeyHierarchies::KeyHierarchies(Hierarchy hierarchy) : times_{0.0f} {
  hierarchies_.push_back(std::move(hierarchy));
}

KeyHierarchies::KeyHierarchies(std::vector<float> times, std::vector<Hierarchy> hierarchies)
    : times_(std::move(times)), hierarchies_(std::move(hierarchies)) {
  SINEW_CHECK(!times_.empty() && times_.size() == hierarchies_.size());
  SINEW_CHECK(std::is_sorted(times_.begin(), times_.end()));
}

uint32_t KeyHierarchies::nearest(std::span<const float> times, float time) {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  const auto later = static_cast<uint32_t>(after - times.begin());
  if (later == 0) return 0;
  if (later == times.size()) return later - 1;
  return time - times[later - 1] < times[later] - time ? later - 1 : later;
}

uint32_t Bodies::add(KeyHierarchies body) {
  const auto number = static_cast<uint32_t>(bodies_.size());
  bodies_.push_back(std::move(body));
  for (std::vector<uint32_t>& order : order_) order.push_back(number);
  return number;
}

// Insertion sort: linear while bodies move little from frame to frame.
void Bodies::sort() {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<uint32_t>& order = order_[axis];
    const auto place = [&](uint32_t body) { return bodies_[body].active().box().center()[axis]; };
    for (size_t i = 1; i < order.size(); ++i) {
      const uint32_t body = order[i];
      const float at = place(body);
      size_t j = i;
      for (; j > 0 && place(order[j - 1]) > at; --j) order[j] = order[j - 1];
      order[j] = body;
    }
  }
}

// ask(hierarchy, number) says whether to stop.
template <class AskBody>
void Bodies::in_order(const Ray& ray, const AskBody& ask) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(ray.direction[k]) > std::abs(ray.direction[axis])) axis = k;
  }
  const std::vector<uint32_t>& order = order_[axis];
  const bool forwards = ray.direction[axis] >= 0.0f;
  for (size_t i = 0; i < order.size(); ++i) {
    const uint32_t number = order[forwards ? i : order.size() - 1 - i];
    if (ask(bodies_[number].active(), number)) return;
  }
}

Hit Bodies::closest_hit(const Ray& ray) {
  const Probe probe(ray);
  Hit hit;
  in_order(ray, [&](Hierarchy& hierarchy, uint32_t number) {
    hierarchy.closest_hit(probe, number, hit);
    return false;
  });
  return hit;
}

bool Bodies::any_hit(const Ray& ray) {
  const Probe probe(ray);
  bool found = false;
  in_order(ray, [&](Hierarchy& hierarchy, uint32_t) { return found = hierarchy.any_hit(probe); });
  return found;
}

}  // namespace sinew::larsson
