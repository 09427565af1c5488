// The options of `sinew render`: declared for the command line, then read into a RenderJob.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "app/command.h"
#include "app/frames.h"
#include "app/render.h"
#include "app/validators.h"

namespace sinew::app {
namespace {

constexpr uint32_t kMaxWebpSide = 16383;  // pixels, by the format

constexpr const char* kExamples =
    "INPUT is a .gltf, .glb, .obj, .ply, .aff, .svo or .vox file, a sequence walk_####.obj or\n"
    ".ply, a vertex cache base.obj+positions.pc2 or .mdd, or a study scene study:NAME\n"
    "(`sinew info study:` lists them). aff:complexity=8,FILE.aff splits AFF's animated\n"
    "triangles into 4^8.\n"
    "Frames count from 1; frame n shows the time start + (n - 1) / fps of the clip.\n"
    "\n"
    "Examples:\n"
    "  sinew render walk.glb -o walk.webp\n"
    "  sinew render walk.glb -o out_####.png --clip Run --frames 1-100x2 --samples 16\n"
    "  sinew render walk.glb -o still.png --time 0.5 --camera orbit=120,10 --size 1600x1200\n"
    "  sinew render walk.glb -o out_####.exr --layers color,depth,normal\n"
    "  sinew render walk.glb -o cost.png --time 0.5 --view heatmap\n"
    "  sinew render walk.glb -o voxels.webp --mode voxels --resolution 1024\n"
    "  sinew render study:creature -o - --time 0 | display\n";

// What the command line holds as text, until it is read.
struct Flags {
  RenderJob job;
  std::string output, format, frames, size = "800x600", camera, background, memory, voxel_memory, mode, skinning,
                                      update;
  std::string view = "shaded", layers;
  std::optional<float> quality;
  bool no_shadows = false;
  std::string progress = "auto";
};

void add_frame_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Frames";
  app.add_option("-f,--frames", flags.frames, "1-100, 1,3,5-9 or 1-100x2 (default: all)")
      ->group(kGroup);
  app.add_option("--time", flags.job.time, "One picture of this time of the clip, in seconds")
      ->check(number_in(-1e6, 1e6))
      ->excludes("--frames")
      ->group(kGroup);
  app.add_option("--clip", flags.job.clip, "Name or index; 'rest' for none (default: the first)")
      ->group(kGroup);
  app.add_option("--fps", flags.job.fps, "Frames a second (default: the scene's own, or 24)")
      ->check(number_in(0.001, 1000.0))
      ->group(kGroup);
  app.add_flag("--skip-existing", flags.job.skip_existing,
               "Leave the .png or .exr frames that are there already")
      ->group(kGroup);
}

void add_output_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Output";
  app.add_option("-o,--output", flags.output,
                 "out_####.png, out_%04d.png, out_{frame:04}.exr, out.webp, out.mp4, or - for "
                 "standard output")
      ->required()
      ->group(kGroup);
  app.add_option("--format", flags.format, "png, exr, webp or mp4, whatever the name says")
      ->check(CLI::IsMember({"png", "exr", "webp", "mp4"}))
      ->group(kGroup);
  app.add_option("--quality", flags.quality, "Of .webp and .mp4, 0 to 100 (default: 85)")
      ->check(number_in(0.0, 100.0))
      ->group(kGroup);
  app.add_flag("--lossless", flags.job.movie.lossless, "Make the .webp exact, and larger")
      ->group(kGroup);
  app.add_option("--layers", flags.layers,
                 "Of .exr: color, depth, normal, object, primitive, traversal with commas between "
                 "them (default: all)")
      ->group(kGroup);
  app.add_option("--contact-sheet", flags.job.contact_sheet,
                 "Also write small copies of up to 20 frames to this .png")
      ->group(kGroup);
  app.add_option("--json", flags.job.json, "Write statistics of every frame; - for stdout")
      ->group(kGroup);
  app.add_option("--progress", flags.progress,
                 "auto: a line on a terminal; json: an object a frame on stderr; none")
      ->check(CLI::IsMember({"auto", "json", "none"}))
      ->group(kGroup);
}

