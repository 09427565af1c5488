#include "app/view_choice.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "app/values.h"
#include "sinew/render/box_lines.h"

namespace sinew::app {
namespace {

constexpr double kMostLevels = 200;  // deeper than any tree
constexpr double kMostSteps = 1e9;

constexpr struct {
  const char* name;
  View view;
} kViews[] = {{"shaded", View::shaded},   {"heatmap", View::heatmap}, {"boxes", View::boxes},
              {"normals", View::normals}, {"depth", View::depth},     {"objects", View::objects}};

constexpr struct {
  const char* name;
  bool LayerChoice::*chosen;
} kLayers[] = {{"color", &LayerChoice::color},         {"depth", &LayerChoice::depth},
               {"normal", &LayerChoice::normal},       {"object", &LayerChoice::object},
               {"primitive", &LayerChoice::primitive}, {"traversal", &LayerChoice::traversal}};

constexpr LayerChoice kNone{false, false, false, false, false, false};

tl::unexpected<Error> usage(std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", "", std::move(problem), std::move(remedy)});
}

std::optional<uint32_t> whole_number(std::string_view text, double least, double most) {
  const auto number = parse_number(text);
  if (!number || *number < least || *number > most || *number != std::floor(*number)) return {};
  return static_cast<uint32_t>(*number);
}

}  // namespace

Result<ViewChoice> parse_view(std::string_view text) {
  const size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  const auto found = std::find_if(std::begin(kViews), std::end(kViews),
                                  [&](const auto& view) { return name == view.name; });
  if (found == std::end(kViews)) {
    return usage(fmt::format("--view '{}' is unknown", text),
                 "use shaded, heatmap, boxes=LEVEL, normals, depth or objects");
  }
  ViewChoice choice{.view = found->view};
  const bool has_value = equals != text.npos;
  const std::string_view value = has_value ? text.substr(equals + 1) : "";
  if (choice.view == View::boxes) {
    const auto level = whole_number(value, 0.0, kMostLevels);
    if (!level) {
      return usage(fmt::format("--view {} lacks the level of the boxes", text),
                   "write boxes=0 for the whole, boxes=1 for its parts, and so on");
    }
    choice.level = *level;
  } else if (choice.view == View::heatmap && has_value) {
    const auto scale = whole_number(value, 1.0, kMostSteps);
    if (!scale) {
      return usage(fmt::format("--view {}: '{}' is no number of steps", text, value),
                   "write heatmap, or heatmap=200 for the same scale in every picture");
    }
    choice.scale = *scale;
  } else if (has_value) {
    return usage(fmt::format("--view {} takes no value", name), fmt::format("write {}", name));
  }
  return choice;
}

Result<LayerChoice> parse_layers(std::string_view text) {
  if (text == "all") return LayerChoice{};
  LayerChoice choice = kNone;
  while (true) {
    const std::string_view name = text.substr(0, text.find(','));
    const auto found = std::find_if(std::begin(kLayers), std::end(kLayers),
                                    [&](const auto& layer) { return name == layer.name; });
    if (found == std::end(kLayers)) {
      return usage(fmt::format("--layers: '{}' is no layer", name),
                   "use color, depth, normal, object, primitive, traversal, or all");
    }
    choice.*found->chosen = true;
    if (name.size() == text.size()) return choice;
    text.remove_prefix(name.size() + 1);
  }
}

LayerChoice layers_for(const ViewChoice& choice) {
  LayerChoice layers = kNone;
  layers.color = choice.wants_light();
  layers.traversal = choice.view == View::heatmap;
  layers.depth = choice.view == View::boxes || choice.view == View::depth;
  layers.normal = choice.view == View::normals || choice.view == View::objects;
  layers.object = choice.view == View::objects;
  return layers;
}

ViewRecord draw_view(const ViewChoice& choice, const World& world, const CameraView& camera,
                     const FrameLayers& layers, Image8& picture) {
  ViewRecord record;
  switch (choice.view) {
    case View::shaded:
      break;
    case View::heatmap:
      record.steps = summarize_steps(layers.traversal);
      record.scale = choice.scale > 0 ? choice.scale : round_scale(record.steps->high);
      draw_heatmap(layers, record.scale, picture);
      break;
    case View::boxes:
      record.boxes = draw_boxes(world, choice.level, camera, layers.depth, picture);
      break;
    case View::normals:
      draw_normals(layers, picture);
      break;
    case View::depth:
      draw_depth(layers, picture);
      break;
    case View::objects:
      draw_objects(layers, camera, picture);
      break;
  }
  return record;
}

}  // namespace sinew::app
