// L's two tables: reconstruction and ray tracing times of L's updates and ours, over bodies whose
// vertices are given anew each frame.
// Based on: T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy Updates for
// Ray Tracing of Deformable Models", 2003, section 4. Ray tracing here is the ray queries alone,
// without shading, and all engines answer the same rays.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sinew/base/error.h"
#include "sinew/bvh/larsson/larsson.h"

namespace sinew::bench {

struct LarssonOptions {
  std::string museum = "../shared/data/bart/scene_museum/aff/museum5.aff";  // of table 2
  uint32_t width = 640;
  uint32_t height = 480;
  uint32_t frames = 28;       // of the animation's, evenly spread; table 1 always has frame 200
  uint32_t repeats = 3;       // of frames with less than a ray a pixel; medians count
  int threads = 2;            // of our second rows; L's and our first rows have one
  larsson::Config larsson{};  // of L's hierarchies
};

// Nine free bodies of 81,920 triangles.
Result<nlohmann::json> larsson_table_1(const LarssonOptions& options);
// BART's Museum, its art piece of 65,536 triangles with one hierarchy for each of its five keys.
Result<nlohmann::json> larsson_table_2(const LarssonOptions& options);

// The report as a table like L's.
std::string larsson_text(const nlohmann::json& report);

}  // namespace sinew::bench
