// Keeps the layers of a cloth apart. Internal to the cloth.
// Based on: M. Teschner et al., "Optimized Spatial Hashing for Collision Detection of Deformable
// Objects", 2003. Differs: points push points away, which suffices for a sheet whose points are
// as near to each other as its layers may come; all corrections of a step are found before any is
// made, so that their order does not matter and partners move alike; cells that are neighbours
// along x have neighbouring slots.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/scene/procedural/cloth_grid.h"

namespace sinew {

class ClothMeetings {
 public:
  struct Config {
    float spacing = 0.01f;  // of the grid at rest, metres
    float friction = 0.1f;  // share of the sliding that push() takes away
  };
  ClothMeetings(const Config& config, const GridPoints& points);

  // Finds the points that may meet soon.
  void search(const GridPoints& points);

  // Pushes points apart that are too near. `before` is where they were at the step's beginning; it
  // follows as far as they were too near already, so that this gives them no speed.
  void push(GridPoints& points, GridPoints& before);

 private:
  static constexpr uint32_t kMost = 40;  // partners of a point; a dense pile has about 20
  struct Entry {
    vec3 point;
    uint16_t row, column;
  };
  static_assert(sizeof(Entry) == 16);
  struct Place {
    vec3 now, before;
  };
  struct Correction {
    vec3 push{0.0f};   // of the point
    vec3 shift{0.0f};  // of where it was before
  };

  uint32_t slot_of(vec3 p) const;
  void sort_into_slots(const GridPoints& points);
  bool still_valid(const GridPoints& points) const;

  float distance_;  // that the layers keep
  float reach_;     // of the search, and the side of a cell
  float friction_;
  std::vector<uint32_t> slot_begin_;  // and, at the end, the number of points three times
  std::vector<Entry> entries_;        // all points, slot by slot
  std::vector<uint32_t> slot_;        // of every point
  std::vector<uint32_t> partners_;    // kMost a point
  std::vector<uint8_t> partner_count_;
  std::vector<vec3> searched_at_;  // where the points were at the last search
  std::vector<Place> places_;      // copies, so that a partner is one access
  std::vector<Correction> corrections_;
};

}  // namespace sinew
