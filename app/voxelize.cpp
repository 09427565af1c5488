// `sinew voxelize`: meshes -> octrees that their skeletons move (.svo), or frames of voxels (.vox).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/command.h"
#include "app/frames.h"
#include "app/hide.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/validators.h"
#include "app/values.h"
#include "app/voxelize_report.h"
#include "sinew/base/memory_use.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"
#include "sinew/io/svo/svo.h"
#include "sinew/io/vox/vox.h"
#include "sinew/render/voxelize_frames.h"
#include "sinew/render/voxelize_scene.h"
#include "sinew/scene/sample.h"
#include "sinew/world/world.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "A .svo holds the octrees of a scene at rest with the skeletons, clips, cameras and lights "
    "that\n"
    "move and show them; `sinew render` plays it. A .vox holds voxels as they are seen, frame by\n"
    "frame if --clip is given, for MagicaVoxel.\n"
    "\n"
    "Examples:\n"
    "  sinew voxelize study:creature -o creature.svo --object 'body*' --resolution 1024\n"
    "  sinew voxelize statue.ply -o statue.svo --voxel-size 0.002 --solid\n"
    "  sinew voxelize walk.glb -o walk.vox --resolution 126 --clip Walk --fps 12\n";

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct VoxelizeJob {
  std::string input, output, json, memory, shell = "thin", clip;
  std::vector<std::string> objects;
  bool only = false;
  double fps = 0.0;
  int threads = 0;
  LoadOptions load;
  VoxelizeSceneOptions voxels;
  bool is_vox = false;
};

Result<void> check_outputs(VoxelizeJob& job) {
  const std::string extension = std::filesystem::path(job.output).extension().string();
  job.is_vox = extension == ".vox";
  if (!job.is_vox && job.output != "-" && extension != ".svo") {
    return fail({ErrorKind::usage, job.output, "", "is no name of a file of voxels",
                 "name the output .svo or .vox"});
  }
  if (job.output == "-" && job.json == "-") {
    return fail({ErrorKind::usage, "", "", "voxels and report cannot both go to standard output",
                 "give --json a file name"});
  }
  if (!job.is_vox && !job.clip.empty()) {
    return fail({ErrorKind::usage, job.output, "", "a .svo holds all clips: --clip is for .vox",
                 "leave --clip out"});
  }
  SINEW_CHECKED(job.is_vox ? check_save_vox(job.output) : check_save_svo(job.output));
  if (!job.json.empty()) SINEW_CHECKED(check_writable(job.json));
  return {};
}

Result<void> read_options(VoxelizeJob& job) {
  if (job.shell != "thin" && job.shell != "conservative") {
    return fail({ErrorKind::usage, "", fmt::format("--shell '{}'", job.shell),
                 "there is no such shell", "write thin or conservative"});
  }
  job.voxels.shell = job.shell == "thin" ? Shell::thin : Shell::conservative;
  if (!job.memory.empty()) {
    SINEW_TRY(job.load.memory_limit, parse_bytes(job.memory));
    job.voxels.memory_limit = job.load.memory_limit;
  }
  return {};
}

Result<void> choose_objects(VoxelizeJob& job, const Scene& scene) {
  if (scene.objects.empty() && !scene.voxels.empty()) {
    return fail({ErrorKind::usage, job.input, "", "holds voxels already, and no triangles",
                 "`sinew scene` writes it as .svo or .vox"});
  }
  job.voxels.keep_meshes = !job.only;
  if (job.objects.empty()) return {};
  SINEW_TRY(const std::vector<uint8_t> nodes, find_objects(scene, job.objects, "--object"));
  for (const SceneObject& object : scene.objects) job.voxels.chosen.push_back(nodes[object.node]);
  return {};
}

VoxelizedObjectReport row_of(const std::string& name, const uvec3& resolution) {
  VoxelizedObjectReport row;
  row.name = name;
  for (int k = 0; k < 3; ++k) row.resolution[k] = resolution[k];
  return row;
}

Result<void> write_svo(VoxelizeJob& job, const Scene& scene, VoxelizeReport& report) {
  std::optional<StatusLine> line(std::in_place);
  SvoStore store(job.output, {});
  OctreeTaker taker{[&](const Svo& part) { return store.add(part); },
                    [&](const Svo& outline) { return store.finish(outline); }};
  job.voxels.taker = &taker;
  job.voxels.whole_process = true;
  std::string octree_name;
  job.voxels.on_octree = [&](uint32_t i, uint32_t count, const std::string& name) {
    octree_name = fmt::format("octree {} of {}, {:.40}", i + 1, count, name);
    line->show(octree_name);
    return true;
  };
  job.voxels.on_part = [&](size_t done, size_t blocks) {
    line->show(fmt::format("{}: {} of {} cubes of 64^3 voxels", octree_name, done, blocks));
    return true;
  };
  const auto start = Clock::now();
  SINEW_TRY(const VoxelizedScene made, voxelize_scene(scene, job.voxels));
  report.make_s = seconds_since(start);
  report.voxel = made.voxel;
  for (const OctreeReport& octree : made.octrees) {
    VoxelizedObjectReport row = row_of(octree.name, octree.resolution);
    row.triangles = octree.triangles;
    row.voxels = octree.voxels;
    row.bytes = octree.bytes;
    row.parts = octree.parts;
    row.seconds = octree.voxelize_s + octree.octree_s;
    report.voxels += octree.voxels;
    report.objects.push_back(std::move(row));
  }
  line->show(fmt::format("writing {} voxels", report.voxels));
  report.warnings = made.scene.warnings;
  const Uninterrupted writing;
  SINEW_TRY(const SavedSvo saved, save_svo(made.scene, store, job.output));
  report.warnings.insert(report.warnings.end(), saved.warnings.begin(), saved.warnings.end());
  if (job.output != "-") report.file_bytes = saved.bytes;
  return {};
}

