#include "sinew/io/gltf/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "sinew/io/gltf/affine.h"
#include "sinew/io/gltf/extras.h"

namespace sinew::gltf {
namespace {

std::optional<ChannelPath> path_of(const std::string& name) {
  if (name == "translation") return ChannelPath::translation;
  if (name == "rotation") return ChannelPath::rotation;
  if (name == "scale") return ChannelPath::scale;
  if (name == "weights") return ChannelPath::weights;
  return std::nullopt;
}

// Makes times rise strictly. Two keys at one time are a jump: the second moves to the next float,
// or goes if it repeats the first. Keys before an earlier one go; returns how many those were.
size_t order_keys(Channel& channel) {
  const std::ptrdiff_t per_key = std::ssize(channel.values) / std::ssize(channel.times);
  const auto values_of = [&](size_t key) {
    return channel.values.begin() + static_cast<std::ptrdiff_t>(key) * per_key;
  };
  size_t kept = 1;
  size_t out_of_order = 0;
  float latest = channel.times[0];  // as the file says
  for (size_t key = 1; key < channel.times.size(); ++key) {
    const float time = channel.times[key];
    const bool repeats =
        time == latest && std::equal(values_of(key), values_of(key) + per_key, values_of(kept - 1));
    out_of_order += time < latest;
    if (time < latest || repeats) continue;
    const float after_last =
        std::nextafter(channel.times[kept - 1], std::numeric_limits<float>::infinity());
    channel.times[kept] = std::max(time, after_last);
    std::copy_n(values_of(key), per_key, values_of(kept));
    latest = time;
    ++kept;
  }
  channel.times.resize(kept);
  channel.values.resize(kept * static_cast<size_t>(per_key));
  return out_of_order;
}

// Keys without direction would leave the sampler nothing to normalise. Returns how many there were.
size_t repair_rotations(Channel& channel) {
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  size_t repaired = 0;
  for (size_t key = 0; key < channel.times.size(); ++key) {
    float* q = &channel.values[cubic ? key * 12 + 4 : key * 4];
    const double size = length(glm::dvec4(q[0], q[1], q[2], q[3]));
    if (size > 1e-12) continue;
    q[0] = q[1] = q[2] = 0.0f;
    q[3] = 1.0f;
    ++repaired;
  }
  return repaired;
}

class AnimationReader {
 public:
  AnimationReader(const Reader& reader, std::span<const NodePlace> places, Scene& scene)
      : reader_(reader), places_(places), scene_(scene) {}

  Result<Clip> read(const Json& json, size_t index);

 private:
  Result<void> read_channel(const Json& json, std::span<const Json> samplers, Clip& clip);
  Result<void> read_keys(const Json& sampler, Channel& channel);
  bool make_animatable(const Json& json, Node& node);
  Result<void> as_visibility(const Json& json, Channel& channel);

