#include "app/hide.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>

namespace sinew::app {
namespace {

constexpr size_t kListed = 20;  // names in the error message

bool fits(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

// Then the node is no object any more; what hangs below it stays.
void remove_contents(Node& node) {
  node.mesh = -1;
  node.octree = -1;
  node.skin = -1;
  node.weights.clear();
}

bool is_object(const Node& node) {
  return node.mesh >= 0 || node.octree >= 0;
}

// Of the mesh or octree that the node shows.
const std::string& name_of_contents(const Scene& scene, const Node& node) {
  return node.mesh >= 0 ? scene.meshes[static_cast<size_t>(node.mesh)].name
                        : scene.octrees[static_cast<size_t>(node.octree)].name;
}

std::string list_names(const Scene& scene) {
  std::string list;
  size_t listed = 0;
  for (const Node& node : scene.nodes) {
    if (!is_object(node)) continue;
    if (listed == kListed) return list + ", ...";
    list += (listed++ > 0 ? ", " : "") + node.name;
  }
  return list;
}

}  // namespace

Result<std::vector<uint8_t>> find_objects(const Scene& scene,
                                          const std::vector<std::string>& patterns,
                                          const char* option) {
  std::vector<uint8_t> is_found(scene.nodes.size(), 0);
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
      const Node& node = scene.nodes[i];
      if (!is_object(node)) continue;
      if (!fits(pattern, node.name) && !fits(pattern, name_of_contents(scene, node))) continue;
      is_found[i] = 1;
      found = true;
    }
    if (!found) {
      return fail({ErrorKind::usage, scene.name, "",
                   fmt::format("{} '{}' fits no object", option, pattern),
                   "the objects are " + list_names(scene)});
    }
  }
  return is_found;
}

Result<void> hide_objects(Scene& scene, const std::vector<std::string>& patterns) {
  SINEW_TRY(const std::vector<uint8_t> hidden, find_objects(scene, patterns, "--hide"));
  for (size_t i = 0; i < hidden.size(); ++i) {
    if (hidden[i]) remove_contents(scene.nodes[i]);
  }
  for (Clip& clip : scene.clips) {
    std::erase_if(clip.channels, [&](const Channel& channel) {
      const bool of_contents =
          channel.path == ChannelPath::weights || channel.path == ChannelPath::cache_key;
      return of_contents && !is_object(scene.nodes[channel.node]);
    });
  }
  list_objects(scene);
  return {};
}

}  // namespace sinew::app
