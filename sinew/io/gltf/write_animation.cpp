#include "sinew/io/gltf/write_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "sinew/io/gltf/extras.h"

namespace sinew::gltf {
namespace {

const char* path_name(ChannelPath path) {
  switch (path) {
    case ChannelPath::translation:
      return "translation";
    case ChannelPath::rotation:
      return "rotation";
    case ChannelPath::scale:
    case ChannelPath::visibility:
      return "scale";
    case ChannelPath::weights:
      return "weights";
    case ChannelPath::cache_key:
      break;
  }
  return "";
}

const char* interpolation_name(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::step:
      return "STEP";
    case Interpolation::linear:
      return "LINEAR";
    case Interpolation::cubic_spline:
      return "CUBICSPLINE";
  }
  return "LINEAR";
}

// A spline needs two keys; one is a constant.
void simplify_spline(Channel& channel) {
  if (channel.interpolation != Interpolation::cubic_spline || channel.times.size() > 1) return;
  const auto value = channel.values.begin() + channel.width;
  channel.values = std::vector<float>(value, value + channel.width);
  channel.interpolation = Interpolation::step;
}

// glTF wants unit keys. Those of splines move as little as that allows, since it bends the curve.
void normalize_rotations(Channel& channel) {
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  const double tolerance = cubic ? 1e-3 : 1e-7;
  const size_t per_key = cubic ? 12 : 4;
  for (size_t key = 0; key < channel.times.size(); ++key) {
    float* const first = &channel.values[key * per_key];
    float* const q = cubic ? first + 4 : first;
    const double size = length(glm::dvec4(q[0], q[1], q[2], q[3]));
    if (!(size > 0.0)) {
      q[3] = 1.0f;
    } else if (std::abs(size - 1.0) > tolerance) {
      for (size_t k = 0; k < per_key; ++k) first[k] = static_cast<float>(double{first[k]} / size);
    }
  }
}

// The scale that shows and hides: 1 where the channel is above a half, else 0. Between keys of a
// linear channel the change is where it passes a half; splines count as linear.
Channel as_scale(const Channel& channel) {
  Channel result;
  result.node = channel.node;
  result.path = ChannelPath::visibility;
  result.interpolation = Interpolation::step;
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  const auto value = [&](size_t key) { return channel.values[cubic ? 3 * key + 1 : key]; };
  const auto add = [&](float time, bool shown) {
    if (!result.times.empty() && time <= result.times.back()) return;
    result.times.push_back(time);
    result.values.insert(result.values.end(), 3, shown ? 1.0f : 0.0f);
  };
  for (size_t key = 0; key < channel.times.size(); ++key) {
    const bool shown = value(key) > 0.5f;
    const bool step = channel.interpolation == Interpolation::step;
    if (key > 0 && !step && shown != (value(key - 1) > 0.5f)) {
      const double u =
          (0.5 - double{value(key - 1)}) / (double{value(key)} - double{value(key - 1)});
      add(static_cast<float>(
              glm::mix(double{channel.times[key - 1]}, double{channel.times[key]}, u)),
          shown);
    }
    add(channel.times[key], shown);
  }
  return result;
}

class AnimationWriter {
 public:
  AnimationWriter(const WriteContext& context, std::span<const NodeOutput> places,
                  std::span<const MeshOutput> meshes, const std::vector<MeshCache>& caches)
      : context_(context), places_(places), meshes_(meshes), caches_(caches) {}

  // Null if the clip moves nothing.
  JsonOut write(Clip clip);

 private:
  void make_times_positive(Clip& clip) const;
  bool is_written(const Channel& channel) const;
  void add_channel(Channel channel, JsonOut& out);
  void add_cache_keys(const Channel& channel, JsonOut& out) const;
  void add_hold(const Clip& clip, JsonOut& out);
  void add_extent(const Clip& clip, JsonOut& out) const;
  uint32_t times_accessor(const std::vector<float>& times);

