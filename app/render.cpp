// `sinew render`: load, choose frames and camera, then update, draw and write one frame after the
// other. Everything that can be refused is refused before the first frame is drawn.
#include "app/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "app/command.h"
#include "app/contact_sheet.h"
#include "app/frame_output.h"
#include "app/frames.h"
#include "app/hide.h"
#include "app/interrupt.h"
#include "app/report.h"
#include "sinew/base/parallel.h"
#include "sinew/io/output_file.h"
#include "sinew/render/refinement.h"
#include "sinew/world/world.h"

namespace sinew::app {
namespace {

tl::unexpected<Error> usage(std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", "", std::move(problem), std::move(remedy)});
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

// Puts an opaque colour behind the picture.
void lay_under(Image8& image, const Rgb& color) {
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    const uint32_t alpha = image.pixels[i + 3];
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t mixed = alpha * image.pixels[i + c] + (255 - alpha) * color[c];
      image.pixels[i + c] = static_cast<uint8_t>((mixed + 127) / 255);
    }
    image.pixels[i + 3] = 255;
  }
}

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

constexpr double kLeastBudget = 0.1;  // ms for rays, so that there is a picture

// The scene on its way through the frames.
struct Stage {
  const RenderJob& job;
  const Scene& scene;
  World& world;
  const FrameCamera& camera;
  RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement{};
  double finish_ms = 0.0;  // what the last picture took beyond update and radiance
  LayerScratch layer_scratch{};
  CameraView view{};
  Image radiance{};
  FrameLayers layers{};
  Image8 picture{};
  uint32_t absent = 0;  // most objects left out of a frame
};

// Light in the picture, within what is left of the frame's time since `start`.
FrameStats draw_radiance(Stage& stage, Clock::time_point start, RenderSettings settings) {
  if (settings.time_budget_ms > 0.0) {
    settings.time_budget_ms =
        std::max(settings.time_budget_ms - ms_since(start) - stage.finish_ms, kLeastBudget);
  }
  const ScenePose& pose = stage.world.pose();
  return stage.job.progressive ? stage.refinement.draw(stage.world, stage.scene, pose, stage.view,
                                                       settings, *stage.scratch, stage.radiance)
                               : render_frame(stage.world, stage.scene, pose, stage.view, settings,
                                              *stage.scratch, stage.radiance);
}

// Traces what the output is made of, to stage.radiance and stage.layers, and makes stage.picture.
void draw_picture(Stage& stage, Clock::time_point start, FrameRecord& record) {
  const RenderJob& job = stage.job;
  const bool exr = job.output.format == OutputFormat::exr;
  const LayerChoice choice = exr ? job.layers : layers_for(job.view);
  RenderSettings settings = job.settings;
  settings.transparent |= job.background.has_value();
  const ScenePose& pose = stage.world.pose();
  const bool shows = !exr || !job.contact_sheet.empty();
  if (choice.color || (exr && shows)) {
    record.stats = draw_radiance(stage, start, settings);
  }
  const Clock::time_point drawn = Clock::now();
  trace_layers(stage.world, stage.scene, pose, stage.view, settings.width, settings.height, choice,
               stage.layer_scratch, stage.layers);
  if (!shows) return;
  if (job.view.wants_light()) tonemap(stage.radiance, settings.exposure, stage.picture);
  if (job.background) lay_under(stage.picture, *job.background);
  record.view = draw_view(job.view, stage.world, stage.view, stage.layers, stage.picture);
  stage.finish_ms = ms_since(drawn);
}

// Moves the world to the shot's time and draws it.
Result<FrameRecord> draw(Stage& stage, const Shot& shot) {
  const Clock::time_point start = Clock::now();
  SINEW_CHECKED(stage.world.set_time(shot.time));
  const ScenePose& pose = stage.world.pose();
  stage.absent = std::max(stage.absent, pose.absent);
  FrameRecord record;
  record.shot = shot;
  record.update_ms = stage.world.stats().update_ms;
  stage.view = stage.camera.view(stage.scene, pose);
  draw_picture(stage, start, record);
  record.total_ms = ms_since(start);
  return record;
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
    SINEW_TRY(const FrameRecord record, draw(stage, shot));
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
  print_note(fmt::format("{} {} to {} in {}: {:.1f} ms a frame without writing, {:.1f} Mrays/s",
                         count, count == 1 ? "frame" : "frames",
                         report.output == "-" ? "standard output" : report.output,
                         format_duration(elapsed_s), frame_ms / static_cast<double>(count),
                         trace_ms > 0.0 ? rays / trace_ms * 1e-3 : 0.0));
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
  report.settings = job.settings;
  report.warnings = frame_warnings(job, timeline);
  report.warnings.insert(report.warnings.begin(), scene.warnings.begin(), scene.warnings.end());
  if (clip != kRestPose) report.clip = scene.clips[static_cast<size_t>(clip)].name;
  return report;
}

Result<void> draw_scene(const RenderJob& job, const Scene& scene, int clip,
                        const std::vector<Shot>& shots, RenderReport& report) {
  const RenderSettings& settings = job.settings;
  const float aspect = static_cast<float>(settings.width) / static_cast<float>(settings.height);
  SINEW_TRY(const FrameCamera camera, FrameCamera::choose(job.camera, scene, clip, aspect));
  SINEW_TRY(World world, prepare(scene, {.clip = job.clip, .build = {}}));
  Stage stage{job, scene, world, camera};
  SINEW_CHECKED(draw_all(stage, shots, report));
  if (stage.absent > 0) {
    report.warnings.push_back(
        fmt::format("up to {} objects are missing from a frame, because their placement flattens "
                    "them or is not finite",
                    stage.absent));
    print_warnings({report.warnings.back()});
  }
  return {};
}

}  // namespace

Result<int> render(const RenderJob& job) {
  SINEW_CHECKED(check_outputs(job));
  const auto start = std::chrono::steady_clock::now();
  const ThreadLimit threads(job.threads);
  SINEW_TRY(Scene scene, load(job.input, job.load));
  SINEW_CHECKED(hide_objects(scene, job.hide));
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
