#include "sinew/render/voxels/voxel_shadows.h"

namespace sinew {
namespace {

constexpr float kNearestToLight = 1e-3f;  // of the diagonal of everything that casts shadows

float plane(vec4 row, vec3 p) {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

// Size of a pixel at depth one; of an orthographic view at any depth.
float pixel_of(const RasterView& view) {
  const vec3 across = vec3(view.x) - 0.5f * static_cast<float>(view.width) * vec3(view.w);
  return 1.0f / length(across);
}

void aim(const ShadingLight& light, const VoxelBodies& bodies, uint32_t size, VoxelShadowMap& out) {
  if (light.type == LightType::directional) {
    out.views = 1;
    out.view[0] = directional_view(light.direction, bodies.boxes(), size);
  } else {
    const float near = kNearestToLight * length(bodies.box().extent());
    out.views = light_views(light, std::max(near, 1e-6f), size, out.view);
  }
  out.texel = pixel_of(out.view[0]);
}

// The mean over 3 x 3 texels about (x, y), which move continuously.
float filter(const DepthMap& map, float x, float y, float depth) {
  const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
  const float fx = x - 0.5f - left, fy = y - 0.5f - top;
  const float weight_x[4] = {1.0f - fx, 1.0f, 1.0f, fx}, weight_y[4] = {1.0f - fy, 1.0f, 1.0f, fy};
  float sum = 0.0f;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const int column =
          std::clamp(static_cast<int>(left) + i - 1, 0, static_cast<int>(map.width) - 1);
      const int row =
          std::clamp(static_cast<int>(top) + j - 1, 0, static_cast<int>(map.height) - 1);
      const size_t texel = static_cast<size_t>(row) * map.width + static_cast<size_t>(column);
      if (depth <= map.depth[texel]) sum += weight_x[i] * weight_y[j];
    }
  }
  return sum / 9.0f;
}

}  // namespace

float lit_share(const VoxelShadowMap& shadow, const ShadowReceiver& receiver) {
  for (uint32_t i = 0; i < shadow.views; ++i) {
    const RasterView& view = shadow.view[i];
    vec3 p = receiver.position;
    if (receiver.diagonal > 0.0f) {
      const float texel = shadow.texel * std::max(plane(view.w, p), 0.0f);
      p += receiver.normal * shadow_lift(receiver.cosine, receiver.diagonal, texel);
    }
    const float w = plane(view.w, p), depth = plane(view.depth, p);
    const float x = plane(view.x, p) / w, y = plane(view.y, p) / w;
    const bool inside = depth > view.near && x >= kFilterReach && y >= kFilterReach &&
                        x < static_cast<float>(view.width) - kFilterReach &&
                        y < static_cast<float>(view.height) - kFilterReach;
    if (inside) return filter(shadow.map[i], x, y, depth);
  }
  return 1.0f;
}

RasterStats VoxelShadows::draw(std::span<const ShadingLight> lights, const VoxelBodies& bodies,
                               const VoxelSettings& settings, RasterPart part) {
  clear(lights.size());
  RasterStats stats;
  if (bodies.boxes().empty()) return stats;
  // Twice as coarse as pictures: the filter blurs more than that, and it halves the time.
  const RasterSettings raster{
      .smallest = 2.0f * settings.lod, .margin = 0.0f, .lod = settings.lod > 0.0f};
  size_t views = 0;
  for (size_t i = 0; i < lights.size(); ++i) {
    if (!lights[i].shadows) continue;
    aim(lights[i], bodies, settings.shadow_map, maps_[i]);
    for (uint32_t v = 0; v < maps_[i].views; ++v, ++views) {
      if (scratch_.size() == views) scratch_.push_back(make_raster_scratch());
      add(rasterize_depth(bodies.instances(), maps_[i].view[v], raster, *scratch_[views],
                          maps_[i].map[v], part),
          stats);
    }
  }
  return stats;
}

void VoxelShadows::clear(size_t lights) {
  lights_ = lights;
  if (maps_.size() < lights) maps_.resize(lights);
  for (VoxelShadowMap& map : maps_) map.views = 0;
}

}  // namespace sinew
