// What all fuzz targets share. A target gets any bytes; it must end in an error of bad input or in
// a valid scene, without a sanitizer's finding and within the memory limit.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace sinew::fuzz {

inline constexpr LoadOptions kLimited{.memory_limit = uint64_t{64} << 20};
// Files that an input names are looked for here, where there are none.
inline const std::string kFolder = "/nonexistent/";

inline std::string_view as_text(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

inline void require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: %s\n", what.c_str());
  std::abort();
}

template <class T>
void check_error(const Result<T>& result) {
  if (result) return;
  require(result.error().kind == ErrorKind::bad_input, "not an error of bad input");
  require(!result.error().problem.empty(), "an error without a problem");
}

inline void check_scene(const Result<Scene>& scene) {
  check_error(scene);
  if (scene) require(validate(*scene).empty(), "an invalid scene: " + validate(*scene));
}

}  // namespace sinew::fuzz
