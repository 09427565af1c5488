// MagicaVoxel's files.
#include "sinew/io/vox/vox.h"

#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sinew::fuzz::check_scene(
      sinew::parse_vox({data, size}, sinew::fuzz::kFolder + "a.vox", sinew::fuzz::kLimited));
  return 0;
}
