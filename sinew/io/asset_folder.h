// Files that an asset names must lie in the asset's own folder or below it.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace sinew {

// The folder of the file `path`, canonical.
std::filesystem::path asset_folder(const std::filesystem::path& path);

// The file that the relative `name` means within `folder` (canonical), or nothing if it lies
// outside. Links are followed before the check; the file need not exist.
std::optional<std::filesystem::path> within_folder(const std::filesystem::path& folder,
                                                   std::string_view name);

}  // namespace sinew
