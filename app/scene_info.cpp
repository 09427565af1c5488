#include "app/scene_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/frames.h"
#include "app/help_format.h"
#include "app/json_text.h"
#include "sinew/io/svo/svo.h"
#include "sinew/io/text.h"
#include "sinew/scene/names.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/study.h"

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBoundsSamples = 24;

// What the lists below need beside the scene itself.
struct Overview {
  SceneCounts counts;
  Timeline timeline;  // of the first clip
  uint32_t cache_keys = 0;
  bool vertex_program = false;
  Box box;  // over the first clip
};

Overview look_at_scene(const Scene& scene) {
  const int clip = scene.clips.empty() ? kRestPose : 0;
  Overview overview;
  overview.counts = count(scene);
  overview.timeline = timeline_of(scene, clip);
  for (const Mesh& mesh : scene.meshes) {
    overview.cache_keys = std::max(overview.cache_keys, mesh.keys);
    overview.vertex_program |= static_cast<bool>(mesh.vertex_program);
  }
  overview.box = animation_bounds(scene, clip, clip == kRestPose ? 1 : kBoundsSamples);
  return overview;
}

Json to_json(vec3 v) {
  return Json::array({v.x, v.y, v.z});
}

// 1234567 -> "1,234,567"
std::string grouped(uint64_t number) {
  std::string text = std::to_string(number);
  for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
  return text;
}

// "  triangles    37,136"
void add_row(std::string& out, const char* label, const std::string& value) {
  out += fmt::format("  {:<12} {}\n", label, value);
}
void add_count(std::string& out, const char* label, uint64_t number) {
  if (number > 0) add_row(out, label, grouped(number));
}

// One row for each entry: "  clips        0  Idle  0.000 to ..." with the label on the first.
template <class List, class Describe>
void add_list(std::string& out, const char* label, const List& list, const Describe& describe) {
  size_t widest = 0;
  const auto name_of = [](const auto& entry) {
    return entry.name.empty() ? std::string("(no name)") : entry.name;
  };
  for (const auto& entry : list) widest = std::max(widest, name_of(entry).size());
  for (size_t i = 0; i < list.size(); ++i) {
    add_row(out, i == 0 ? label : "",
            fmt::format("{:>3}  {:<{}}  {}", i, name_of(list[i]), widest, describe(list[i])));
  }
}

std::string describe(const Clip& clip, double fps) {
  const double frames = std::max(1.0, std::ceil((clip.end - clip.start) * fps - 1e-3));
  return fmt::format("{:.3f} to {:.3f} s, {:.0f} frames at {:g} fps, {} channels", clip.start,
                     clip.end, frames, fps, clip.channels.size());
}

std::string describe(const Camera& camera) {
  if (camera.orthographic) return fmt::format("orthographic, {:g} high", 2 * camera.ymag);
  return fmt::format("perspective, {:.1f} degrees", glm::degrees(camera.yfov));
}

std::string describe(const Light& light) {
  return fmt::format("{}, intensity {:g}", name_of(light.type), light.intensity);
}

uint32_t levels_of(const Svo& svo) {
  return svo.voxel_count() > 0 ? svo.root_level + 1 : 0;
}

// "3.42 MB", in millions of bytes.
std::string megabytes(uint64_t bytes) {
  return fmt::format("{:.2f} MB", static_cast<double>(bytes) * 1e-6);
}

std::string describe(const Svo& svo) {
  const uvec3 r = svo.grid.resolution;
  std::string text =
      fmt::format("{} voxels of {:g} in {} x {} x {}, {} levels, {}", grouped(svo.voxel_count()),
                  svo.grid.voxel, r.x, r.y, r.z, levels_of(svo), megabytes(svo.bytes()));
  if (svo.joints > 0) text += fmt::format(", {} joints", svo.joints);
  if (svo.morph_targets > 0) text += fmt::format(", {} morphs", svo.morph_targets);
  return text;
}

// Of the octrees in memory.
SvoFileParts memory_parts(const Svo& svo) {
  const auto level_bytes = [](const SvoLevel& level) {
    return 2 * (level.normals.size() + level.colors.size()) + level.spreads.size();
  };
  SvoFileParts parts;
  parts.tables = sizeof(SvoNode) * svo.nodes.size() + sizeof(SvoBlock) * svo.blocks.size() +
                 level_bytes(svo.node_level);
  parts.topology = sizeof(SvoCell) * svo.cells.size() + sizeof(uint64_t) * svo.bricks.size();
  parts.normals = 2 * svo.normals.size();
  parts.colors = 2 * svo.colors.size() + sizeof(SvoColorEnds) * svo.color_ends.size() +
                 sizeof(uint32_t) * svo.color_selectors.size();
  parts.levels = level_bytes(svo.brick_level) + level_bytes(svo.cell_level);
  parts.lattice =
      svo.bytes() - parts.tables - parts.topology - parts.normals - parts.colors - parts.levels;
  return parts;
}

