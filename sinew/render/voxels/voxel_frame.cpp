#include "sinew/render/voxels/voxel_frame.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/shade.h"
#include "sinew/render/voxels/voxel_opponents.h"
#include "sinew/render/voxels/voxel_primary.h"
#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

constexpr uint32_t kTileWidth = 32, kTileHeight = 16;  // pixels; a tile's winners fit a batch
static_assert(kTileWidth * kTileHeight <= kMostWinners);
constexpr size_t kTilesPerTask = 4;
constexpr uint16_t kBackground = 0xffff;

double now_ms() {
  using namespace std::chrono;
  return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

// What names a voxel in a key.
uint64_t name_of(VisibilityKey key) {
  return key & ((uint64_t{1} << 37) - 1);
}

// The voxels in a tile, each once, and which of them each pixel shows.
struct TileWinners {
  uint32_t count = 0;
  VisibilityKey keys[kMostWinners];
  uint16_t index[kTileHeight][kTileWidth];
};

struct Tile {
  uint32_t left, top, width, height;
};

void list_winners(const Visibility& visibility, const Tile& tile, TileWinners& out) {
  out.count = 0;
  uint64_t above[kTileWidth];
  std::fill_n(above, kTileWidth, ~uint64_t{0});
  for (uint32_t y = 0; y < tile.height; ++y) {
    const VisibilityKey* const row =
        &visibility.keys[size_t{tile.top + y} * visibility.width + tile.left];
    uint64_t before = ~uint64_t{0};
    for (uint32_t x = 0; x < tile.width; ++x) {
      const uint64_t name = row[x] == kNothing ? ~uint64_t{0} : name_of(row[x]);
      uint16_t& index = out.index[y][x];
      if (row[x] == kNothing) {
        index = kBackground;
      } else if (name == before) {
        index = out.index[y][x - 1];
      } else if (name == above[x]) {
        index = out.index[y - 1][x];
      } else {
        index = static_cast<uint16_t>(out.count);
        out.keys[out.count++] = row[x];
      }
      before = above[x] = name;
    }
  }
}

// What lies behind a row of the tile.
void lay_background(const VoxelPass& pass, const Tile& tile, uint32_t y, vec4* out) {
  if (pass.transparent) {
    std::fill_n(out, tile.width, vec4(0.0f));
    return;
  }
  const float step = static_cast<float>(pass.step);
  shade_background(pass.lighting.environment, pass.lighting.camera,
                   {step * (static_cast<float>(tile.left) + pass.offset.x), step,
                    step * (static_cast<float>(tile.top + y) + pass.offset.y), pass.width,
                    pass.height, tile.width},
                   out);
}

void shade_tile(const VoxelPass& pass, const Tile& tile, Image& out) {
  TileWinners winners;
  VoxelBatch batch;
  alignas(64) Radiance radiance;
  list_winners(pass.visibility, tile, winners);
  if (winners.count > 0) {
    pass.fetch({winners.keys, winners.count}, batch);
    shade_voxels(pass.lighting, batch, radiance);
  }
  const bool whole = pass.first && pass.share == 1.0f;
  vec4 buffer[kTileWidth];
  for (uint32_t y = 0; y < tile.height; ++y) {
    vec4* const pixels = &out.pixels[size_t{tile.top + y} * out.width + tile.left];
    vec4* const row = whole ? pixels : buffer;
    const uint16_t* const index = winners.index[y];
    const bool covered =
        std::none_of(index, index + tile.width, [](uint16_t i) { return i == kBackground; });
    if (!covered) lay_background(pass, tile, y, row);
    for (uint32_t x = 0; x < tile.width; ++x) {
      if (index[x] == kBackground) continue;
      const float* const c = radiance[index[x]];
      row[x] = vec4(c[0], c[1], c[2], c[3]);
    }
    if (whole) continue;
    for (uint32_t x = 0; x < tile.width; ++x) {
      pixels[x] = (pass.first ? vec4(0.0f) : pixels[x]) + pass.share * row[x];
    }
  }
}

// What is worth tracing a picture for that needs no rays otherwise. What gleams less shows the
// environment then.
bool is_mirror(const VoxelMaterial& material) {
  constexpr float kLeast = 0.1f;  // share of light that is reflected
  const vec3 d = material.dielectric;
  const float share = glm::mix(std::max({d.x, d.y, d.z}), 1.0f, material.metallic);
  return share >= kLeast && mirror_share(material.roughness) > 0.0f && !(material.unlit > 0.0f);
}

}  // namespace

