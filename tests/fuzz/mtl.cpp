// Material libraries of OBJ files.
#include "sinew/io/obj/mtl.h"

#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  for (const bool strict : {false, true}) {
    std::vector<std::string> warnings;
    sinew::fuzz::check_error(
        sinew::parse_mtl(sinew::fuzz::as_text(data, size), "a.mtl", strict, warnings));
  }
  return 0;
}
