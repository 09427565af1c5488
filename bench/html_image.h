// Pictures in a report's page.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sinew/base/error.h"
#include "sinew/scene/image.h"

namespace sinew::bench {

std::string base64(std::span<const uint8_t> bytes);

// As a <figure> that needs nothing else; `words` stand below it.
Result<std::string> html_image(const Image8& image, const std::string& words);

}  // namespace sinew::bench
