// How much memory the program has, as the kernel counts it.
#pragma once

#include <cstdint>

namespace sinew {

// Bytes in memory now, and at the worst moment so far. 0 where the kernel does not tell.
uint64_t resident_bytes();
uint64_t peak_resident_bytes();

// Gives what was freed back to the kernel, so that it does not count any more.
void return_free_memory();

}  // namespace sinew