// What the octrees take in memory, and, if they come from a .svo file, in that.
struct OctreeBytes {
  std::vector<SvoPart> memory, file;
};
OctreeBytes octree_bytes(const Scene& scene, const std::string& input) {
  OctreeBytes bytes;
  if (scene.octrees.empty()) return bytes;
  SvoFileParts sum;
  for (const Svo& svo : scene.octrees) sum.add(memory_parts(svo));
  bytes.memory = list_parts(sum, 0);
  bytes.memory.erase(bytes.memory.begin());  // the scene
  if (extension_of(input) == ".svo") bytes.file = svo_parts(input).value_or(bytes.file);
  return bytes;
}

Json parts_json(const std::vector<SvoPart>& parts) {
  Json out = Json::object();
  for (const SvoPart& part : parts) out[part.name] = part.bytes;
  return out;
}

// "17.05 MB: tables 0.12 MB, ..., 5.63 bytes a voxel"
std::string parts_text(const std::vector<SvoPart>& parts, uint64_t voxels) {
  uint64_t sum = 0;
  std::string list;
  for (const SvoPart& part : parts) {
    sum += part.bytes;
    if (part.bytes > 0) list += fmt::format(", {} {}", part.name, megabytes(part.bytes));
  }
  return fmt::format("{}, {:.2f} bytes a voxel{}", megabytes(sum),
                     static_cast<double>(sum) / static_cast<double>(std::max<uint64_t>(voxels, 1)),
                     list);
}

// Each octree counted once.
uint64_t stored_voxels(const Scene& scene) {
  uint64_t sum = 0;
  for (const Svo& svo : scene.octrees) sum += svo.voxel_count();
  return sum;
}

Json octrees_json(const Scene& scene) {
  Json octrees = Json::array();
  for (const Svo& svo : scene.octrees) {
    const uvec3 r = svo.grid.resolution;
    octrees.push_back({{"name", svo.name},
                       {"voxels", svo.voxel_count()},
                       {"voxel_size", svo.grid.voxel},
                       {"resolution", {r.x, r.y, r.z}},
                       {"levels", levels_of(svo)},
                       {"blocks", svo.block_count()},
                       {"cells", svo.cells.size()},
                       {"joints", svo.joints},
                       {"morphs", svo.morph_targets},
                       {"bytes", svo.bytes()},
                       {"bytes_by_part", parts_json(list_parts(memory_parts(svo), 0))}});
  }
  return octrees;
}

Json clips_json(const Scene& scene) {
  Json clips = Json::array();
  for (const Clip& clip : scene.clips) {
    clips.push_back({{"name", clip.name},
                     {"start_s", clip.start},
                     {"end_s", clip.end},
                     {"channels", clip.channels.size()}});
  }
  return clips;
}

Json meshes_json(const Scene& scene) {
  Json meshes = Json::array();
  for (const Mesh& mesh : scene.meshes) {
    meshes.push_back({{"name", mesh.name},
                      {"triangles", mesh.triangles.size()},
                      {"vertices", mesh.positions.size()},
                      {"parts", mesh.parts.size()},
                      {"influences", mesh.influences},
                      {"morphs", mesh.morph_targets},
                      {"cache_keys", mesh.keys}});
  }
  return meshes;
}

Json cameras_json(const Scene& scene) {
  Json cameras = Json::array();
  for (const Camera& camera : scene.cameras) {
    cameras.push_back(
        {{"name", camera.name}, {"type", camera.orthographic ? "orthographic" : "perspective"}});
  }
  return cameras;
}

Json lights_json(const Scene& scene) {
  Json lights = Json::array();
  for (const Light& light : scene.lights) {
    lights.push_back({{"name", light.name}, {"type", name_of(light.type)}});
  }
  return lights;
}

}  // namespace

