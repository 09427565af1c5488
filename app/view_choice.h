// What a finished picture shows (`--view`), and which layers an .exr holds (`--layers`).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/render/layers.h"
#include "sinew/render/views.h"

namespace sinew::app {

enum class View : uint8_t { shaded, heatmap, boxes, normals, depth, objects };

struct ViewChoice {
  View view = View::shaded;
  uint32_t level = 0;  // boxes: how many steps below the root
  uint32_t scale = 0;  // heatmap: steps of the brightest colour; 0: a round number that all but
                       // a few pixels of the frame stay below

  bool wants_light() const { return view == View::shaded || view == View::boxes; }
};

// "shaded", "heatmap", "heatmap=200", "boxes=3", "normals", "depth", "objects".
Result<ViewChoice> parse_view(std::string_view text);

// "all", or names of layers with commas between them: "color,depth,normal".
Result<LayerChoice> parse_layers(std::string_view text);

// The layers that the view is made from, which leaves color for what it needs of light.
LayerChoice layers_for(const ViewChoice& choice);

// What a view showed, in numbers.
struct ViewRecord {
  std::optional<StepSummary> steps;  // heatmap
  uint32_t scale = 0;                // heatmap: steps of the brightest colour
  std::optional<size_t> boxes;       // boxes: how many there are at the level
};

// Makes the view in `picture`, which holds the shaded picture where the view wants light.
ViewRecord draw_view(const ViewChoice& choice, const World& world, const CameraView& camera,
                     const FrameLayers& layers, Image8& picture);

}  // namespace sinew::app
