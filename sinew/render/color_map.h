// Colours that stand for numbers.
#pragma once

#include <array>
#include <cstdint>

namespace sinew {

using Color8 = std::array<uint8_t, 3>;  // sRGB

// A perceptually uniform map of 0..1 from black through violet, red and orange to pale yellow:
// equal steps look equally large, and it stays ordered in greyscale. Values outside are clamped,
// NaN is 0.
Color8 heat_color(float value);

// Colours for indices, neighbours well apart, all about equally light.
Color8 index_color(uint32_t index);

}  // namespace sinew
