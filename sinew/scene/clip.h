// Animation clips: channels of keyed values on nodes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sinew {

enum class ChannelPath : uint8_t {
  translation,  // 3 values a key
  rotation,     // 4: quaternion x, y, z, w; LINEAR means slerp along the shorter arc
  scale,        // 3
  weights,      // one a morph target
  cache_key,    // 1: position in the vertex cache; 2.25 is a quarter of the way from key 2 to 3
  visibility,   // 1: shown if > 0.5; hides the whole subtree
};

enum class Interpolation : uint8_t { step, linear, cubic_spline };

// cubic_spline keys hold in-tangent, value, out-tangent (glTF 2.0, appendix C).
struct Channel {
  uint32_t node = 0;
  ChannelPath path = ChannelPath::translation;
  Interpolation interpolation = Interpolation::linear;
  uint32_t width = 3;         // values in one key (a third of it for each cubic_spline part)
  std::vector<float> times;   // seconds, strictly increasing, at least one
  std::vector<float> values;  // key-major: times.size() * width * (cubic_spline ? 3 : 1)
};

struct Clip {
  std::string name;
  double start = 0.0;  // seconds
  double end = 0.0;    // seconds, >= start
  std::vector<Channel> channels;
};

}  // namespace sinew
