#include "bench/asvo_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "bench/asvo_methods.h"
#include "bench/html_image.h"
#include "bench/measure.h"
#include "sinew/io/flip.h"
#include "sinew/render/frame.h"
#include "sinew/render/lights.h"
#include "sinew/render/raster_view.h"
#include "sinew/render/texture.h"
#include "sinew/render/voxels/voxel_frame.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kFrames = 4;
constexpr uint32_t kReferenceSamples = 1;  // through pixel centres, as the rasterisers see them

// In dB, over the pixels of the mask; 99 if they are equal.
double psnr(const Image8& a, const Image8& b, const std::vector<uint8_t>& mask) {
  double sum = 0.0;
  uint64_t count = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    if (!mask[i]) continue;
    for (size_t c = 0; c < 3; ++c) {
      const double d = double(a.pixels[4 * i + c]) - double(b.pixels[4 * i + c]);
      sum += d * d;
      ++count;
    }
  }
  return sum == 0.0 ? 99.0 : 10.0 * std::log10(255.0 * 255.0 * double(count) / sum);
}

double mean_over(const std::vector<float>& errors, const std::vector<uint8_t>& mask) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < mask.size(); ++i) {
    if (!mask[i]) continue;
    sum += errors[i];
    count += 1.0;
  }
  return count == 0.0 ? 0.0 : sum / count;
}

class PictureMaker {
 public:
  PictureMaker(const AsvoBody& body, const AsvoOptions& options, World world)
      : body_(body), size_(options.size), painter_(body), world_(std::move(world)) {
    textures_.build(body.voxels);
    frame_.bind(body.voxels, textures_);
  }

  Result<void> set_frame(double u) {
    const Clip& clip = body_.triangles.clips[0];
    const double time = clip.start + u * (clip.end - clip.start);
    SINEW_CHECKED(world_.set_time(time));
    pose_at(body_, 0, u, pose_);
    painter_.set_pose(pose_);
    camera_ = body_camera(body_box(body_, pose_), 0.9f);
    gather_lights(body_.voxels, pose_.drawn, camera_, lights_);
    frame_.begin(body_.voxels, pose_.drawn, {});
    frame_.set_shadows(lights_, true);
    return {};
  }

  Image8 reference() {
    RenderSettings settings;
    settings.width = settings.height = size_;
    settings.samples = kReferenceSamples;
    settings.reflections = 0;
    Image radiance;
    Image8 out;
    render_frame(world_, body_.triangles, world_.pose(), camera_, settings, *scratch_, radiance);
    tonemap(radiance, 0.0f, out);
    return out;
  }

  Image8 picture(AsvoMethod method) {
    const RasterView view = camera_raster_view(camera_, size_, size_);
    painter_.draw(method, view, visibility_);
    const VoxelLighting lighting{frame_.materials(), lights_, frame_.shadows(),
                                 body_.voxels.environment, camera_};
    const auto fetch = [&](std::span<const VisibilityKey> keys, VoxelBatch& out) {
      out.count = static_cast<uint32_t>(keys.size());
      for (uint32_t i = 0; i < out.count; ++i) out.set(i, sample(method, keys[i]));
      out.pad();
    };
    Image radiance{size_, size_, std::vector<vec4>(size_t{size_} * size_)};
    shade_pass({lighting, visibility_, VoxelFetch(fetch), size_, size_}, radiance);
    Image8 out;
    tonemap(radiance, 0.0f, out);
    return out;
  }

  // Pixels that the last picture covers.
  std::vector<uint8_t> mask() const {
    std::vector<uint8_t> out;
    for (const VisibilityKey key : visibility_.keys) out.push_back(key != kNothing);
    return out;
  }

 private:
  VoxelSample sample(AsvoMethod method, VisibilityKey key) {
    if (method == AsvoMethod::lattice) {
      const VoxelInstance instance = painter_.lattice_instance();
      return sample_voxel({&instance, 1}, key);
    }
    if (method == AsvoMethod::corners) {
      const CornerInstance instance = painter_.corner_instance();
      return sample_corners({&instance, 1}, key);
    }
    const ThesisInstance instance = painter_.thesis_instance();
    return sample_thesis({&instance, 1}, key);
  }

  const AsvoBody& body_;
  uint32_t size_;
  AsvoPainter painter_;
  World world_;
  TextureTable textures_;
  VoxelFrame frame_;
  AsvoPose pose_;
  CameraView camera_;
  std::vector<ShadingLight> lights_;
  RenderScratchPtr scratch_ = make_render_scratch();
  Visibility visibility_;
};

struct Errors {
  std::vector<double> psnr, flip, psnr_body, flip_body;
};

}  // namespace

Result<void> measure_images(const AsvoBody& body, const AsvoOptions& options, json& rows,
                            std::string& pictures) {
  if (body.turns || body.triangles.clips.empty()) return {};
  SINEW_TRY(World world, prepare(body.triangles));
  PictureMaker maker(body, options, std::move(world));
  std::map<AsvoMethod, Errors> errors;
  for (uint32_t f = 0; f < kFrames; ++f) {
    SINEW_CHECKED(maker.set_frame((f + 0.5) / kFrames));
    const Image8 reference = maker.reference();
    if (f == 0) {
      SINEW_TRY(const std::string html, html_image(reference, body.name + ", ray traced"));
      pictures += html;
    }
    std::vector<uint8_t> body_mask, everything(size_t{options.size} * options.size, 1);
    for (const AsvoMethod method : kAsvoMethods) {
      const Image8 picture = maker.picture(method);
      if (method == AsvoMethod::lattice) body_mask = maker.mask();
      SINEW_TRY(const std::vector<float> flip, flip_errors(reference, picture));
      Errors& e = errors[method];
      e.psnr.push_back(psnr(reference, picture, everything));
      e.psnr_body.push_back(psnr(reference, picture, body_mask));
      e.flip.push_back(mean_error(flip));
      e.flip_body.push_back(mean_over(flip, body_mask));
      if (f > 0) continue;
      SINEW_TRY(const std::string html,
                html_image(picture, fmt::format("{}, {}", body.name, name_of(method))));
      pictures += html;
    }
  }
  for (const auto& [method, e] : errors) {
    rows.push_back({{"table", "asvo_image"},
                    {"scene", body.name},
                    {"method", name_of(method)},
                    {"frames", kFrames},
                    {"psnr", median(e.psnr)},
                    {"flip", median(e.flip)},
                    {"psnr_of_body", median(e.psnr_body)},
                    {"flip_of_body", median(e.flip_body)}});
  }
  return {};
}

}  // namespace sinew::bench