void add_picture_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Picture";
  RenderSettings& settings = flags.job.settings;
  app.add_option("--camera", flags.camera,
                 "A camera of the file (name or index), eye=x,y,z,target=x,y,z[,fov=degrees], or "
                 "orbit=azimuth,elevation[,zoom] in degrees (default: the file's first, or "
                 "orbit=35,18)")
      ->group(kGroup);
  app.add_option("--size", flags.size, "WIDTHxHEIGHT in pixels (default: 800x600)")->group(kGroup);
  app.add_option("--samples", settings.samples, "Camera rays a pixel (default: 1)")
      ->check(whole_number_in(1, 4096))
      ->group(kGroup);
  app.add_option("--reflections", settings.reflections, "Mirror bounces, 0 to 16 (default: 1)")
      ->check(whole_number_in(0, 16))
      ->group(kGroup);
  app.add_option("--refractions", settings.refractions,
                 "Transmissive surfaces that a ray goes through, 0 to 32 (default: 8)")
      ->check(whole_number_in(0, 32))
      ->group(kGroup);
  app.add_option("--ao", settings.ambient_rays,
                 "Ambient occlusion rays a hit (default: 0, no occlusion)")
      ->check(whole_number_in(0, 4096))
      ->group(kGroup);
  app.add_option("--ao-distance", settings.ambient_distance,
                 "How far occlusion reaches (default: a quarter of the scene)")
      ->check(number_in(0.0, 1e12))
      ->group(kGroup);
  app.add_option(
         "--hide", flags.job.hide,
         "Leave out objects (or meshes) of this name; * and ? as in a shell; may be repeated")
      ->allow_extra_args(false)
      ->group(kGroup);
  app.add_flag("--shadows,!--no-shadows", settings.shadows, "Cast shadows (default: yes)")
      ->group(kGroup);
  app.add_option("--exposure", settings.exposure, "In stops (default: 0)")
      ->check(number_in(-32.0, 32.0))
      ->group(kGroup);
  CLI::Option* transparent =
      app.add_flag("--transparent", settings.transparent, "Leave the background out (alpha 0)")
          ->group(kGroup);
  app.add_option("--background", flags.background, "A plain colour behind everything: 3a6ea5")
      ->excludes(transparent)
      ->group(kGroup);
  app.add_option("--view", flags.view,
                 "shaded, heatmap[=STEPS] (what each camera ray cost the hierarchy; STEPS is the "
                 "brightest), boxes=LEVEL (of the hierarchy, over the picture), normals, depth or "
                 "objects (default: shaded)")
      ->group(kGroup);
  app.add_option("--seed", settings.seed, "Of the sampling pattern (default: 0)")
      ->check(whole_number_in(0, UINT32_MAX))
      ->group(kGroup);
}

// Larsson and Akenine-Moller's ways to interactive rates.
void add_speed_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Interactive rates";
  RenderSettings& settings = flags.job.settings;
  app.add_option("--subsample", settings.subsampling,
                 "Draw one pixel of every N x N and interpolate, 1 to 64 (default: 1)")
      ->check(whole_number_in(1, 64))
      ->group(kGroup);
  app.add_option("--time-budget", settings.time_budget_ms,
                 "Milliseconds a frame may take; rays it has no time for are left out, secondary "
                 "ones first (default: 0, no limit)")
      ->check(number_in(0.0, 1e6))
      ->group(kGroup);
  app.add_flag("--progressive", flags.job.progressive,
               "Where nothing moves from one frame to the next, refine the picture")
      ->group(kGroup);
}