std::string scene_info_json(const Scene& scene, const std::string& input) {
  const Overview overview = look_at_scene(scene);
  Json bounds = nullptr;
  if (!overview.box.empty()) {
    bounds = {{"min", to_json(overview.box.min)}, {"max", to_json(overview.box.max)}};
  }
  Json materials = Json::array();
  for (const Material& material : scene.materials) materials.push_back(material.name);
  const Json document = {
      {"input", input},
      {"name", scene.name},
      {"triangles", overview.counts.triangles},
      {"vertices", overview.counts.vertices},
      {"voxels", overview.counts.voxels},
      {"joints", overview.counts.joints},
      {"morphs", overview.counts.morphs},
      {"clips", clips_json(scene)},
      {"frames", overview.timeline.frames},
      {"fps", overview.timeline.fps},
      {"objects", scene.objects.size()},
      {"voxel_objects", scene.voxels.size()},
      {"nodes", scene.nodes.size()},
      {"skins", scene.skins.size()},
      {"cache_keys", overview.cache_keys},
      {"vertex_program", overview.vertex_program},
      {"images", scene.images.size()},
      {"materials", materials},
      {"meshes", meshes_json(scene)},
      {"octrees", octrees_json(scene)},
      {"svo_file", parts_json(octree_bytes(scene, input).file)},
      {"cameras", cameras_json(scene)},
      {"lights", lights_json(scene)},
      {"bounds", bounds},
      {"warnings", scene.warnings},
  };
  return json_text(document);
}

namespace {

void add_octrees(std::string& out, const Scene& scene, const std::string& input, uint64_t voxels) {
  if (scene.octrees.empty()) return;
  add_row(out, "voxels",
          fmt::format("{} in {} objects of {} octrees", grouped(voxels),
                      grouped(scene.voxels.size()), grouped(scene.octrees.size())));
  add_list(out, "octrees", scene.octrees, [](const Svo& svo) { return describe(svo); });
  const OctreeBytes bytes = octree_bytes(scene, input);
  add_row(out, "in memory", parts_text(bytes.memory, stored_voxels(scene)));
  if (!bytes.file.empty())
    add_row(out, "in the file", parts_text(bytes.file, stored_voxels(scene)));
}

}  // namespace

std::string scene_info_text(const Scene& scene, const std::string& input) {
  const Overview overview = look_at_scene(scene);
  std::string out = input + "\n";
  add_row(out, "triangles", grouped(overview.counts.triangles));
  add_row(out, "vertices", grouped(overview.counts.vertices));
  add_row(out, "objects",
          fmt::format("{} of {} meshes, {} nodes", grouped(scene.objects.size()),
                      grouped(scene.meshes.size()), grouped(scene.nodes.size())));
  add_octrees(out, scene, input, overview.counts.voxels);
  if (!scene.skins.empty()) {
    add_row(out, "joints",
            fmt::format("{} in {} skins", grouped(overview.counts.joints), scene.skins.size()));
  }
  add_count(out, "morphs", overview.counts.morphs);
  add_count(out, "cache keys", overview.cache_keys);
  if (overview.vertex_program) add_row(out, "vertices", "new in every frame");
  add_count(out, "materials", scene.materials.size());
  add_count(out, "images", scene.images.size());
  const double fps = overview.timeline.fps;
  add_list(out, "clips", scene.clips, [&](const Clip& clip) { return describe(clip, fps); });
  add_list(out, "cameras", scene.cameras, [](const Camera& camera) { return describe(camera); });
  add_list(out, "lights", scene.lights, [](const Light& light) { return describe(light); });
  add_row(out, "frames", fmt::format("{} at {:g} fps", overview.timeline.frames, fps));
  if (!overview.box.empty()) {
    const auto [low, high] = overview.box;
    add_row(out, "bounds",
            fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g})", low.x, low.y, low.z,
                        high.x, high.y, high.z));
  }
  if (scene.warnings.empty()) add_row(out, "warnings", "none");
  for (size_t i = 0; i < scene.warnings.size(); ++i) {
    add_row(out, i == 0 ? "warnings" : "", scene.warnings[i]);
  }
  return out;
}

std::string study_list_text() {
  std::string out = "Study scenes: study:NAME[,key=value...], accepted wherever a file is.\n";
  for (const StudyInfo& study : study_scenes()) {
    out += fmt::format("\nstudy:{}\n  {}\n", study.name, wrap(study.summary, kHelpWidth - 2, 2));
    for (const StudyParameter& parameter : study.parameters) {
      const std::string meaning =
          fmt::format("{} (default: {})", parameter.meaning, parameter.fallback);
      out += fmt::format("    {:<12} {}\n", parameter.name, wrap(meaning, kHelpWidth - 17, 17));
    }
  }
  return out;
}

std::string study_list_json() {
  Json studies = Json::array();
  for (const StudyInfo& study : study_scenes()) {
    Json parameters = Json::array();
    for (const StudyParameter& parameter : study.parameters) {
      parameters.push_back({{"name", std::string(parameter.name)},
                            {"meaning", std::string(parameter.meaning)},
                            {"default", std::string(parameter.fallback)}});
    }
    studies.push_back({{"name", std::string(study.name)},
                       {"summary", std::string(study.summary)},
                       {"parameters", parameters}});
  }
  return json_text({{"studies", studies}});
}

}  // namespace sinew::app
