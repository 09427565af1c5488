// PLY.
#include "sinew/io/ply/parse.h"

#include "fuzz.h"
#include "sinew/io/polygon/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = sinew::fuzz::kFolder + "a.ply";
  auto model = sinew::parse_ply(sinew::fuzz::as_text(data, size), path, sinew::fuzz::kLimited);
  sinew::fuzz::check_error(model);
  if (!model) return 0;
  sinew::fuzz::check_scene(
      sinew::make_polygon_scene(std::move(*model), path, sinew::fuzz::kLimited));
  return 0;
}
