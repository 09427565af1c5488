// glTF: a .glb or .gltf file as it is; or, if the first byte is 0, the parts of a GLB file, see
// glb_parts.h.
#include "sinew/io/gltf/gltf.h"

#include "fuzz.h"
#include "glb_parts.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view input = sinew::fuzz::as_text(data, size);
  const bool parts = size > 0 && data[0] == 0;
  sinew::fuzz::check_scene(
      sinew::parse_gltf(parts ? sinew::fuzz::make_glb(input.substr(1)) : std::string(input),
                        sinew::fuzz::kFolder + "a.glb", sinew::fuzz::kLimited));
  return 0;
}
