// PC2 and MDD vertex caches.
#include "sinew/io/vertex_cache.h"

#include "fuzz.h"

namespace {

void check(const sinew::Result<sinew::VertexCache>& cache) {
  sinew::fuzz::check_error(cache);
  if (!cache) return;
  sinew::fuzz::require(cache->points > 0 && !cache->times.empty(), "an empty cache");
  sinew::fuzz::require(cache->positions.size() == cache->points * cache->times.size(),
                       "a cache without some of its positions");
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes = sinew::fuzz::as_text(data, size);
  std::vector<std::string> warnings;
  check(sinew::parse_pc2(bytes, "a.pc2", warnings));
  check(sinew::parse_mdd(bytes, "a.mdd", warnings));
  return 0;
}
