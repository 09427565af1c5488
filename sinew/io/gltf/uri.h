// What a URI in a glTF file means: data within the URI (RFC 2397, base64 as in RFC 4648), or a file
// in the asset's own folder (see asset_folder.h).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace sinew::gltf {

bool is_data_uri(std::string_view uri);

// The bytes of a data URI, or what is wrong with it.
tl::expected<std::string, std::string> decode_data_uri(std::string_view uri);

// The file that a relative URI means, or why it may not be read. `folder` must be canonical; links
// are followed before the check. The file need not exist.
tl::expected<std::filesystem::path, std::string> file_of_uri(const std::filesystem::path& folder,
                                                             std::string_view uri);

// "%20" -> " "; a percent sign without two hexadecimal digits stands for itself.
std::string percent_decode(std::string_view text);

// Every byte of a file's name that has a meaning in URIs, or is no ASCII letter, digit or one of
// "-._~", becomes %XX.
std::string percent_encode(std::string_view name);

}  // namespace sinew::gltf
