// From what the files say to a scene: objects become nodes with meshes, keyframes become one clip.
#include "sinew/io/aff/aff.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <set>
#include <unordered_map>
#include <utility>

#include "sinew/io/aff/reader.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

using namespace aff;

constexpr uint64_t kBytesPerSplitTriangle = 200;  // with edges, while it is made, without keys

size_t content_hash(const Mesh& mesh) {
  const auto hash = [](const auto& values) {
    return std::hash<std::string_view>()(
        {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])});
  };
  size_t result = hash(mesh.positions) * 31 + hash(mesh.triangles);
  for (const MeshPart& part : mesh.parts) result = result * 31 + part.material;
  return result;
}

bool is_same(const Mesh& a, const Mesh& b) {
  const auto same_parts = [](const MeshPart& p, const MeshPart& q) {
    return p.material == q.material && p.flat == q.flat;
  };
  return a.name == b.name && a.positions == b.positions && a.triangles == b.triangles &&
         a.triangle_part == b.triangle_part && a.corners == b.corners && a.normals == b.normals &&
         a.texcoords[0] == b.texcoords[0] && std::ranges::equal(a.parts, b.parts, same_parts);
}

// Turns Content into nodes, meshes and channels of `scene`.
class Assembler {
 public:
  Assembler(Scene& scene, Content& content, const std::string& path, const AffOptions& aff,
            const LoadOptions& options)
      : scene_(scene), content_(content), path_(path), aff_(aff), options_(options) {}

  Result<void> run() {
    for (Object& object : content_.objects) {
      add_static(object);
      SINEW_CHECKED(add_animated(object));
    }
    if (aff_.complexity > 0 && !has_animated_) {
      return fail({ErrorKind::usage, path_, "complexity=" + std::to_string(aff_.complexity),
                   "there are no animated triangles (tpa)", "leave complexity out"});
    }
    SINEW_CHECKED(add_keyframes());
    set_timing();
    list_objects(scene_);
    scene_.name = std::filesystem::path(path_).stem().string() + derivation_;
    return {};
  }

 private:
  void add_static(Object& object) {
    if (object.mesh.triangle_count() == 0) return;
    Mesh mesh = object.mesh.take();
    mesh.name = object.name;
    std::vector<uint32_t>& similar = meshes_by_content_[content_hash(mesh)];
    const auto same = std::ranges::find_if(
        similar, [&](uint32_t index) { return is_same(scene_.meshes[index], mesh); });
    if (same != similar.end()) {
      add_node(object, *same);
      return;
    }
    similar.push_back(static_cast<uint32_t>(scene_.meshes.size()));
    scene_.meshes.push_back(std::move(mesh));
    add_node(object, similar.back());
  }

  Result<void> add_animated(Object& object) {
    for (AnimatedTriangles& triangles : object.animated) {
      Mesh mesh = make_animated_mesh(triangles);
      mesh.name = object.name;
      if (aff_.complexity > 0) SINEW_CHECKED(raise_complexity(mesh));
      scene_.meshes.push_back(std::move(mesh));
      const uint32_t node = add_node(object, static_cast<uint32_t>(scene_.meshes.size() - 1));
      has_animated_ = true;
      Channel channel;
      channel.node = node;
      channel.path = ChannelPath::cache_key;
      channel.width = 1;
      channel.times = std::move(triangles.times);
      for (size_t key = 0; key < channel.times.size(); ++key) {
        channel.values.push_back(static_cast<float>(key));
      }
      channels_.push_back(std::move(channel));
      triangles = {};
    }
    return {};
  }

  Result<void> raise_complexity(Mesh& mesh) {
    const auto base = complexity_of(mesh.triangles.size());
    if (!base || *base < kLeastComplexity || *base > aff_.complexity) {
      return fail({ErrorKind::usage, path_, "complexity=" + std::to_string(aff_.complexity),
                   fmt::format("cannot be made from {} animated triangles", mesh.triangles.size()),
                   base && *base > aff_.complexity ? fmt::format("the file has {}", *base)
                                                   : "leave complexity out"});
    }
    const uint64_t triangles = uint64_t{1} << (2 * aff_.complexity);
    content_.bytes += triangles * (kBytesPerSplitTriangle + mesh.keys * sizeof(vec3));
    if (content_.bytes > options_.memory_limit) {
      return fail({ErrorKind::bad_input, path_, "",
                   "the animated triangles take more than the memory limit",
                   "raise the memory limit"});
    }
    for (int c = *base; c < aff_.complexity; ++c) subdivide(mesh);
    if (*base == aff_.complexity) return {};
    derivation_ =
        fmt::format(" (complexity {}, derived from complexity {})", aff_.complexity, *base);
    mesh.name += derivation_;
    return {};
  }