  const Reader& reader_;
  std::span<const NodePlace> places_;
  Scene& scene_;
};

// Fills times, values and interpolation; node, path and width are set.
Result<void> AnimationReader::read_keys(const Json& sampler, Channel& channel) {
  SINEW_TRY(channel.interpolation, interpolation_of(sampler));
  SINEW_TRY(const Accessor input, reader_.accessors.find(sampler, "input", 1, Numbers::real));
  const bool by_component = channel.path == ChannelPath::weights;
  const uint32_t components = by_component ? 1 : channel.width;
  SINEW_TRY(const Accessor output,
            reader_.accessors.find(sampler, "output", components, Numbers::real_or_normalized));
  const uint64_t parts = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
  const uint64_t wanted = uint64_t{input.count} * channel.width * parts;
  if (uint64_t{output.count} * components != wanted) {
    return output.json.error(fmt::format("has {} numbers as output of {}; {} keys need {}",
                                         uint64_t{output.count} * components, sampler.element(),
                                         input.count, wanted));
  }
  SINEW_TRY(channel.times, read_vector<float>(reader_, input));
  SINEW_CHECKED(reader_.budget.take(sampler, wanted, sizeof(float)));
  channel.values.resize(wanted);
  return sinew::gltf::read(output, std::span<float>(channel.values));
}

// Gives a node that has a matrix the translation, rotation and scale that make it.
bool AnimationReader::make_animatable(const Json& json, Node& node) {
  if (!node.has_matrix) return true;
  const auto transform = decompose(node.matrix);
  if (!transform) {
    reader_.warnings.add(json.element(), "animates a node with a shearing matrix; ignored");
    return false;
  }
  node.has_matrix = false;
  node.translation = transform->translation;
  node.rotation = transform->rotation;
  node.scale = transform->scale;
  return true;
}

// The scale of a node that only shows and hides: of x, y, z the first says it all.
Result<void> AnimationReader::as_visibility(const Json& json, Channel& channel) {
  if (channel.path != ChannelPath::scale || channel.interpolation != Interpolation::step) {
    return json.error("animates more than the visibility of a node made for that");
  }
  channel.path = ChannelPath::visibility;
  channel.width = 1;
  for (size_t key = 0; key < channel.times.size(); ++key) {
    channel.values[key] = channel.values[3 * key];
  }
  channel.values.resize(channel.times.size());
  return {};
}

Result<void> AnimationReader::read_channel(const Json& json, std::span<const Json> samplers,
                                           Clip& clip) {
  if (has_flag(json, kHoldExtra)) return {};
  SINEW_TRY(const Json target, json.object("target"));
  SINEW_TRY(const std::string path_name, target.text("path"));
  SINEW_TRY(const auto json_node, target.index("node", places_.size()));
  const std::optional<ChannelPath> path = path_of(path_name);
  if (!path || !json_node) {
    reader_.warnings.add(json.element(),
                         fmt::format("animates \"{}\", which is not supported", path_name));
    return {};
  }
  const NodePlace& place = places_[*json_node];
  if (place.node < 0) {
    reader_.warnings.add(json.element(), "animates a node outside the scene; ignored");
    return {};
  }
  Channel channel;
  channel.path = *path;
  channel.node = static_cast<uint32_t>(place.node);
  channel.width = *path == ChannelPath::rotation ? 4 : 3;
  if (*path == ChannelPath::weights) {
    channel.width = static_cast<uint32_t>(targets_of(scene_, scene_.nodes[place.first_mesh]));
    if (channel.width == 0) {
      reader_.warnings.add(json.element(), "animates weights of a mesh without targets; ignored");
      return {};
    }
  } else if (!place.visibility && !make_animatable(json, scene_.nodes[channel.node])) {
    return {};
  }
  SINEW_TRY(const uint32_t sampler, json.required_index("sampler", samplers.size()));
  SINEW_CHECKED(read_keys(samplers[sampler], channel));
  if (order_keys(channel) > 0) {
    reader_.warnings.add(json.element(), "has keys out of order in time; they were left out");
  }
  if (*path == ChannelPath::rotation && repair_rotations(channel) > 0) {
    reader_.warnings.add(json.element(), "a rotation has no length; taken as no rotation");
  }
  if (place.visibility) {
    SINEW_CHECKED(as_visibility(json, channel));
  }
  if (*path != ChannelPath::weights) {
    clip.channels.push_back(std::move(channel));
    return {};
  }
  for (uint32_t i = 0; i < place.mesh_count; ++i) {  // all instances morph alike
    channel.node = place.first_mesh + i;
    SINEW_CHECKED(reader_.budget.take(json, channel.values.size(), sizeof(float)));
    clip.channels.push_back(channel);
  }
  return {};
}

Result<Clip> AnimationReader::read(const Json& json, size_t index) {
  Clip clip;
  SINEW_TRY(clip.name, json.text("name"));
  if (clip.name.empty()) clip.name = fmt::format("clip {}", index);
  const std::string prefix = json.element() + " ";
  SINEW_TRY(const std::vector<Json> samplers, json.objects("samplers", "sampler", prefix));
  SINEW_TRY(const std::vector<Json> channels, json.objects("channels", "channel", prefix));
  for (const Json& channel : channels) {
    SINEW_CHECKED(read_channel(channel, samplers, clip));
  }
  SINEW_CHECKED(read_cache_keys(reader_, json, places_, scene_, clip));
  if (clip.channels.empty()) return clip;
  clip.start = std::numeric_limits<double>::max();
  clip.end = std::numeric_limits<double>::lowest();
  for (const Channel& channel : clip.channels) {
    clip.start = std::min(clip.start, double{channel.times.front()});
    clip.end = std::max(clip.end, double{channel.times.back()});
  }
  SINEW_CHECKED(read_extent(json, clip));
  return clip;
}

}  // namespace

Result<Interpolation> interpolation_of(const Json& sampler) {
  SINEW_TRY(const std::string name, sampler.text("interpolation", "LINEAR"));
  if (name == "STEP") return Interpolation::step;
  if (name == "LINEAR") return Interpolation::linear;
  if (name == "CUBICSPLINE") return Interpolation::cubic_spline;
  return sampler.error("\"interpolation\" is \"" + name + "\", not STEP, LINEAR or CUBICSPLINE");
}

Result<void> read_animations(const Reader& reader, std::span<const NodePlace> places,
                             Scene& scene) {
  SINEW_TRY(const std::vector<Json> animations,
            reader.asset.root().objects("animations", "animation"));
  AnimationReader animation_reader(reader, places, scene);
  for (size_t i = 0; i < animations.size(); ++i) {
    SINEW_TRY(scene.clips.emplace_back(), animation_reader.read(animations[i], i));
  }
  return {};
}

}  // namespace sinew::gltf
