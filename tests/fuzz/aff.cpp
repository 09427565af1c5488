// AFF scenes: a top file, a file that it may include, and a texture, with a zero byte between them.
// The reader takes paths, so they are written to a folder of their own, where TMPDIR says.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "fuzz.h"

namespace {

namespace fs = std::filesystem;

fs::path make_folder() {
  std::string pattern = (fs::temp_directory_path() / "fuzz_aff_XXXXXX").string();
  sinew::fuzz::require(::mkdtemp(pattern.data()) != nullptr, "no folder for AFF files");
  fs::create_directory(fs::path(pattern) / "aff");
  fs::create_directory(fs::path(pattern) / "TextureFiles");
  return pattern;
}

std::string_view take_part(std::string_view& rest) {
  const std::string_view part = rest.substr(0, rest.find('\0'));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return part;
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fs::path folder = make_folder();
  std::string_view rest = sinew::fuzz::as_text(data, size);
  const std::string top = (folder / "aff/a.aff").string();
  std::ofstream(top, std::ios::binary) << take_part(rest);
  std::ofstream(folder / "aff/b.aff", std::ios::binary) << take_part(rest);
  std::ofstream(folder / "TextureFiles/t.ppm", std::ios::binary) << rest;
  sinew::fuzz::check_scene(sinew::load(top, sinew::fuzz::kLimited));
  return 0;
}