void add_voxel_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Voxels";
  DrawModeChoice& mode = flags.job.mode;
  VoxelSettings& voxels = flags.job.settings.voxels;
  app.add_option("--mode", flags.mode,
                 "triangles (octrees are left out), voxels (meshes become octrees), mixed (those "
                 "that --voxelize names do), or auto: whatever the scene has (default: auto)")
      ->group(kGroup);
  app.add_option("--voxelize", mode.voxelize,
                 "With --mode mixed: objects (or meshes) of this name become octrees; * and ? as "
                 "in a shell; may be repeated")
      ->allow_extra_args(false)
      ->group(kGroup);
  app.add_option("--resolution", mode.resolution,
                 "Voxels along the longest side of what is voxelised, at rest (default: 512)")
      ->check(whole_number_in(1, kHighestResolution))
      ->group(kGroup);
  app.add_option("--skinning", flags.skinning,
                 "What moves voxels: lattice; or, to compare with, thesis (joints of every voxel) "
                 "or corners (of every corner of every voxel) (default: lattice)")
      ->group(kGroup);
  app.add_option("--shadow-map", voxels.shadow_map,
                 "Pixels a side of the map that a light's shadows of voxels are drawn in, 16 to "
                 "16384 (default: 1024)")
      ->check(whole_number_in(16, 16384))
      ->group(kGroup);
  app.add_option("--lod", voxels.lod,
                 "Pixels: coarser levels are drawn instead of voxels smaller than this; 0: always "
                 "the finest (default: 0.75)")
      ->check(number_in(0.0, 64.0))
      ->group(kGroup);
}

void add_engine_options(CLI::App& app, Flags& flags) {
  constexpr const char* kGroup = "Engine";
  app.add_option(
         "--update", flags.update,
         "How objects follow their poses: full (every vertex), hybrid (vertices, but "
         "insides when a ray comes), lazy (only what rays reach) or auto, which chooses for "
         "each object (default: auto); the picture is the same")
      ->group(kGroup);
  app.add_option("--tree", flags.job.tree,
                 "Trees that `sinew optimize` made for this input; what does not fit is made anew")
      ->group(kGroup);
  app.add_flag("--one-tree", flags.job.one_tree,
               "One tree over the parts of all objects, for objects that overlap")
      ->group(kGroup);
  app.add_option("--threads", flags.job.threads, "At most so many (default: 0, all)")
      ->check(whole_number_in(0, 4096))
      ->group(kGroup);
  app.add_option("--memory-limit", flags.memory, "2G, 512M ... (default: 8G)")->group(kGroup);
  app.add_option("--voxel-memory", flags.voxel_memory,
                 "256M, 1G ...: so much for the octrees of a .svo, whose detail comes from the file "
                 "as it is seen (default: all is read at once)")
      ->group(kGroup);
  app.add_flag("--strict", flags.job.load.strict,
               "Fail if the file holds something that is not supported")
      ->group(kGroup);
}

tl::unexpected<Error> usage(std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", "", std::move(problem), std::move(remedy)});
}

Result<VoxelSkinning> parse_skinning(const std::string& word) {
  if (word.empty() || word == "lattice") return VoxelSkinning::lattice;
  if (word == "thesis") return VoxelSkinning::thesis;
  if (word == "corners") return VoxelSkinning::corners;
  return usage("--skinning '" + word + "' is unknown", "there are lattice, thesis and corners");
}

Result<void> read_mode(const Flags& flags, RenderJob& job) {
  SINEW_TRY(job.settings.voxels.skinning, parse_skinning(flags.skinning));
  SINEW_TRY(job.mode.mode, parse_mode(flags.mode));
  if (!job.mode.voxelize.empty() && job.mode.mode != DrawMode::mixed) {
    return usage("--voxelize chooses what becomes voxels in a mixed picture",
                 "add --mode mixed, or use --mode voxels for everything");
  }
  if (!job.tree.empty() &&
      (job.mode.mode == DrawMode::voxels || job.mode.mode == DrawMode::mixed)) {
    return usage("--tree holds trees for all of the input's meshes, and --mode " + flags.mode +
                     " makes voxels of some",
                 "leave one of them out");
  }
  return {};
}

Result<UpdateMode> parse_update(const std::string& word) {
  if (word.empty()) return UpdateMode::automatic;
  if (const std::optional<UpdateMode> mode = update_mode_named(word)) return *mode;
  return usage("--update '" + word + "' is unknown", "use auto, full, hybrid or lazy");
}

