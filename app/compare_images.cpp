// The numbers and the picture of `sinew compare`: of pictures as they look, or of the values of a
// layer.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "app/compare.h"
#include "sinew/io/flip.h"
#include "sinew/io/output_file.h"
#include "sinew/render/color_map.h"
#include "sinew/render/frame.h"

namespace sinew::app {
namespace {

constexpr uint64_t kMostFileBytes = uint64_t{1} << 32;

// A picture of one value a pixel, 0..1.
template <class Value>
Image8 heat_picture(ImageSize size, const Value& value) {
  Image8 image{size.width, size.height, {}};
  image.pixels.resize(size_t{4} * size.width * size.height);
  for (size_t i = 0; i < image.pixels.size() / 4; ++i) {
    const Color8 color = heat_color(value(i));
    std::copy(color.begin(), color.end(), &image.pixels[4 * i]);
    image.pixels[4 * i + 3] = 255;
  }
  return image;
}

// The picture in R, G, B and A (or opaque), finished as `sinew render` does it.
Result<Image8> finished(const ExrImage& exr, const std::string& path, double exposure) {
  const ExrPlane* planes[4];
  for (size_t c = 0; c < 4; ++c) {
    planes[c] = exr.find(std::string_view("RGBA").substr(c, 1));
    const bool usable = planes[c] != nullptr && !planes[c]->floats.empty();
    if (!usable && (c < 3 || planes[c] != nullptr)) {
      return fail({ErrorKind::bad_input, path, "", "holds no colours in R, G and B",
                   "choose one of its layers with --layer"});
    }
  }
  Image image{exr.size.width, exr.size.height, {}};
  image.pixels.resize(planes[0]->floats.size(), vec4(0.0f, 0.0f, 0.0f, 1.0f));
  for (int c = 0; c < 4; ++c) {
    for (size_t i = 0; planes[c] != nullptr && i < image.pixels.size(); ++i) {
      image.pixels[i][c] = planes[c]->floats[i];
    }
  }
  Image8 out;
  tonemap(image, static_cast<float>(exposure), out);
  return out;
}

Result<Image8> read_picture(const std::string& path, double exposure) {
  SINEW_TRY(const std::string file, read_file(path, kMostFileBytes));
  const std::span bytes(reinterpret_cast<const uint8_t*>(file.data()), file.size());
  if (is_exr(bytes)) {
    SINEW_TRY(const ExrImage exr, decode_exr(bytes, path));
    return finished(exr, path, exposure);
  }
  return decode_image(bytes, path);
}

// The channels of a layer: NAME itself and NAME.anything.
using Layer = std::map<std::string, const ExrPlane*>;

Result<Layer> find_layer(const ExrImage& exr, const std::string& path, const std::string& name) {
  Layer layer;
  for (const ExrPlane& plane : exr.planes) {
    if (plane.name == name || plane.name.starts_with(name + ".")) layer[plane.name] = &plane;
  }
  if (!layer.empty()) return layer;
  std::string list;
  for (const ExrPlane& plane : exr.planes) list += (list.empty() ? "" : ", ") + plane.name;
  return fail({ErrorKind::usage, path, "", fmt::format("has no layer '{}'", name),
               "its channels are " + list});
}

double value_of(const ExrPlane& plane, size_t pixel) {
  return plane.integers.empty() ? static_cast<double>(plane.floats[pixel])
                                : static_cast<double>(plane.integers[pixel]);
}

// Equal infinities do not differ, nor do two NaN; one of a kind differs infinitely.
double distance(double a, double b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0.0;
  const double d = std::abs(a - b);
  return std::isnan(d) ? std::numeric_limits<double>::infinity() : d;
}

}  // namespace

Result<Comparison> compare_pictures(const CompareJob& job) {
  SINEW_TRY(const Image8 first, read_picture(job.first, job.exposure));
  SINEW_TRY(const Image8 second, read_picture(job.second, job.exposure));
  Comparison result;
  result.first_size = {first.width, first.height};
  result.second_size = {second.width, second.height};
  if (!result.same_size()) return result;
  const int tolerance = static_cast<int>(job.tolerance_or_default());
  SINEW_TRY(const ImageDifference difference, compare_images(first, second, tolerance));
  SINEW_TRY(
      const std::vector<float> errors,
      flip_errors(first, second, {.pixels_per_degree = static_cast<float>(job.pixels_per_degree)}));
  result.psnr = difference.psnr;
  result.mean = difference.mean;
  result.largest = difference.largest;
  result.pixels_over = difference.pixels_over;
  result.flip = mean_error(errors);
  result.largest_flip = errors.empty() ? 0.0 : *std::max_element(errors.begin(), errors.end());
  if (!job.difference.empty()) {
    result.difference = heat_picture(result.first_size, [&](size_t i) { return errors[i]; });
  }
  return result;
}

Result<Comparison> compare_layers(const CompareJob& job) {
  SINEW_TRY(const ExrImage first, read_exr(job.first));
  SINEW_TRY(const ExrImage second, read_exr(job.second));
  SINEW_TRY(const Layer layer, find_layer(first, job.first, job.layer));
  SINEW_TRY(const Layer other, find_layer(second, job.second, job.layer));
  Comparison result;
  result.first_size = first.size;
  result.second_size = second.size;
  if (!result.same_size()) return result;
  const size_t pixels = size_t{first.size.width} * first.size.height;
  std::vector<double> largest(pixels, 0.0);  // of the pixel's channels
  double sum = 0.0;
  uint64_t values = 0;
  for (const auto& [name, plane] : layer) {
    const auto twin = other.find(name);
    if (twin == other.end() || layer.size() != other.size()) {
      return fail({ErrorKind::bad_input, job.second, "",
                   fmt::format("its layer '{}' has other channels", job.layer),
                   "compare layers of one kind"});
    }
    for (size_t i = 0; i < pixels; ++i) {
      const double d = distance(value_of(*plane, i), value_of(*twin->second, i));
      largest[i] = std::max(largest[i], d);
      if (!std::isfinite(d)) continue;
      sum += d;
      ++values;
    }
  }
  result.mean = values > 0 ? sum / static_cast<double>(values) : 0.0;
  result.largest = *std::max_element(largest.begin(), largest.end());
  const double tolerance = job.tolerance_or_default();
  result.pixels_over = static_cast<uint64_t>(
      std::count_if(largest.begin(), largest.end(), [&](double d) { return d > tolerance; }));
  if (!job.difference.empty()) {
    double scale = 1e-300;  // the largest finite difference
    for (const double d : largest) scale = std::isfinite(d) ? std::max(scale, d) : scale;
    result.difference = heat_picture(first.size, [&](size_t i) {
      return static_cast<float>(std::min(1.0, largest[i] / scale));
    });
  }
  return result;
}

}  // namespace sinew::app
