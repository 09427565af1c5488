#include "bench/voxtrace_pictures.h"

#include <algorithm>
#include <cmath>

#include "sinew/render/frame.h"
#include "sinew/render/raster_view.h"
#include "sinew/svo/draw/rasterize.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

struct Shown {
  std::vector<uint8_t> mask;  // where the body is
  Image8 picture;
};

class Painter {
 public:
  Painter(const World& world, const CameraView& camera, uint32_t size)
      : world_(world), camera_(camera), size_(size) {}

  Shown rasterised(bool lod) const {
    const VoxelInstance instance = *world_.voxel_instance(world_.voxel_objects()[0]);
    const RasterScratchPtr scratch = make_raster_scratch();
    Visibility seen;
    rasterize({&instance, 1}, camera_raster_view(camera_, size_, size_), {.lod = lod}, *scratch,
              seen);
    return paint([&](size_t i, VoxelSample& out) {
      if (seen.keys[i] == kNothing) return false;
      out = sample_voxel({&instance, 1}, seen.keys[i]);
      return true;
    });
  }

  Shown traced(bool lod) const {
    const CameraRays make(camera_, size_, size_);
    std::vector<Ray> rays;
    for (uint32_t y = 0; y < size_; ++y) {
      for (uint32_t x = 0; x < size_; ++x) rays.push_back(make(float(x) + 0.5f, float(y) + 0.5f));
    }
    QueryOptions query;
    const float smallest = RasterSettings().smallest;
    if (lod) query.footprint = {smallest * make.pixel_width(), smallest * make.pixel_spread()};
    VoxtraceHits hits;
    trace(world_, RayKind::primary, rays, query, hits);
    return paint([&](size_t i, VoxelSample& out) {
      if (hits.closest[i].object == kNoObject) return false;
      if (world_.has_voxels(hits.closest[i].object)) {
        out = world_.sample_voxel(hits.closest[i]);
      }
      return true;
    });
  }

 private:
  // Lit from the eye.
  template <class Look>
  Shown paint(const Look& look) const {
    Image image{size_, size_, std::vector<vec4>(size_t{size_} * size_, vec4(0.0f))};
    Shown out;
    out.mask.resize(image.pixels.size());
    for (size_t i = 0; i < image.pixels.size(); ++i) {
      VoxelSample sample;
      if (!look(i, sample)) continue;
      out.mask[i] = 1;
      const float light = std::abs(dot(sample.normal, camera_.to_world[2]));
      image.pixels[i] = vec4((0.2f + 0.8f * light) * sample.color, 1.0f);
    }
    tonemap(image, 0.0f, out.picture);
    return out;
  }

  const World& world_;
  const CameraView& camera_;
  uint32_t size_;
};

// Pixels of `a` that are not of `b`, and those of them with no pixel of `b` beside them either.
struct Beyond {
  uint64_t pixels = 0, far = 0;
};
Beyond beyond(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, int size) {
  Beyond out;
  const auto at = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < size && y < size && b[size_t(y) * size_t(size) + size_t(x)] != 0;
  };
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (!a[size_t(y) * size_t(size) + size_t(x)] || at(x, y)) continue;
      ++out.pixels;
      bool near = false;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) near = near || at(x + i, y + j);
      }
      if (!near) ++out.far;
    }
  }
  return out;
}

// In dB, over the pixels that both cover, or that either does; 99 if they are equal.
double psnr(const Shown& a, const Shown& b, bool both) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < a.mask.size(); ++i) {
    if (both ? !(a.mask[i] && b.mask[i]) : !(a.mask[i] || b.mask[i])) continue;
    for (size_t c = 0; c < 3; ++c) {
      const double d = double(a.picture.pixels[4 * i + c]) - double(b.picture.pixels[4 * i + c]);
      sum += d * d;
      count += 1.0;
    }
  }
  return sum == 0.0 ? 99.0 : 10.0 * std::log10(255.0 * 255.0 * count / sum);
}

json row_of(const char* what, double u, const Shown& a, const Shown& b, uint32_t size) {
  const Beyond first = beyond(a.mask, b.mask, int(size)),
               second = beyond(b.mask, a.mask, int(size));
  return {{"table", "voxtrace_picture"},
          {"what", what},
          {"pose", u},
          {"pixels", std::ranges::count(a.mask, uint8_t{1})},
          {"only_first", first.pixels},
          {"only_second", second.pixels},
          {"far", first.far + second.far}};
}

}  // namespace

void compare_pictures(const VoxtraceWorlds& worlds, const CameraView& camera, double u,
                      const VoxtraceOptions& options, json& rows) {
  const Painter animated(worlds.world(VoxtraceEngine::animated), camera, options.size);
  const Painter triangles(worlds.world(VoxtraceEngine::triangles), camera, options.size);
  const Shown fine = animated.traced(false), plain = animated.rasterised(false);
  json row = row_of("traced, rasterised: finest voxels", u, fine, plain, options.size);
  row["level"] = "finest";
  row["psnr"] = psnr(fine, plain, false);
  row["psnr_inside"] = psnr(fine, plain, true);
  rows.push_back(std::move(row));
  const Shown coarse = animated.traced(true), coarse_plain = animated.rasterised(true);
  row = row_of("traced, rasterised: levels by pixel", u, coarse, coarse_plain, options.size);
  row["level"] = "by pixel";
  row["psnr"] = psnr(coarse, coarse_plain, false);
  row["psnr_inside"] = psnr(coarse, coarse_plain, true);
  rows.push_back(std::move(row));
  rows.push_back(row_of("traced, triangles", u, fine, triangles.traced(false), options.size));
}

}  // namespace sinew::bench