void shade_pass(const VoxelPass& pass, Image& out) {
  const uint32_t width = pass.visibility.width, height = pass.visibility.height;
  SINEW_CHECK(out.width == width && out.height == height);
  const uint32_t columns = (width + kTileWidth - 1) / kTileWidth;
  const uint32_t rows = (height + kTileHeight - 1) / kTileHeight;
  parallel_for(size_t{columns} * rows, kTilesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t left = static_cast<uint32_t>(i % columns) * kTileWidth;
      const uint32_t top = static_cast<uint32_t>(i / columns) * kTileHeight;
      shade_tile(
          pass,
          {left, top, std::min(kTileWidth, width - left), std::min(kTileHeight, height - top)},
          out);
    }
  });
}

VoxelFrame::VoxelFrame() = default;
VoxelFrame::~VoxelFrame() = default;

void VoxelFrame::bind(const Scene& scene, const TextureTable& textures) {
  scene_ = &scene;
  bodies_.bind(scene);
  opponents_.reset();
  list_voxel_materials(scene, textures, materials_);
  mirrors_ = std::ranges::any_of(scene.octrees, [&](const Svo& svo) {
    return std::ranges::any_of(
        svo.cells, [&](const SvoCell& cell) { return is_mirror(materials_[cell.material]); });
  });
}

void VoxelFrame::begin(const World& world, const VoxelSettings& settings) {
  settings_ = settings;
  stats_ = {};
  const double start = now_ms();
  world_ = &world;
  begin_paging(scene_->octrees);
  world.refresh_octrees();
  bodies_.take(world);
  first_object_ = 0;
  draw_all();
  stats_.pose_ms = now_ms() - start;
}

void VoxelFrame::begin(const Scene& scene, const ScenePose& pose, const VoxelSettings& settings) {
  settings_ = settings;
  stats_ = {};
  const double start = now_ms();
  world_ = nullptr;
  begin_paging(scene.octrees);
  bodies_.set_pose(scene, pose);
  first_object_ = static_cast<uint32_t>(scene.objects.size());
  draw_all();
  stats_.pose_ms = now_ms() - start;
}

void VoxelFrame::set_shadows(std::span<const ShadingLight> lights, bool maps) {
  shadows_.clear(lights.size());
  if (!maps || !any()) return;
  const double start = now_ms();
  stats_.shadow_maps = true;
  bodies_.list_boxes();
  draw_settled([&] { stats_.shadows = shadows_.draw(lights, bodies_, settings_); });
  stats_.shadow_ms = now_ms() - start;
}

void VoxelFrame::draw_all() {
  stats_.objects = static_cast<uint32_t>(bodies_.instances().size());
  traced_.assign(bodies_.instances().size(), 0);
  split();
}

void VoxelFrame::split() {
  const std::span<const VoxelInstance> instances = bodies_.instances();
  drawn_.clear();
  drawn_objects_.clear();
  uint32_t objects = 0;
  for (const uint32_t object : bodies_.objects()) {
    objects = std::max(objects, first_object_ + object + 1);
  }
  hidden_drawn_.assign(objects, 0);
  hidden_all_.assign(objects, 0);
  stats_.traced = 0;
  for (size_t i = 0; i < instances.size(); ++i) {
    const uint32_t object = first_object_ + bodies_.objects()[i];
    hidden_all_[object] = 1;
    stats_.traced += traced_[i];
    if (traced_[i] != 0) continue;
    hidden_drawn_[object] = 1;
    drawn_.push_back(instances[i]);
    drawn_objects_.push_back(object);
  }
}

void VoxelFrame::choose(const CameraView& camera, uint32_t width, uint32_t height, uint32_t step,
                        bool rays) {
  const RasterView view = camera_raster_view(camera, width, height, step);
  for (size_t i = 0; i < traced_.size(); ++i) {
    traced_[i] = is_traced(bodies_.instances()[i], view, settings_, rays) ? 1 : 0;
  }
  split();
}

