// Pictures to keep of octrees larger than memory (PagingOptions::settle) are drawn again until what
// their rays ask for is there.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/world/world.h"

namespace sinew {

class Settling {
 public:
  // To be made when the picture begins.
  Settling(const World& world, std::span<const Svo> octrees);

  // Waits for what the picture asked for. Whether it is to be drawn again: something came or went
  // while it was drawn. 32 times at most, and a few if what it asks for does not fit; what it shows
  // then is counted (PagingStats::unsettled).
  bool again();

 private:
  const World& world_;
  std::span<const Svo> octrees_;
  uint64_t epoch_ = 0;  // when the picture was begun
  int times_ = 1;
  int times_short_ = 0;  // ... after which something did not fit
};

}  // namespace sinew
