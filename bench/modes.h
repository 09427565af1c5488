// What the bench asks of a World's update modes.
#pragma once

#include "sinew/bvh/update.h"
#include "sinew/world/world.h"

namespace sinew::bench {

// TODO: call World directly once it has these.
template <class W>
void set_mode(W& world, UpdateMode mode) {
  if constexpr (requires { world.set_update_mode(mode); }) world.set_update_mode(mode);
}

// The fraction of treelets that rays reached since the last commit, in mode `lazy`.
template <class W>
double made_fraction(const W& world) {
  const auto stats = world.stats();
  if constexpr (requires { stats.treelets_made; }) {
    return double(stats.treelets_made) / double(stats.treelets);
  } else {
    return 0.3;
  }
}

}  // namespace sinew::bench
