#include "sinew/render/voxels/voxel_frame.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/shade.h"
#include "sinew/render/voxels/voxel_opponents.h"
#include "sinew/render/voxels/voxel_primary.h"
#include "sinew/render/voxels/voxel_tiles.h"
#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

constexpr size_t kTilesPerTask = 4;

double now_ms() {
  using namespace std::chrono;
  return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
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

void shade_tile(const VoxelPass& pass, size_t index, Image& out) {
  const Tile tile = shading_tile(pass.visibility, index);
  TileWinners winners;
  VoxelBatch batch;
  alignas(64) Radiance radiance;
  list_winners(pass.visibility, tile, winners);
  if (winners.count > 0) {
    const std::span<const VisibilityKey> keys(winners.keys, winners.count);
    if (pass.kept != nullptr) {
      pass.kept->fetch(index, keys, batch);
    } else {
      pass.fetch(keys, batch);
    }
    shade_voxels(pass.lighting, batch, radiance);
  }
  const bool whole = pass.first && pass.share == 1.0f;
  vec4 buffer[kTileWidth];
  for (uint32_t y = 0; y < tile.height; ++y) {
    vec4* const pixels = &out.pixels[size_t{tile.top + y} * out.width + tile.left];
    vec4* const row = whole ? pixels : buffer;
    const uint16_t* const winner = winners.index[y];
    const bool covered =
        std::none_of(winner, winner + tile.width, [](uint16_t i) { return i == kBackground; });
    if (!covered) lay_background(pass, tile, y, row);
    for (uint32_t x = 0; x < tile.width; ++x) {
      if (winner[x] == kBackground) continue;
      const float* const c = radiance[winner[x]];
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
  parallel_for(shading_tiles(pass.visibility), kTilesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) shade_tile(pass, i, out);
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
  in_parts_ = keeps_ = false;
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
  in_parts_ = keeps_ = false;
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
  stats_.shadows = {};
  draw_in_parts(
      [&](RasterPart part) {
        add(shadows_.draw(lights, bodies_, settings_, part), stats_.shadows);
      },
      [] {});
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

// Draws part after part until all that is seen was drawn; keep() before the detail of what was
// drawn goes, and in the end. Returns whether it was called.
template <class Draw, class Keep>
bool VoxelFrame::draw_in_parts(const Draw& draw, const Keep& keep) {
  const std::span<const Svo> octrees = scene_->octrees;
  bool keeps = false;
  if (!begin_parts(octrees)) {
    draw(RasterPart::whole);
    return false;
  }
  draw(RasterPart::first);
  while (end_part(octrees)) {
    if (!part_fits(octrees)) {
      keep();
      keeps = true;
    }
    read_part(octrees);
    draw(RasterPart::more);
  }
  if (keeps) keep();
  end_parts(octrees);
  if (world_ != nullptr) world_->refresh_octrees();
  return keeps;
}

void VoxelFrame::draw(const CameraView& camera, uint32_t width, uint32_t height, uint32_t step,
                      vec2 offset) {
  const double start = now_ms();
  view_ = camera_raster_view(camera, width, height, step, offset);
  const RasterSettings raster{.smallest = settings_.lod, .lod = settings_.lod > 0.0f};
  keeps_ = false;
  if (settings_.skinning == VoxelSkinning::lattice) {
    const auto draw_part = [&](RasterPart part) {
      if (part != RasterPart::more) stats_.camera = {};
      add(rasterize(drawn_, view_, raster, *scratch_, visibility_, part), stats_.camera);
    };
    if (in_parts_) {
      kept_.clear();
      keeps_ = draw_in_parts(draw_part, [&] { kept_.keep(drawn_, visibility_); });
    } else {
      draw_settled([&] { draw_part(RasterPart::whole); });
    }
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
  SINEW_CHECK(!keeps_);
  return settings_.skinning == VoxelSkinning::lattice ? sample_voxel(drawn_, key)
                                                      : opponents_->sample(key);
}

void VoxelFrame::fetch(std::span<const VisibilityKey> keys, VoxelBatch& out) const {
  SINEW_CHECK(!keeps_);
  if (settings_.skinning == VoxelSkinning::lattice) {
    return fetch_voxels(drawn_, keys, out);
  }
  out.count = static_cast<uint32_t>(keys.size());
  for (uint32_t i = 0; i < out.count; ++i) out.set(i, opponents_->sample(keys[i]));
  out.pad();
}

void VoxelFrame::shade(const VoxelPass& pass, Image& out) {
  const double start = now_ms();
  VoxelPass from = pass;
  from.kept = keeps_ ? &kept_ : nullptr;
  shade_pass(from, out);
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
