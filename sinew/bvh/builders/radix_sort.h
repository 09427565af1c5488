// Parallel radix sort of Morton codes with their primitives.
#pragma once

#include <cstdint>
#include <vector>

namespace sinew {

struct CodedPrimitive {
  uint32_t code;  // below 2^30
  uint32_t primitive;
};

// By code; equal codes stay in their order, so the result does not depend on the thread count.
// `scratch` is resized and holds nothing of use afterwards.
void radix_sort(std::vector<CodedPrimitive>& items, std::vector<CodedPrimitive>& scratch);

}  // namespace sinew
