// Sample points follow Roberts' R2 sequence, whose every prefix is spread evenly.
// Based on: M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
#include "sinew/render/refinement.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "sinew/render/draw.h"
#include "sinew/render/sampling.h"
#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

constexpr uint32_t kBatchTiles = 32;  // 8,192 pixels between two looks at the clock
// Details that do not fit at once may come and go for ever.
constexpr uint32_t kMostRestarts = 64;

template <class T>
bool same_bits(const T& a, const T& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const CameraView& a, const CameraView& b) {
  return same_bits(a.to_world, b.to_world) && a.orthographic == b.orthographic &&
         a.yfov == b.yfov && a.ymag == b.ymag && a.znear == b.znear;
}

bool same_key(const Pose& a, const Pose& b) {
  return same_bits(a.placement, b.placement) && a.key == b.key &&
         a.key_fraction == b.key_fraction && a.present == b.present;
}

// Where sample `sample` of a pass lies in its pixel. The first pass is render_frame()'s.
vec2 sample_point(uint32_t pass, uint32_t sample, uint32_t samples) {
  if (pass == 0) return hammersley(sample, samples);
  const double n = static_cast<double>(pass) * samples + sample;
  const double x = 0.5 + n * 0.7548776662466927, y = 0.5 + n * 0.5698402909980532;
  return vec2(static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y)));
}

}  // namespace

bool Refinement::View::shows(const World& other_world, const Scene& other_scene,
                             const ScenePose& pose, const CameraView& other_camera,
                             const RenderSettings& other_settings) const {
  return scene == &other_scene && world == &other_world && same(camera, other_camera) &&
         settings == other_settings && same_bits(nodes, pose.nodes) &&
         same_bits(joints, pose.joints) && same_bits(visible, pose.visible) &&
         same_bits(weights, pose.weights) && same_bits(free, pose.free) &&
         std::equal(objects.begin(), objects.end(), pose.objects.begin(), pose.objects.end(),
                    same_key) &&
         std::equal(voxels.begin(), voxels.end(), pose.voxels.begin(), pose.voxels.end(), same_key);
}

void Refinement::View::keep(const World& new_world, const Scene& new_scene, const ScenePose& pose,
                            const CameraView& new_camera, const RenderSettings& new_settings) {
  scene = &new_scene;
  world = &new_world;
  camera = new_camera;
  settings = new_settings;
  nodes = pose.nodes;
  joints = pose.joints;
  visible = pose.visible;
  weights = pose.weights;
  free = pose.free;
  objects = pose.objects;
  voxels = pose.voxels;
}

// The first picture of a view. If no ray of it was spared, it is a pass already.
FrameStats Refinement::begin(const World& world, const Scene& scene, const ScenePose& pose,
                             const RenderSettings& settings, RenderScratch& scratch, Image& out) {
  const FrameStats stats = render_frame(world, scene, pose, view_.camera, settings, scratch, out);
  const bool complete = settings.subsampling == 1 && settings.time_budget_ms == 0.0;
  first_ = out;
  sum_.width = out.width;
  sum_.height = out.height;
  sum_.pixels.assign(out.pixels.size(), vec4(0.0f));
  if (complete) {
    const float samples = static_cast<float>(settings.samples);
    std::transform(out.pixels.begin(), out.pixels.end(), sum_.pixels.begin(),
                   [samples](const vec4& mean) { return mean * samples; });
  }
  passes_ = complete ? 1 : 0;
  tile_ = 0;
  paging_epoch_ = paging_epoch(scene.octrees);
  restarts_ = 0;
  return stats;
}

// Passes that show cells where there are voxels now are worth nothing. They are shown until there
// are others.
void Refinement::forget_coarser(const Scene& scene) {
  const uint64_t epoch = paging_epoch(scene.octrees);
  if (epoch == paging_epoch_ || restarts_ == kMostRestarts) return;
  show(first_);
  std::ranges::fill(sum_.pixels, vec4(0.0f));
  passes_ = tile_ = 0;
  paging_epoch_ = epoch;
  ++restarts_;
}

// The mean of what each pixel has had; tiles before tile_ are a pass ahead.
void Refinement::show(Image& out) const {
  out.width = sum_.width;
  out.height = sum_.height;
  out.pixels.resize(sum_.pixels.size());
  const TileGrid grid{out.width, out.height};
  parallel_for(out.height, 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < out.width; ++x) {
        const size_t pixel = y * out.width + x, tile = y / kTile * grid.columns + x / kTile;
        const uint32_t passes = passes_ + (tile < tile_ ? 1 : 0);
        const float samples =
            static_cast<float>(passes) * static_cast<float>(view_.settings.samples);
        out.pixels[pixel] = passes > 0 ? sum_.pixels[pixel] / samples : first_.pixels[pixel];
      }
    }
  });
}

FrameStats Refinement::draw(const World& world, const Scene& scene, const ScenePose& pose,
                            const CameraView& camera, const RenderSettings& settings,
                            RenderScratch& scratch, Image& out) {
  RenderSettings in_pass = settings;
  in_pass.time_budget_ms = 0.0;
  if (!view_.shows(world, scene, pose, camera, in_pass)) {
    view_.keep(world, scene, pose, camera, in_pass);
    return begin(world, scene, pose, settings, scratch, out);
  }
  const Deadline deadline =
      settings.time_budget_ms > 0.0 ? Deadline::after_ms(settings.time_budget_ms) : Deadline();
  Tally tally;
  const FrameContext frame =
      begin_frame(world, scene, pose, camera, in_pass, sum_.pixels.size(), scratch);
  forget_coarser(scene);
  const DrawnPixels pixels{CameraRays(camera, settings.width, settings.height),
                           {settings.width, settings.height},
                           1.0f,
                           ray_share(settings)};
  const uint32_t tiles = pixels.grid.count(), passes_before = passes_;
  // The voxels of a sample are drawn for all tiles at once.
  const bool drawn = frame.voxels && frame.voxels->rasters();
  const uint32_t batch = drawn ? tiles : kBatchTiles;
  do {
    const uint32_t last = std::min(tile_ + batch, tiles);
    in_pass.seed = passes_ == 0 ? settings.seed : hash_combine(settings.seed, passes_);
    for (uint32_t sample = 0; sample < settings.samples; ++sample) {
      const vec2 offset = sample_point(passes_, sample, settings.samples);
      if (drawn) draw_voxels(camera, in_pass, pixels, offset, scratch, tally);
      draw_tiles(frame, pixels, tile_, last, sample, offset, scratch, tally, sum_);
    }
    tile_ = last;
    if (tile_ == tiles) {
      tile_ = 0;
      ++passes_;
    }
  } while (deadline.is_set() ? !deadline.passed() : passes_ == passes_before);
  show(out);
  tally.clock.end_shading();
  return stats_of(tally, scratch);
}

}  // namespace sinew