// What each format cannot hold.
Result<void> check_format(const Flags& flags, const RenderJob& job) {
  const RenderSettings& settings = job.settings;
  const bool webp = job.output.format == OutputFormat::webp;
  const bool mp4 = job.output.format == OutputFormat::mp4;
  const bool exr = job.output.format == OutputFormat::exr;
  if (webp && std::max(settings.width, settings.height) > kMaxWebpSide) {
    return usage(fmt::format("a .webp has at most {} pixels a side", kMaxWebpSide),
                 "choose a smaller --size, or .png");
  }
  if (mp4 && (settings.width % 2 != 0 || settings.height % 2 != 0)) {
    return usage(fmt::format("an .mp4 cannot have {} x {} pixels, for its colours come in squares "
                             "of 2 x 2",
                             settings.width, settings.height),
                 "choose an even --size, or .webp");
  }
  if (mp4 && (settings.transparent || job.movie.lossless)) {
    return usage(
        fmt::format("an .mp4 cannot be {}", settings.transparent ? "transparent" : "lossless"),
        "use .webp or .png");
  }
  if (mp4 && job.output.is_stdout()) {
    return usage("an .mp4 cannot go to standard output, for its beginning is written last",
                 "give a file name, or use --format webp");
  }
  if (exr && job.view.view != View::shaded) {
    return usage("an .exr holds light and layers, not a --view of them",
                 "use .png, or --layers to choose layers");
  }
  if (exr && job.background) {
    return usage("a --background is a colour of finished pictures, which an .exr is not",
                 "use --transparent and lay the colour under it later");
  }
  if (!exr && !flags.layers.empty()) {
    return usage("only .exr files have --layers", "use -o out_####.exr");
  }
  return {};
}

// How movies are compressed.
Result<void> read_compression(const Flags& flags, RenderJob& job) {
  if (!is_movie(job.output.format) && (flags.quality || job.movie.lossless)) {
    return usage(fmt::format("a .{} is always lossless: --quality and --lossless are for movies",
                             extension(job.output.format)),
                 "leave them out");
  }
  if (flags.quality && job.movie.lossless) {
    return usage("--lossless leaves no choice of --quality", "leave one of them out");
  }
  if (flags.quality) job.movie.quality = *flags.quality;
  return {};
}

// What can be refined or cut short is light.
Result<void> check_light(const RenderJob& job) {
  const RenderSettings& settings = job.settings;
  const bool exr = job.output.format == OutputFormat::exr;
  const bool light = exr ? job.layers.color || !job.contact_sheet.empty() : job.view.wants_light();
  if (light || (settings.subsampling == 1 && settings.time_budget_ms == 0.0 && !job.progressive)) {
    return {};
  }
  return usage("--subsample, --time-budget and --progressive change how light is drawn, and " +
                   std::string(exr ? "these --layers hold" : "this --view shows") + " none",
               exr ? "leave them out, or add the layer color" : "leave them out");
}

Result<void> read_output(const Flags& flags, RenderJob& job) {
  SINEW_TRY(job.output, parse_output_name(flags.output, flags.format));
  const bool movie = is_movie(job.output.format);
  SINEW_CHECKED(read_compression(flags, job));
  SINEW_CHECKED(check_light(job));
  SINEW_CHECKED(check_format(flags, job));
  if (job.skip_existing && (movie || job.output.is_stdout() || !job.contact_sheet.empty())) {
    return usage("--skip-existing works for .png and .exr files without a contact sheet only",
                 "leave it out");
  }
  if (!job.contact_sheet.empty()) {
    SINEW_TRY(const OutputName sheet, parse_output_name(job.contact_sheet));
    if (sheet.format != OutputFormat::png || sheet.has_counter() || sheet.is_stdout()) {
      return usage("--contact-sheet makes one .png file", "write --contact-sheet sheet.png");
    }
  }
  if (job.output.is_stdout() && job.json == "-") {
    return usage("pictures and statistics cannot both go to standard output",
                 "give --json a file name");
  }
  return {};
}

