#include "sinew/render/settling.h"

#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

// What hides others may become smaller with its detail, and rays from cells go elsewhere than those
// from voxels, so that one time is not always enough.
constexpr int kMostTimes = 32;
// Blocks that do not fit at once may take turns; but what a picture of cells asks for, that of
// voxels may not need.
constexpr int kMostShort = 4;

}  // namespace

Settling::Settling(const World& world, std::span<const Svo> octrees)
    : world_(world), octrees_(octrees), epoch_(paging_epoch(octrees)) {}

bool Settling::again() {
  settle_paging(octrees_);
  const uint64_t begun = epoch_;
  epoch_ = paging_epoch(octrees_);
  if (epoch_ == begun) return false;  // all of it showed the same, and nothing finer comes
  world_.refresh_octrees();
  if (paging_stats(octrees_).missing > 0) ++times_short_;
  if (++times_ <= kMostTimes && times_short_ <= kMostShort) return true;
  give_up_paging(octrees_);
  return false;
}

}  // namespace sinew
