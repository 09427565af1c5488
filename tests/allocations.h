// Counts what operator new is asked for. Sanitizers bring their own: then nothing is counted.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SINEW_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define SINEW_SANITIZED 1
#endif
#endif

namespace sinew::test {

// From any thread, from start_counting() on.
void start_counting();
int stop_counting();

}  // namespace sinew::test
