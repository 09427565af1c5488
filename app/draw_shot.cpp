#include "app/draw_shot.h"

#include <algorithm>
#include <chrono>

namespace sinew::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLeastBudget = 0.1;  // ms for rays, so that there is a picture

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
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
               stage.layer_scratch, stage.layers, settings.voxels);
  if (shows) {
    if (job.view.wants_light()) {
      tonemap(stage.radiance, settings.exposure, stage.picture);
      if (job.background) lay_under(stage.picture, *job.background);
    }
    record.view = draw_view(job.view, stage.world, stage.view, stage.layers, stage.picture);
  }
  stage.finish_ms = ms_since(drawn);
}

}  // namespace

Result<FrameRecord> draw_shot(Stage& stage, const Shot& shot) {
  const Clock::time_point start = Clock::now();
  SINEW_CHECKED(stage.world.set_time(shot.time));
  const ScenePose& pose = stage.world.pose();
  stage.absent = std::max(stage.absent, pose.absent);
  FrameRecord record;
  record.shot = shot;
  stage.view = stage.camera.view(stage.scene, pose);
  draw_picture(stage, start, record);
  record.update = stage.world.stats();
  record.total_ms = ms_since(start);
  return record;
}

}  // namespace sinew::app
