#include "bench/copies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/scene/sample.h"

namespace sinew::bench {
namespace {

constexpr float kSpacing = 1.1f;  // from copy to copy, in sizes of one

void add_nodes(const Scene& one, vec3 place, Scene& out) {
  const auto root = static_cast<int32_t>(out.nodes.size());
  const int32_t first = root + 1;
  const auto first_skin = static_cast<int32_t>(out.skins.size());
  Node holder;
  holder.name = "copy";
  holder.translation = place;
  out.nodes.push_back(holder);
  for (Node node : one.nodes) {
    node.parent = node.parent < 0 ? root : node.parent + first;
    if (node.skin >= 0) node.skin += first_skin;
    node.camera = node.light = -1;
    out.nodes.push_back(std::move(node));
  }
  for (Skin skin : one.skins) {
    for (uint32_t& joint : skin.joints) joint += static_cast<uint32_t>(first);
    out.skins.push_back(std::move(skin));
  }
}

void add_channels(const Clip& from, uint32_t first_node, Clip& out) {
  for (Channel channel : from.channels) {
    channel.node += first_node;
    out.channels.push_back(std::move(channel));
  }
}

}  // namespace

Scene copies_of(Scene one, uint32_t copies, std::span<const std::string_view> without) {
  for (Node& node : one.nodes) {
    if (std::ranges::find(without, std::string_view(node.name)) != without.end()) node.mesh = -1;
  }
  list_objects(one);
  Scene out;
  out.name = std::to_string(copies) + "*" + one.name;
  out.meshes = one.meshes;
  out.materials = one.materials;
  out.default_fps = one.default_fps;
  const vec3 size = animation_bounds(one, one.clips.empty() ? kRestPose : 0, 4).extent();
  const float step = kSpacing * std::max(size.x, size.z);
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
  Clip clip;
  clip.name = "Together";
  clip.end = one.clips.empty() ? 0.0 : one.clips[0].end;
  for (const Clip& c : one.clips) clip.end = std::min(clip.end, c.end);
  for (uint32_t k = 0; k < copies; ++k) {
    const auto first_node = static_cast<uint32_t>(out.nodes.size()) + 1;
    add_nodes(one, step * vec3(float(k % side), 0.0f, float(k / side)), out);
    if (!one.clips.empty()) add_channels(one.clips[k % one.clips.size()], first_node, clip);
  }
  if (!one.clips.empty()) out.clips.push_back(std::move(clip));
  list_objects(out);
  return out;
}

}  // namespace sinew::bench