// Draws until nothing more comes. What hides others may become smaller with its detail, so that one
// time is not always enough; blocks that do not fit at once could take turns for ever.
template <class Draw>
void VoxelFrame::draw_settled(const Draw& draw) {
  constexpr int kMostTimes = 32;
  draw();
  bool settled = false;
  for (int i = 1; i < kMostTimes && !settled; ++i) {
    settled = !settle_paging(scene_->octrees);
    if (!settled) draw();
  }
  if (!settled) give_up_paging(scene_->octrees);
  if (world_ != nullptr) world_->refresh_octrees();
}

void VoxelFrame::draw(const CameraView& camera, uint32_t width, uint32_t height, uint32_t step,
                      vec2 offset) {
  const double start = now_ms();
  view_ = camera_raster_view(camera, width, height, step, offset);
  const RasterSettings raster{.smallest = settings_.lod, .lod = settings_.lod > 0.0f};
  if (settings_.skinning == VoxelSkinning::lattice) {
    draw_settled([&] { stats_.camera = rasterize(drawn_, view_, raster, *scratch_, visibility_); });
  } else {
    if (!opponents_) opponents_ = std::make_unique<VoxelOpponents>();
    stats_.camera = {};
    stats_.camera.voxels_drawn =
        opponents_->draw(settings_.skinning, drawn_, view_, settings_.lod, visibility_);
  }
  ++stats_.passes;
  stats_.draw_ms += now_ms() - start;
}

VoxelSample VoxelFrame::sample(VisibilityKey key) const {
  return settings_.skinning == VoxelSkinning::lattice ? sample_voxel(drawn_, key)
                                                      : opponents_->sample(key);
}

void VoxelFrame::fetch(std::span<const VisibilityKey> keys, VoxelBatch& out) const {
  if (settings_.skinning == VoxelSkinning::lattice) {
    return fetch_voxels(drawn_, keys, out);
  }
  out.count = static_cast<uint32_t>(keys.size());
  for (uint32_t i = 0; i < out.count; ++i) out.set(i, opponents_->sample(keys[i]));
  out.pad();
}

void VoxelFrame::shade(const VoxelPass& pass, Image& out) {
  const double start = now_ms();
  shade_pass(pass, out);
  stats_.shade_ms += now_ms() - start;
}

float VoxelFrame::t_of(size_t pixel, const Ray& ray) const {
  const VisibilityKey key = visibility_.keys[pixel];
  if (key == kNothing) return std::numeric_limits<float>::infinity();
  const vec3 axis(view_.depth);
  const float from = dot(axis, ray.origin) + view_.depth.w;
  return (key_depth(key) - from) / dot(axis, ray.direction);
}

void VoxelFrame::resolve(const VoxelSample& voxel, const Ray& ray, const RayCone& cone,
                         Surface& out) const {
  const vec3 direction = normalize(ray.direction);
  resolve_voxel(voxel, std::sqrt(3.0f) * voxel.size, materials_[voxel.material], -direction, out);
  const float distance = std::max(dot(voxel.position - ray.origin, direction), 0.0f);
  out.width = cone.width + cone.spread * distance;
  if (!out.from_behind) return;
  // What is seen from behind sticks out beyond a silhouette, or is an open sheet. Along its normal
  // there may be anything, but this ray came through.
  out.position = out.lifted = ray.origin + distance * direction;
  out.geometric_normal = -direction;
  out.footprint = out.voxel;
}

void VoxelFrame::resolve(size_t pixel, const Ray& ray, const RayCone& cone, Surface& out) const {
  const VoxelSample voxel = sample(visibility_.keys[pixel]);
  resolve(voxel, ray, cone, out);
  out.hit.t = t_of(pixel, ray);
  out.hit.primitive = voxel.unit;
  out.hit.object = drawn_objects_[voxel.instance];
}

void VoxelFrame::resolve(const World& world, const Hit& hit, const Ray& ray, const RayCone& cone,
                         Surface& out) const {
  resolve(world.sample_voxel(hit), ray, cone, out);
  out.hit = hit;
}

}  // namespace sinew
