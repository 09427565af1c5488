// `sinew scene`: writes any scene that can be loaded as glTF, for other programs; its voxels as
// .svo or .vox.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/validators.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"
#include "sinew/io/save.h"
#include "sinew/io/svo/svo.h"
#include "sinew/io/text.h"
#include "sinew/io/vox/vox.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "Vertex caches and free motions go to .pc2 files beside the output. sinew plays them when it\n"
    "reads the output again; other programs show their meshes at rest.\n"
    "\n"
    "A .svo holds the octrees of a scene and what moves them; a .vox, for MagicaVoxel, its voxels "
    "at\n"
    "rest.\n"
    "\n"
    "Examples:\n"
    "  sinew scene study:creature -o creature.glb\n"
    "  sinew scene base.obj+positions.pc2 -o cloth.glb\n"
    "  sinew scene castle.vox -o castle.svo\n"
    "  sinew scene walk_####.obj -o walk.gltf       writes walk.bin as well\n";

struct SceneJob {
  std::string input;
  std::string output;
  SaveOptions save;
  LoadOptions load;
};

Result<int> write_svo(const SceneJob& job) {
  SINEW_CHECKED(check_save_svo(job.output));
  SINEW_TRY(const Scene scene, load(job.input, job.load));
  print_warnings(scene.warnings);
  const Uninterrupted writing;
  SINEW_TRY(const SavedSvo saved, save_svo(scene, job.output));
  print_warnings(saved.warnings);
  std::string text = fmt::format("voxels {}\n", saved.voxels);
  for (const SvoPart& part : saved.parts)
    text += fmt::format("{} {} bytes\n", part.name, part.bytes);
  SINEW_CHECKED(write_file("-", text + fmt::format("{}  {} bytes\n", saved.path, saved.bytes)));
  return kOk;
}

Result<int> write_vox(const SceneJob& job) {
  SINEW_CHECKED(check_save_vox(job.output));
  SINEW_TRY(const Scene scene, load(job.input, job.load));
  print_warnings(scene.warnings);
  std::vector<std::string> warnings;
  const std::vector<VoxObject> objects = vox_objects(scene, warnings);
  const Uninterrupted writing;
  SINEW_TRY(const SavedVox saved, save_vox(objects, scene.materials, job.output));
  warnings.insert(warnings.end(), saved.warnings.begin(), saved.warnings.end());
  print_warnings(warnings);
  SINEW_CHECKED(
      write_file("-", fmt::format("voxels {}, models {}, colours {}\n{}  {} bytes\n", saved.voxels,
                                  saved.models, saved.colors, saved.path, saved.bytes)));
  return kOk;
}

Result<int> write_scene(const SceneJob& job) {
  const std::string extension = extension_of(job.output);
  if (extension == ".svo") return write_svo(job);
  if (extension == ".vox") return write_vox(job);
  SINEW_CHECKED(check_save(job.output));
  SINEW_TRY(const Scene scene, load(job.input, job.load));
  print_warnings(scene.warnings);
  const Uninterrupted writing;
  SINEW_TRY(const SaveReport report, save_gltf(scene, job.output, job.save));
  print_warnings(report.warnings);
  if (job.output == "-") return kOk;
  std::string text = fmt::format("triangles {}, nodes {}, clips {}\n", report.triangles,
                                 report.nodes, report.clips);
  for (const SavedFile& file : report.files) {
    text += fmt::format("{}  {} bytes\n", file.path, file.bytes);
  }
  SINEW_CHECKED(write_file("-", text));
  return kOk;
}

}  // namespace

Run define_scene(CLI::App& app) {
  static SceneJob job;
  app.footer(kExamples);
  app.add_option("INPUT", job.input, "As for `sinew render`")->required();
  app.add_option("-o,--output", job.output,
                 "A .glb, .gltf, .svo or .vox, or - for a GLB on standard output")
      ->required();
  app.add_option("--fps", job.save.fps,
                 "Samples a second of free motions (default: the scene's own rate, or 24)")
      ->check(number_in(0.001, 10000.0));
  app.add_flag("--strict", job.load.strict,
               "Fail if the file holds something that is not supported");
  return [] { return write_scene(job); };
}

}  // namespace sinew::app
