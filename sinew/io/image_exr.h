// OpenEXR: pictures of linear floats and integers in named channels, "R" or "depth.Z", of which
// those with a common prefix form a layer.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/image_file.h"
#include "sinew/math/vec.h"

namespace sinew {

enum class ExrType : uint8_t { uint32, half, float32 };

// A channel to be written: a view of one value a pixel, rows from the top.
struct ExrChannel {
  std::string name;
  ExrType type =
      ExrType::float32;  // in the file; integers must be uint32, floats one of the others
  std::variant<const float*, const uint32_t*> first;
  size_t stride = 1;  // values from one pixel to the next
};

// What a file says about itself beside its pixels. The matrices are for column vectors; files hold
// them as OpenEXR's standard attributes of the same name define them.
struct ExrAttributes {
  ImageMetadata texts;
  std::optional<mat4> world_to_camera;  // left-handed: x right, y up, z into the picture
  std::optional<mat4> world_to_ndc;     // x and y from 0, 0 (upper left) to 1, 1 (lower right)
};

// Losslessly compressed, written as a whole or not at all, as write_png does. Floats beyond the
// range of half become the largest half, so that no infinity appears that was none.
Result<void> write_exr(const std::string& path, ImageSize size,
                       std::span<const ExrChannel> channels, const ExrAttributes& attributes = {});

// One channel in memory; either floats or integers is filled.
struct ExrPlane {
  std::string name;
  ExrType type = ExrType::float32;  // in the file
  std::vector<float> floats;
  std::vector<uint32_t> integers;
};

struct ExrImage {
  ImageSize size;
  std::vector<ExrPlane> planes;  // sorted by name
  ExrAttributes attributes;

  const ExrPlane* find(std::string_view name) const;  // null if there is none
};

bool is_exr(std::span<const uint8_t> bytes);  // begins as an EXR file does

// The first part of a flat image, scan lines or tiles. Refused: deep images, subsampled channels,
// more than kMaxImageSide a side, and files too short for the pixels they claim.
Result<ExrImage> read_exr(const std::string& path);
Result<ExrImage> decode_exr(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace sinew
