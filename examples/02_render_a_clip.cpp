// Draws every frame of an animation as a PNG file, and all of them as an animated WebP.
// Run it as: 02_render_a_clip [walk.glb [clip]]
#include <cstdio>
#include <string>

#include "sinew/sinew.h"

namespace {

constexpr int kFrames = 24;
constexpr double kFps = 24.0;

int report(const sinew::Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return 1;
}

int render(const std::string& input, const std::string& clip) {
  const auto scene = sinew::load(input);
  if (!scene) return report(scene.error());
  auto world = sinew::prepare(*scene, {.clip = clip});
  if (!world) return report(world.error());

  sinew::RenderSettings settings;
  settings.width = 320;
  settings.height = 240;
  settings.samples = 4;
  const float aspect = 320.0f / 240.0f;

  // One camera that sees the body through all of its motion.
  const auto index = sinew::find_clip(*scene, clip);
  if (!index) return report(index.error());
  const sinew::CameraView camera = sinew::frame_box(
      sinew::animation_bounds(*scene, *index, kFrames), {0.6f, 0.35f, 1.0f}, 0.7f, aspect);

  auto movie =
      sinew::MovieWriter::create("clip.webp", settings.width, settings.height, {.fps = kFps});
  if (!movie) return report(movie.error());
  const sinew::RenderScratchPtr scratch = sinew::make_render_scratch();
  sinew::Image radiance;
  sinew::Image8 picture;
  for (int frame = 0; frame < kFrames; ++frame) {
    if (const auto moved = world->set_time(frame / kFps); !moved) return report(moved.error());
    const sinew::FrameStats stats =
        sinew::render_frame(*world, *scene, world->pose(), camera, settings, *scratch, radiance);
    sinew::tonemap(radiance, settings.exposure, picture);

    char name[32];
    std::snprintf(name, sizeof name, "frame_%02d.png", frame + 1);
    if (const auto written = sinew::write_png(name, picture); !written) {
      return report(written.error());
    }
    if (const auto added = movie->add(picture); !added) return report(added.error());
    std::printf("%s: %.1f ms, %llu rays\n", name, stats.trace_ms + stats.shade_ms,
                static_cast<unsigned long long>(stats.rays.total()));
  }
  if (const auto finished = movie->finish(); !finished) return report(finished.error());
  std::printf("clip.webp\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return render(argc > 1 ? argv[1] : "study:creature,triangles=20000", argc > 2 ? argv[2] : "");
}
