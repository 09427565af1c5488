#include "sinew/io/gltf/uri.h"

#include <algorithm>
#include <cctype>
#include <cstdint>

#include "sinew/io/asset_folder.h"

namespace sinew::gltf {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

tl::expected<std::string, std::string> decode_base64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return tl::unexpected<std::string>("its base64 data holds a wrong character");
    bits = (bits << 6 | static_cast<uint32_t>(digit)) & 0xffffff;
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes.push_back(static_cast<char>(bits >> bit_count & 0xff));
    }
  }
  if (bit_count >= 6) return tl::unexpected<std::string>("its base64 data is cut off");
  return bytes;
}

// "http:", "file:" and their like, also "C:".
bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + colon, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' || c == '.';
  });
}

}  // namespace

bool is_data_uri(std::string_view uri) {
  return uri.substr(0, 5) == "data:";
}

tl::expected<std::string, std::string> decode_data_uri(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) {
    return tl::unexpected<std::string>("its data URI has no comma before the data");
  }
  const std::string_view media = uri.substr(0, comma);
  const std::string_view data = uri.substr(comma + 1);
  const std::string_view base64 = ";base64";
  if (media.size() >= base64.size() && media.substr(media.size() - base64.size()) == base64) {
    return decode_base64(data);
  }
  return percent_decode(data);
}

std::string percent_decode(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 &&
                        hex_digit(text[i + 2]) >= 0;
    if (escape) {
      result.push_back(static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2])));
      i += 2;
    } else {
      result.push_back(text[i]);
    }
  }
  return result;
}

std::string percent_encode(std::string_view name) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string result;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        byte < 128 && (std::isalnum(byte) || c == '-' || c == '.' || c == '_' || c == '~');
    if (plain) {
      result.push_back(c);
    } else {
      result += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return result;
}

tl::expected<std::filesystem::path, std::string> file_of_uri(const std::filesystem::path& folder,
                                                             std::string_view uri) {
  if (has_scheme(uri)) {
    return tl::unexpected<std::string>("refers to \"" + std::string(uri) +
                                       "\", but only files in the asset's folder are read");
  }
  const std::string name = percent_decode(uri);
  const auto file = within_folder(folder, name);
  if (!file) {
    return tl::unexpected<std::string>("refers to \"" + name +
                                       "\", which is not a file within the asset's folder");
  }
  return *file;
}

}  // namespace sinew::gltf