Result<void> write_vox(const VoxelizeJob& job, const Scene& scene, VoxelizeReport& report) {
  int clip = kRestPose;
  std::vector<double> times = {0.0};
  if (!job.clip.empty()) {
    SINEW_TRY(clip, find_clip(scene, job.clip));
    const Timeline timeline = timeline_of(scene, clip, job.fps);
    times.clear();
    for (int frame = 1; frame <= timeline.frames; ++frame) {
      times.push_back(frame_time(timeline, frame));
    }
  }
  const auto start = Clock::now();
  SINEW_TRY(std::vector<VoxelFrames> made, voxelize_frames(scene, clip, times, job.voxels));
  report.make_s = seconds_since(start);
  report.frames = static_cast<uint32_t>(times.size());
  std::vector<VoxObject> objects;
  for (VoxelFrames& frames : made) {
    VoxelizedObjectReport row = row_of(frames.name, frames.grid.resolution);
    row.triangles = frames.triangles;
    for (const std::vector<PlainVoxel>& frame : frames.frames) row.voxels += frame.size();
    report.voxel = static_cast<double>(frames.grid.voxel);
    report.voxels += row.voxels;
    report.objects.push_back(std::move(row));
    objects.push_back({std::move(frames.name), frames.grid, std::move(frames.frames)});
  }
  const Uninterrupted writing;
  SINEW_TRY(const SavedVox saved, save_vox(objects, scene.materials, job.output));
  report.warnings = scene.warnings;
  report.warnings.insert(report.warnings.end(), saved.warnings.begin(), saved.warnings.end());
  report.file_bytes = saved.bytes;
  return {};
}

Result<int> voxelize_input(VoxelizeJob& job) {
  const auto start = Clock::now();
  SINEW_CHECKED(read_options(job));
  SINEW_CHECKED(check_outputs(job));
  const ThreadLimit threads(job.threads);
  SINEW_TRY(const Scene scene, load(job.input, job.load));
  SINEW_CHECKED(choose_objects(job, scene));
  VoxelizeReport report;
  report.input = job.input;
  report.output = job.output;
  report.shell = job.shell;
  report.solid = job.voxels.solid;
  report.threads = thread_count();
  SINEW_CHECKED(job.is_vox ? write_vox(job, scene, report) : write_svo(job, scene, report));
  report.total_s = seconds_since(start);
  report.peak_bytes = peak_resident_bytes();
  print_warnings(report.warnings);
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_of(report)));
  if (job.output != "-" && job.json != "-") SINEW_CHECKED(write_file("-", table_of(report)));
  return kOk;
}

void define_size(CLI::App& app, VoxelizeJob& job) {
  CLI::Option* resolution =
      app.add_option("--resolution", job.voxels.resolution,
                     fmt::format("Voxels along the longest side of all chosen objects together, at "
                                 "rest, 1 to {} (default: {})",
                                 kHighestResolution, job.voxels.resolution))
          ->check(whole_number_in(1, kHighestResolution));
  app.add_flag("--each", job.voxels.each, "Count them along each object's own longest side");
  app.add_option("--voxel-size", job.voxels.voxel, "Side of a voxel in metres instead")
      ->check(number_in(1e-30, 1e30))
      ->excludes(resolution);
  app.add_option("--shell", job.shell,
                 "thin: no path over faces of voxels leads through the surface; conservative: "
                 "whatever triangles touch (default: thin)");
  app.add_flag("--solid", job.voxels.solid,
               "Fill what cannot be reached from outside through the shell");
}

}  // namespace

Run define_voxelize(CLI::App& app) {
  const auto job = std::make_shared<VoxelizeJob>();
  app.footer(kExamples);
  app.add_option("INPUT", job->input, "As for `sinew render`")->required();
  app.add_option("-o,--output", job->output,
                 "A .svo or .vox file, or - for a .svo on standard output")
      ->required();
  define_size(app, *job);
  app.add_option("--object", job->objects,
                 "Only objects whose node or mesh has this name (* and ? as in a shell); others "
                 "stay meshes in a .svo");
  app.add_flag("--only", job->only, "Leave the others out");
  CLI::Option* clip = app.add_option("--clip", job->clip,
                                     ".vox: a frame for each frame of this clip, name or index "
                                     "(default: one, at rest)");
  app.add_option("--fps", job->fps, "Frames a second of the clip (default: the scene's own, or 24)")
      ->check(number_in(0.001, 10000.0))
      ->needs(clip);
  app.add_option("--threads", job->threads, "At most so many (default: 0, all)")
      ->check(whole_number_in(0, 4096));
  app.add_option("--memory-limit", job->memory,
                 "2G, 512M ... (default: 8G): a .svo is made in parts that keep to it");
  app.add_option("--json", job->json, "Write a report; - for standard output");
  app.add_flag("--strict", job->load.strict,
               "Fail if the file holds something that is not supported");
  return [job] { return voxelize_input(*job); };
}

}  // namespace sinew::app
