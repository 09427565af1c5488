// Names of outputs: a file name with or without a frame counter, and what its ending means.
//   out_####.png  out_%04d.png  out_{frame:04}.png   ->  out_0007.png
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "sinew/base/error.h"

namespace sinew::app {

enum class OutputFormat { png, exr, webp, mp4 };

// One file for all frames rather than one a frame.
constexpr bool is_movie(OutputFormat format) {
  return format == OutputFormat::webp || format == OutputFormat::mp4;
}
const char* extension(OutputFormat format);  // "png" ...

struct OutputName {
  std::string path;  // as given; "-" is standard output
  OutputFormat format = OutputFormat::png;
  size_t counter_begin = 0;  // where the counter stands in path
  size_t counter_size = 0;   // 0: there is none
  int digits = 0;            // at least so many, zeros in front

  bool has_counter() const { return counter_size > 0; }
  bool is_stdout() const { return path == "-"; }
  std::string of_frame(int frame) const;
};

// `format` (an extension, or empty) overrides what the ending says. A counter counts only in the
// last part of the path.
Result<OutputName> parse_output_name(std::string_view path, std::string_view format = {});

}  // namespace sinew::app