// Linear radiance, the finished picture, and its compressed form at worst. With layers their hits,
// themselves, and what an .exr holds twice; what refinement adds up; with a time budget all rays of
// a picture at once. Of voxels what is in front, and a light's shadow map.
Result<void> check_memory(const RenderJob& job) {
  const RenderSettings& size = job.settings;
  const uint64_t limit = job.load.memory_limit, pixels = uint64_t{size.width} * size.height;
  const bool layers = job.output.format == OutputFormat::exr || job.view.view != View::shaded;
  const uint64_t map = size.voxels.shadow_map;
  uint64_t bytes = (16 + 4 + 4) * pixels;
  if (job.mode.mode == DrawMode::voxels || job.mode.mode == DrawMode::mixed) {
    bytes += 8 * pixels + 4 * map * map;
  }
  if (layers) bytes += (16 + 28 + 8 + 2 * 38) * pixels;
  if (job.progressive) bytes += 2 * 16 * pixels;
  if (size.time_budget_ms > 0.0) {
    constexpr uint64_t kBytesPerRay = 600;
    bytes += kBytesPerRay * pixels / (uint64_t{size.subsampling} * size.subsampling);
  }
  if (bytes <= limit) return {};
  return usage(fmt::format("pictures of {} x {} pixels need {} MB, and --memory-limit allows {} MB",
                           size.width, size.height, (bytes >> 20) + 1, limit >> 20),
               "choose a smaller --size or raise the limit");
}

Result<RenderJob> read(const Flags& flags) {
  RenderJob job = flags.job;
  SINEW_CHECKED(read_mode(flags, job));
  SINEW_TRY(job.update, parse_update(flags.update));
  SINEW_TRY(const ImageSize size, parse_size(flags.size));
  job.settings.width = size.width;
  job.settings.height = size.height;
  if (!flags.frames.empty()) {
    SINEW_TRY(job.frames, parse_frames(flags.frames));
  }
  SINEW_TRY(job.camera, parse_camera(flags.camera));
  if (!flags.background.empty()) {
    SINEW_TRY(job.background, parse_color(flags.background));
  }
  if (!flags.memory.empty()) {
    SINEW_TRY(job.load.memory_limit, parse_bytes(flags.memory));
  }
  if (!flags.voxel_memory.empty()) {
    SINEW_TRY(job.load.voxel_memory, parse_bytes(flags.voxel_memory, "--voxel-memory"));
    if (job.settings.voxels.skinning != VoxelSkinning::lattice) {
      return usage("--voxel-memory goes with the lattice only", "leave --voxel-skinning out");
    }
  }
  SINEW_TRY(job.view, parse_view(flags.view));
  // What a lazy update leaves open would show.
  const bool shows_boxes = job.view.view == View::boxes || job.view.view == View::heatmap;
  if (shows_boxes && job.update == UpdateMode::automatic) job.update = UpdateMode::full;
  if (!flags.layers.empty()) {
    SINEW_TRY(job.layers, parse_layers(flags.layers));
  }
  if (job.settings.time_budget_ms > 0.0 && job.settings.samples > 1 && !job.progressive) {
    return usage("a frame with --time-budget draws one sample a pixel, --samples asks for more",
                 "leave --samples out, or add --progressive, which uses them where nothing moves");
  }
  SINEW_CHECKED(read_output(flags, job));
  SINEW_CHECKED(check_memory(job));
  if (flags.progress == "json") job.progress = ProgressMode::json;
  if (flags.progress == "none") job.progress = ProgressMode::none;
  return job;
}

}  // namespace

Run define_render(CLI::App& app) {
  static Flags flags;  // the options write to it while the command line is parsed
  app.footer(kExamples);
  app.add_option("INPUT", flags.job.input, "What to draw")->required();
  add_output_options(app, flags);
  add_frame_options(app, flags);
  add_picture_options(app, flags);
  add_voxel_options(app, flags);
  add_speed_options(app, flags);
  add_engine_options(app, flags);
  return []() -> Result<int> {
    SINEW_TRY(const RenderJob job, read(flags));
    return render(job);
  };
}

}  // namespace sinew::app
