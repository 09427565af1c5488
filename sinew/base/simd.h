// The one door to Highway, for *_kernels.cpp files only. Each includes this before Highway's own
// headers; see bvh/trace/traverse_kernels.cpp for the pattern. One build holds every target; the
// best one that the machine has is chosen at run time.
#pragma once

// SSSE3 without SSE4.1 exists on no machine of the last fifteen years.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
