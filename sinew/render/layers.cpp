#include "sinew/render/layers.h"

#include <algorithm>
#include <array>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/gbuffer.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/settling.h"

namespace sinew {
namespace {

constexpr size_t kRaysPerChunk = 256;

struct Pass {
  const World& world;
  const Scene& scene;
  const CameraView& camera;
  CameraRays camera_rays;
  const LayerChoice& choice;
  LayerScratch& scratch;
  FrameLayers& out;
  bool filtered;
  float lod;  // pixels

  RayCone cone() const { return {camera_rays.pixel_width(), camera_rays.pixel_spread()}; }
  bool drawn() const { return scratch.voxels.rasters(); }
  // Whether the pixel shows a voxel, drawn or traced.
  bool shows_voxel(size_t pixel) const {
    const Hit& hit = scratch.hits[pixel];
    if (hit) return hit.object >= scene.objects.size();
    return drawn() && scratch.voxels.visibility().keys[pixel] != kNothing;
  }
  Ray ray(size_t pixel) const {
    return camera_rays(static_cast<float>(pixel % out.width) + 0.5f,
                       static_cast<float>(pixel / out.width) + 0.5f);
  }
};

// Hits of the pixels [begin, end), at most kRaysPerChunk, and what each ray cost.
void trace(const Pass& pass, size_t begin, size_t end) {
  std::array<Ray, kRaysPerChunk> rays;
  const size_t count = end - begin;
  for (size_t i = 0; i < count; ++i) {
    rays[i] = pass.ray(begin + i);
    if (pass.drawn())
      rays[i].t_max = std::max(pass.scratch.voxels.t_of(begin + i, rays[i]), rays[i].t_min);
  }
  const FilterContext filter{&pass.world, &pass.scene, rays.data()};
  QueryOptions options{.facing = Facing::front};
  if (pass.filtered) options.filter = visible_filter(filter);
  if (pass.drawn()) options.hidden = pass.scratch.voxels.drawn();
  options.footprint = {pass.lod * pass.cone().width, pass.lod * pass.cone().spread};
  const std::span<Hit> hits(pass.scratch.hits.data() + begin, count);
  if (!pass.choice.traversal) {
    pass.world.closest_hits({rays.data(), count}, hits, options);
    return;
  }
  std::array<TraversalCounts, kRaysPerChunk> counts;
  pass.world.count_closest_hits({rays.data(), count}, hits, {counts.data(), count}, options);
  for (size_t i = 0; i < count; ++i) pass.out.traversal[begin + i] = counts[i].steps();
}

// The voxel in front; the same numbers whether it was drawn or traced.
void store_voxel(const Pass& pass, size_t pixel) {
  const VoxelFrame& voxels = pass.scratch.voxels;
  const Hit& hit = pass.scratch.hits[pixel];
  const Ray ray = pass.ray(pixel);
  Surface surface;
  if (hit) {
    voxels.resolve(pass.world, hit, ray, pass.cone(), surface);
  } else {
    voxels.resolve(pixel, ray, pass.cone(), surface);
  }
  if (pass.choice.object) pass.out.object[pixel] = surface.hit.object;
  if (pass.choice.primitive)
    pass.out.primitive[pixel] = hit ? hit.primitive >> 10 : surface.hit.primitive;
  if (pass.choice.depth) {
    pass.out.depth[pixel] =
        dot(surface.position - pass.camera.to_world[3], -pass.camera.to_world[2]);
  }
  if (pass.choice.normal) pass.out.normal[pixel] = surface.normal;
}

void store_hits(const Pass& pass, size_t begin, size_t end) {
  const vec3 axis = -pass.camera.to_world[2];
  for (size_t i = begin; i < end; ++i) {
    if (pass.shows_voxel(i)) {
      store_voxel(pass, i);
      continue;
    }
    const Hit& hit = pass.scratch.hits[i];
    if (pass.choice.object) pass.out.object[i] = hit.object;
    if (pass.choice.primitive) pass.out.primitive[i] = hit ? hit.primitive : kNoObject;
    if (pass.choice.depth) {
      pass.out.depth[i] =
          hit ? hit.t * dot(pass.ray(i).direction, axis) : std::numeric_limits<float>::infinity();
    }
    if (pass.choice.normal && hit) pass.scratch.attributes.touch(hit.object);
  }
}

void store_normals(const Pass& pass, size_t begin, size_t end) {
  Surface surface;
  for (size_t i = begin; i < end; ++i) {
    if (pass.shows_voxel(i)) continue;
    const Hit& hit = pass.scratch.hits[i];
    if (hit) {
      resolve_surface(pass.scene, pass.scratch.textures, pass.scratch.attributes.of(hit.object),
                      pass.ray(i), pass.cone(), hit, surface);
    }
    pass.out.normal[i] = hit ? surface.normal : vec3(0.0f);
  }
}

}  // namespace

void trace_layers(const World& world, const Scene& scene, const ScenePose& pose,
                  const CameraView& camera, uint32_t width, uint32_t height,
                  const LayerChoice& choice, LayerScratch& scratch, FrameLayers& out,
                  const VoxelSettings& voxels) {
  SINEW_CHECK(width > 0 && height > 0 && uint64_t{width} * height < (uint64_t{1} << 32));
  SINEW_CHECK(pose.objects.size() == scene.objects.size());
  const size_t pixels = size_t{width} * height;
  out.width = width;
  out.height = height;
  out.depth.resize(choice.depth ? pixels : 0);
  out.normal.resize(choice.normal ? pixels : 0);
  out.object.resize(choice.object ? pixels : 0);
  out.primitive.resize(choice.primitive ? pixels : 0);
  out.traversal.resize(choice.traversal ? pixels : 0);
  if (!choice.any_traced()) return;
  scratch.hits.resize(pixels);
  if (scratch.attributes.begin_frame(world, scene, pose, pixels)) {
    scratch.textures.build(scene);
    scratch.voxels.bind(scene, scratch.textures);
  }
  VoxelSettings settings = voxels;  // what rays cost is asked of rays
  if (choice.traversal && settings.primary == VoxelPrimary::automatic) {
    settings.primary = VoxelPrimary::trace;
  }
  scratch.voxels.begin(world, settings);
  scratch.voxels.choose(camera, width, height, 1, !scene.objects.empty());

  const Pass pass{world,     scene,   camera, CameraRays(camera, width, height),
                  choice,    scratch, out,    needs_filter(scene),
                  voxels.lod};
  Settling settling(world, scene.octrees);
  do {
    if (pass.drawn()) scratch.voxels.draw(camera, width, height, 1, vec2(0.5f));
    parallel_for(pixels, kRaysPerChunk, [&](size_t begin, size_t end) {
      trace(pass, begin, end);
      store_hits(pass, begin, end);
    });
  } while (settling.again());
  if (!choice.normal) return;
  scratch.attributes.refresh();
  parallel_for(pixels, kRaysPerChunk,
               [&](size_t begin, size_t end) { store_normals(pass, begin, end); });
}

}  // namespace sinew
