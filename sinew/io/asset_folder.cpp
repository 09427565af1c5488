#include "sinew/io/asset_folder.h"

#include <algorithm>

namespace sinew {

namespace fs = std::filesystem;

fs::path asset_folder(const fs::path& path) {
  std::error_code failed;
  const fs::path absolute = fs::absolute(path, failed);
  return fs::weakly_canonical(absolute.parent_path(), failed);
}

std::optional<fs::path> within_folder(const fs::path& folder, std::string_view name) {
  if (name.empty() || name.find('\0') != std::string_view::npos) return std::nullopt;
  std::error_code failed;
  const fs::path file = fs::weakly_canonical(folder / name, failed);
  if (failed) return std::nullopt;
  const auto [end_of_folder, rest] =
      std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  if (end_of_folder != folder.end() || rest == file.end()) return std::nullopt;
  return file;
}

}  // namespace sinew
