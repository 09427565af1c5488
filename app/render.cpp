// `sinew render`: load, choose frames and camera, then update, draw and write one frame after the
// other. Everything that can be refused is refused before the first frame is drawn.
#include "app/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "app/command.h"
#include "app/contact_sheet.h"
#include "app/draw_shot.h"
#include "app/frame_output.h"
#include "app/frames.h"
#include "app/hide.h"
#include "app/interrupt.h"
#include "app/tree_option.h"
#include "sinew/base/parallel.h"
#include "sinew/io/output_file.h"
#include "sinew/world/world.h"

namespace sinew::app {
namespace {

tl::unexpected<Error> usage(std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", "", std::move(problem), std::move(remedy)});
}

// What shows rays needs triangles: voxels are rasterised.
Result<void> check_view(const RenderJob& job, const Scene& scene) {
  const View view = job.view.view;
  if ((view != View::heatmap && view != View::boxes) || !scene.objects.empty()) return {};
  return usage(
      "--view heatmap and boxes show the hierarchy that rays meet, and this scene has only "
      "voxels, which are rasterised",
      "use --view shaded, normals, depth or objects");
}

Result<void> check_outputs(const RenderJob& job) {
  SINEW_CHECKED(check_writable(job.output.of_frame(1)));
  if (!job.contact_sheet.empty()) SINEW_CHECKED(check_writable(job.contact_sheet));
  if (!job.json.empty()) SINEW_CHECKED(check_writable(job.json));
  return {};
}

Result<std::vector<Shot>> choose_shots(const RenderJob& job, const Timeline& timeline) {
  std::vector<Shot> shots;
  if (job.time) return std::vector<Shot>{{1, *job.time}};
  std::vector<int> frames = job.frames;
  for (int frame = 1; job.frames.empty() && frame <= timeline.frames; ++frame) {
    frames.push_back(frame);
  }
  for (const int frame : frames) shots.push_back({frame, frame_time(timeline, frame)});
  if (shots.size() > 1 && !is_movie(job.output.format) && !job.output.has_counter()) {
    return usage(fmt::format("{} frames cannot all go to '{}'", shots.size(), job.output.path),
                 fmt::format("name the output out_####.{} or out.webp, or choose one picture with "
                             "--frames 1 or --time 0",
                             extension(job.output.format)));
  }
  return shots;
}

std::vector<Shot> without_existing(const std::vector<Shot>& shots, const OutputName& name) {
  std::vector<Shot> missing;
  std::error_code ignored;
  std::copy_if(shots.begin(), shots.end(), std::back_inserter(missing), [&](const Shot& shot) {
    return !std::filesystem::exists(name.of_frame(shot.frame), ignored);
  });
  return missing;
}

// What a picture of one view says about itself.
ImageMetadata about_view(const ViewRecord& record) {
  if (!record.steps) return {};
  return {{"TraversalSteps", fmt::format("mean {:.2f}, largest {}; brightest colour: {}",
                                         record.steps->mean, record.steps->largest, record.scale)}};
}

ImageMetadata about(const RenderJob& job, const std::string& clip) {
  ImageMetadata metadata = {{"Software", "sinew " SINEW_VERSION}, {"Source", job.input}};
  if (!clip.empty()) metadata.emplace_back("Clip", clip);
  return metadata;
}

// Draws and writes all shots; what was measured goes to `report`.
Result<void> draw_all(Stage& stage, const std::vector<Shot>& shots, RenderReport& report) {
  const RenderJob& job = stage.job;
  MovieOptions movie = job.movie;
  movie.fps = report.fps;
  const ImageSize size{job.settings.width, job.settings.height};
  SINEW_TRY(FrameOutput output,
            FrameOutput::open(job.output, size, movie, job.layers, about(job, report.clip)));
  ContactSheet sheet(size, shots.size());
  Progress progress(job.progress, shots.size());
  size_t done = 0;
  const OnInterrupt clean_up([&] {
    output.abandon();
    progress.clear();
    print_error(fmt::format("interrupted after {} of {} frames", done, shots.size()));
  });
  for (const Shot& shot : shots) {
    SINEW_TRY(const FrameRecord record, draw_shot(stage, shot));
    const Uninterrupted writing;
    SINEW_CHECKED(output.add(
        {shot, stage.view, stage.picture, stage.radiance, stage.layers, about_view(record.view)}));
    if (!job.contact_sheet.empty()) sheet.add(done, stage.picture);
    report.frames.push_back(record);
    ++done;
    progress.frame_done(shot.frame, record.total_ms);
  }
  const Uninterrupted writing;
  SINEW_CHECKED(output.finish());
  if (!job.contact_sheet.empty()) {
    SINEW_CHECKED(write_png(job.contact_sheet, sheet.image(), about(job, report.clip)));
  }
  return {};
}

void print_summary(const RenderReport& report, double elapsed_s) {
  double frame_ms = 0.0, trace_ms = 0.0, rays = 0.0;
  for (const FrameRecord& frame : report.frames) {
    frame_ms += frame.total_ms;
    trace_ms += frame.stats.trace_ms;
    rays += static_cast<double>(frame.stats.rays.total());
  }
  const size_t count = report.frames.size();
  std::string note = fmt::format("{} {} to {} in {}: {:.1f} ms a frame without writing", count,
                                 count == 1 ? "frame" : "frames",
                                 report.output == "-" ? "standard output" : report.output,
                                 format_duration(elapsed_s), frame_ms / static_cast<double>(count));
  if (rays > 0.0) note += fmt::format(", {:.1f} Mrays/s", rays / trace_ms * 1e-3);
  print_note(note);
}

std::vector<std::string> frame_warnings(const RenderJob& job, const Timeline& timeline) {
  if (job.frames.empty()) return {};
  const int last = job.frames.back();
  const double time = frame_time(timeline, last);
  if (time <= timeline.end + 1.0 / timeline.fps) return {};
  return {
      fmt::format("frame {} shows {:.3f} s, but the animation ends at {:.3f} s and stands still "
                  "from there on",
                  last, time, timeline.end)};
}

RenderReport begin_report(const RenderJob& job, const Scene& scene, int clip,
                          const Timeline& timeline) {
  RenderReport report;
  report.input = job.input;
  report.output = job.output.path;
  report.fps = timeline.fps;
  report.threads = thread_count();
  report.triangles = count(scene).triangles;
  report.voxels = count(scene).voxels;
  report.settings = job.settings;
  report.warnings = frame_warnings(job, timeline);
  report.warnings.insert(report.warnings.begin(), scene.warnings.begin(), scene.warnings.end());
  if (clip != kRestPose) report.clip = scene.clips[static_cast<size_t>(clip)].name;
  return report;
}

PrepareOptions prepare_options(const RenderJob& job, const std::optional<TreeFile>& trees) {
  return {.clip = job.clip,
          .update = job.update,
          .top_tree = job.one_tree ? TopTree::treelets : TopTree::objects,
          .trees = trees ? &*trees : nullptr};
}

// The job's trees. Those that do not fit are made anew for this run; the file stays as it is.
Result<std::optional<TreeFile>> trees_of(const RenderJob& job, const Scene& scene, int clip,
                                         RenderReport& report) {
  if (job.tree.empty()) return std::nullopt;
  Result<TreeFile> trees = read_trees(job.tree, scene, clip);
  if (trees) return std::move(*trees);
  if (job.load.strict || trees.error().kind != ErrorKind::bad_input) {
    return tl::unexpected<Error>(std::move(trees).error());
  }
  report.warnings.push_back(trees.error().message() + "; trees are made anew for this run");
  print_warnings({report.warnings.back()});
  SINEW_TRY(AnimationTrees made, optimize_trees(scene, {.clip = job.clip}));
  return std::move(made.trees);
}

// Says what came and went, and what could not be shown.
void report_paging(const RenderJob& job, const Scene& scene, RenderReport& report) {
  if (job.load.voxel_memory == 0 || scene.octrees.empty()) return;
  report.paging = paging_stats(scene.octrees);
  const PagingStats& stats = *report.paging;
  const auto warn = [&](std::string text) {
    report.warnings.push_back(std::move(text));
    print_warnings({report.warnings.back()});
  };
  if (stats.damaged > 0) {
    warn(fmt::format("{} of {} blocks of voxels could not be read and are drawn coarsely: {}",
                     stats.damaged, stats.blocks, stats.problem));
  }
  if (stats.missing > 0) {
    warn(fmt::format("--voxel-memory does not hold all that is seen: {} blocks of voxels are drawn "
                     "coarsely in the last frame",
                     stats.missing));
  }
}

Result<void> draw_scene(const RenderJob& job, const Scene& scene, int clip,
                        const std::vector<Shot>& shots, RenderReport& report) {
  const RenderSettings& settings = job.settings;
  const float aspect = static_cast<float>(settings.width) / static_cast<float>(settings.height);
  SINEW_TRY(const FrameCamera camera, FrameCamera::choose(job.camera, scene, clip, aspect));
  SINEW_TRY(const std::optional<TreeFile> trees, trees_of(job, scene, clip, report));
  SINEW_TRY(World world, prepare(scene, prepare_options(job, trees)));
  Stage stage{job, scene, world, camera};
  SINEW_CHECKED(draw_all(stage, shots, report));
  if (stage.absent > 0) {
    report.warnings.push_back(
        fmt::format("up to {} objects are missing from a frame, because their placement flattens "
                    "them or is not finite",
                    stage.absent));
    print_warnings({report.warnings.back()});
  }
  report_paging(job, scene, report);
  return {};
}

}  // namespace

Result<int> render(const RenderJob& job) {
  SINEW_CHECKED(check_outputs(job));
  const auto start = std::chrono::steady_clock::now();
  const ThreadLimit threads(job.threads);
  SINEW_TRY(Scene scene, load(job.input, job.load));
  SINEW_CHECKED(hide_objects(scene, job.hide));
  SINEW_CHECKED(apply_mode(job.mode, job.load.memory_limit, scene));
  SINEW_CHECKED(check_view(job, scene));
  SINEW_TRY(const int clip, find_clip(scene, job.clip));
  const Timeline timeline = timeline_of(scene, clip, job.fps);
  SINEW_TRY(std::vector<Shot> shots, choose_shots(job, timeline));
  if (job.skip_existing) shots = without_existing(shots, job.output);

  RenderReport report = begin_report(job, scene, clip, timeline);
  print_warnings(report.warnings);
  if (!shots.empty()) SINEW_CHECKED(draw_scene(job, scene, clip, shots, report));
  if (!job.json.empty()) {
    const Uninterrupted writing;
    SINEW_CHECKED(write_file(job.json, to_json(report)));
  }
  if (job.progress == ProgressMode::none) return kOk;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (shots.empty()) print_note("every frame is there already");
  if (!shots.empty()) print_summary(report, elapsed.count());
  return kOk;
}

}  // namespace sinew::app