  uint32_t add_node(const Object& object, uint32_t mesh) {
    Node& node = scene_.nodes.emplace_back();
    node.name = scene_.meshes[mesh].name;
    node.parent = object.frame;
    node.mesh = static_cast<int32_t>(mesh);
    if (object.to_frame != glm::dmat4(1.0)) {
      node.has_matrix = true;
      node.matrix = affine(object.to_frame);
    }
    return static_cast<uint32_t>(scene_.nodes.size() - 1);
  }

  Result<void> add_keyframes() {
    std::set<std::string_view> used;
    for (const NamedNode& named : content_.named_nodes) {
      const auto found = content_.keyframes.find(named.name);
      if (found == content_.keyframes.end()) continue;
      used.insert(named.name);
      for (Channel channel : found->second.channels) {
        content_.bytes += sizeof(float) * (channel.times.size() + channel.values.size());
        if (content_.bytes > options_.memory_limit) {
          return fail({ErrorKind::bad_input, path_, "keyframes \"" + printable(named.name) + '"',
                       "they move so many transforms that they take more than the memory limit",
                       "raise the memory limit"});
        }
        channel.node = named.node;
        channels_.push_back(std::move(channel));
      }
    }
    for (const auto& [name, keys] : content_.keyframes) {
      if (used.contains(name) || scene_.warnings.size() >= kMostWarnings) continue;
      scene_.warnings.push_back(fmt::format(
          "keyframes \"{}\" move nothing: there is no such transform", printable(name)));
    }
    return {};
  }

  void set_timing() {
    const Timing& timing = content_.timing;
    if (timing.frames == 0 && channels_.empty()) return;
    Clip& clip = scene_.clips.emplace_back();
    clip.name = "animation";
    if (timing.frames > 0) {
      clip.start = timing.start;
      clip.end = timing.end;
      scene_.default_frames = timing.frames;
      const double length = timing.end - timing.start;
      if (timing.frames > 1 && length > 0.0) scene_.default_fps = (timing.frames - 1) / length;
    } else {
      clip.start = channels_[0].times.front();
      clip.end = channels_[0].times.back();
      for (const Channel& channel : channels_) {
        clip.start = std::min<double>(clip.start, channel.times.front());
        clip.end = std::max<double>(clip.end, channel.times.back());
      }
    }
    clip.channels = std::move(channels_);
  }

  Scene& scene_;
  Content& content_;
  const std::string& path_;
  const AffOptions& aff_;
  const LoadOptions& options_;
  std::unordered_map<size_t, std::vector<uint32_t>> meshes_by_content_;  // indices
  std::vector<Channel> channels_;
  bool has_animated_ = false;
  std::string derivation_;  // what raise_complexity did, for names
};

}  // namespace

Result<AffInput> parse_aff_input(std::string_view spec) {
  AffInput result;
  for (;;) {
    const size_t comma = spec.find(','), equals = spec.find('=');
    if (comma == std::string_view::npos || equals > comma) break;
    const std::string_view key = spec.substr(0, equals);
    const std::string_view value = spec.substr(equals + 1, comma - equals - 1);
    const auto error = [&](std::string problem, std::string remedy) {
      return fail({ErrorKind::usage, "", fmt::format("aff:{}={}", key, value), std::move(problem),
                   std::move(remedy)});
    };
    if (key != "complexity") {
      return error(fmt::format("there is no option \"{}\"", key), "the only one is complexity");
    }
    const auto [end, problem] =
        std::from_chars(value.data(), value.data() + value.size(), result.options.complexity);
    if (problem != std::errc() || end != value.data() + value.size() ||
        result.options.complexity < kLeastComplexity ||
        result.options.complexity > kMostComplexity) {
      return error("is no complexity",
                   fmt::format("give {} to {}", kLeastComplexity, kMostComplexity));
    }
    spec.remove_prefix(comma + 1);
  }
  result.path = std::string(spec);
  if (result.path.empty()) {
    return fail({ErrorKind::usage, "", "aff:", "names no file", "give aff:complexity=8,PATH.aff"});
  }
  return result;
}

Result<Scene> load_aff(const std::string& path, const AffOptions& aff, const LoadOptions& options) {
  Scene scene;
  Reader reader(scene, path, options);
  SINEW_TRY(Content content, reader.run());
  SINEW_CHECKED(Assembler(scene, content, path, aff, options).run());
  return scene;
}

}  // namespace sinew