  const WriteContext& context_;
  std::span<const NodeOutput> places_;
  std::span<const MeshOutput> meshes_;
  const std::vector<MeshCache>& caches_;
  std::map<std::vector<float>, uint32_t> times_;  // channels often share them
};

// Clips may begin before 0, glTF animations may not.
void AnimationWriter::make_times_positive(Clip& clip) const {
  double first = clip.start;
  for (const Channel& channel : clip.channels) {
    first = std::min(first, double{channel.times.front()});
  }
  if (first >= 0.0) return;
  context_.warnings.add(element("clip", clip.name),
                        fmt::format("begins at {:g} s; moved to begin at 0", first));
  clip.start -= first;
  clip.end -= first;
  for (Channel& channel : clip.channels) {
    float last = -1.0f;
    for (float& time : channel.times) {
      time = static_cast<float>(double{time} - first);
      if (time <= last) time = std::nextafter(last, std::numeric_limits<float>::infinity());
      last = time;
    }
  }
}

// Whether the node has in the file what the channel moves.
bool AnimationWriter::is_written(const Channel& channel) const {
  if (channel.path != ChannelPath::weights && channel.path != ChannelPath::cache_key) return true;
  if (context_.scene.nodes[channel.node].octree >= 0) return context_.embedded;
  const size_t mesh = static_cast<size_t>(context_.scene.nodes[channel.node].mesh);
  const bool cached = caches_[mesh].keys > 0;
  return meshes_[mesh].json_mesh >= 0 && cached == (channel.path == ChannelPath::cache_key);
}

uint32_t AnimationWriter::times_accessor(const std::vector<float>& times) {
  const auto [place, is_new] = times_.try_emplace(times, 0);
  if (is_new) {
    place->second =
        context_.asset.add_values(Pool::animations, times, element_type<float>(), Limits::stated);
  }
  return place->second;
}

void AnimationWriter::add_channel(Channel channel, JsonOut& out) {
  const NodeOutput& place = places_[channel.node];
  uint32_t node = place.main;
  if (channel.path == ChannelPath::visibility) {
    channel = as_scale(channel);
    node = static_cast<uint32_t>(place.visibility);
  }
  simplify_spline(channel);
  ElementType type{ComponentType::f32, "VEC3", 3};
  if (channel.path == ChannelPath::rotation) {
    normalize_rotations(channel);
    type = {ComponentType::f32, "VEC4", 4};
  } else if (channel.path == ChannelPath::weights) {
    type = {ComponentType::f32, "SCALAR", 1};
  }
  const uint32_t output = context_.asset.add_values(Pool::animations, channel.values, type);
  JsonOut sampler = {{"input", times_accessor(channel.times)}, {"output", output}};
  sampler["interpolation"] = interpolation_name(channel.interpolation);
  out["channels"].push_back({{"sampler", out["samplers"].size()},
                             {"target", {{"node", node}, {"path", path_name(channel.path)}}}});
  out["samplers"].push_back(std::move(sampler));
}

void AnimationWriter::add_cache_keys(const Channel& channel, JsonOut& out) const {
  JsonOut json = {{"node", places_[channel.node].main},
                  {"interpolation", interpolation_name(channel.interpolation)}};
  for (const float time : channel.times) json["times"].push_back(double{time});
  for (const float value : channel.values) json["values"].push_back(double{value});
  out["extras"]["sinew_cache_keys"].push_back(std::move(json));
}

// glTF has no animation without channels; one that keeps the first node with a mesh where it is
// makes other programs show the clip's name and length.
void AnimationWriter::add_hold(const Clip& clip, JsonOut& out) {
  const Scene& scene = context_.scene;
  Channel channel;
  channel.node = scene.objects.empty() ? 0 : scene.objects[0].node;
  channel.interpolation = Interpolation::step;
  JsonOut& node = context_.asset.root()["nodes"][places_[channel.node].main];
  std::vector<float> rest = {0.0f, 0.0f, 0.0f};
  if (node.contains("translation")) rest = node["translation"].get<std::vector<float>>();
  for (const double time : {clip.start, clip.end}) {
    const float rounded = static_cast<float>(time);
    if (!channel.times.empty() && rounded <= channel.times.back()) continue;
    channel.times.push_back(rounded);
    channel.values.insert(channel.values.end(), rest.begin(), rest.end());
  }
  add_channel(channel, out);
  out["channels"].back()["extras"] = {{kHoldExtra, true}};
}

void AnimationWriter::add_extent(const Clip& clip, JsonOut& out) const {
  float first = std::numeric_limits<float>::max(), last = std::numeric_limits<float>::lowest();
  for (const Channel& channel : clip.channels) {
    first = std::min(first, channel.times.front());
    last = std::max(last, channel.times.back());
  }
  if (first == static_cast<float>(clip.start) && last == static_cast<float>(clip.end)) return;
  out["extras"]["sinew_start"] = clip.start;
  out["extras"]["sinew_end"] = clip.end;
}

JsonOut AnimationWriter::write(Clip clip) {
  make_times_positive(clip);
  std::erase_if(clip.channels, [&](const Channel& channel) { return !is_written(channel); });
  // Of two channels for one property the later one counts.
  std::set<std::pair<uint32_t, ChannelPath>> seen;
  std::vector<Channel> channels;
  for (auto channel = clip.channels.rbegin(); channel != clip.channels.rend(); ++channel) {
    if (seen.insert({channel->node, channel->path}).second) channels.push_back(std::move(*channel));
  }
  std::reverse(channels.begin(), channels.end());
  clip.channels = std::move(channels);
  if (places_.empty() || (clip.channels.empty() && clip.end == clip.start)) return {};

  JsonOut out = named(clip.name);
  out["channels"] = JsonOut::array();
  out["samplers"] = JsonOut::array();
  for (const Channel& channel : clip.channels) {
    if (channel.path == ChannelPath::cache_key) {
      add_cache_keys(channel, out);
    } else {
      add_channel(channel, out);
    }
  }
  if (out["channels"].empty()) add_hold(clip, out);
  add_extent(clip, out);
  return out;
}

}  // namespace

uint32_t write_animations(const WriteContext& context, std::span<const Clip> clips,
                          std::span<const NodeOutput> places, std::span<const MeshOutput> meshes,
                          const std::vector<MeshCache>& caches) {
  AnimationWriter writer(context, places, meshes, caches);
  uint32_t count = 0;
  for (const Clip& clip : clips) {
    JsonOut json = writer.write(clip);
    if (json.is_null()) {
      context.warnings.add(element("clip", clip.name), "moves nothing; left out");
      continue;
    }
    context.asset.add("animations", std::move(json));
    ++count;
  }
  return count;
}

}  // namespace sinew::gltf
