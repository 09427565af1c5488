// Updates: bring a Bvh8 to a new pose of its body, in place.
// Based on: T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy Updates for
// Ray Tracing of Deformable Models", 2003, section 3.2 (bottom-up and hybrid updates). Differs: the
// middle level is where treelets begin, and what is below is made a treelet at a time (visit.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "sinew/base/work_time.h"
#include "sinew/bvh/wide.h"

namespace sinew {

// How a body follows its pose. All modes give the same hits, bit for bit.
//   full       all vertices, all boxes, bottom-up and in parallel
//   hybrid     all vertices; the boxes of treelets from them; insides when the first ray comes
//   lazy       boxes derived from the pose; vertices and insides when the first ray comes. Bodies
//              whose vertices are given by the caller are updated as by `hybrid`
//   automatic  one of these for each body, by what rays reached in the last frames
enum class UpdateMode : uint8_t { automatic, full, hybrid, lazy };
const char* name_of(UpdateMode mode);  // auto, full, hybrid, lazy
std::optional<UpdateMode> update_mode_named(std::string_view name);

// Mode `full`. Allocates only the first time (or when the layout changed). Returns whether all
// vertices of triangles are finite; if not, triangles with a vertex that is not are never hit. The
// time of all threads is added to `work`.
bool update_full(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out,
                 WorkTime* work = nullptr);

// Mode `hybrid`: the boxes of all treelets, then the upper tree. Returns as update_full does.
bool update_hybrid(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out,
                   WorkTime* work = nullptr);

// The same from boxes that the caller knows: box_of(first, boxes) fills in those of the treelets
// [first, first + boxes.size()).
class TreeletBoxes {
 public:
  template <class F>
  TreeletBoxes(const F& function)
      : context_(&function), call_([](const void* context, uint32_t first, std::span<Box> boxes) {
          (*static_cast<const F*>(context))(first, boxes);
        }) {}
  void operator()(uint32_t first, std::span<Box> boxes) const { call_(context_, first, boxes); }

 private:
  const void* context_;
  void (*call_)(const void*, uint32_t, std::span<Box>);
};
enum class Threads : uint8_t { one, all };
void update_upper(const Bvh8Layout& layout, TreeletBoxes boxes, Threads threads, Bvh8& out);

// Gives `out` the size that the layout needs, for treelets that hang by links.
void reserve(const Bvh8Layout& layout, Bvh8& out);

}  // namespace sinew
