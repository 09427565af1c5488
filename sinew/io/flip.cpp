// LDR-FLIP: colours as the eye resolves them at a distance are compared in a perceptual space, and
// differences of edges and points make the result larger.
// Based on: P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild,
// "FLIP: A Difference Evaluator for Alternating Images", HPG 2020 (symbols, sections and
// equations are the paper's). Differs: all filters are applied as separable passes.
#include "sinew/io/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/io/image_file.h"
#include "sinew/math/srgb.h"
#include "sinew/math/vec.h"

namespace sinew {
namespace {

constexpr float kQc = 0.7f;              // exponent that compresses large colour differences
constexpr float kPc = 0.4f;              // share of the largest difference ...
constexpr float kPt = 0.95f;             // ... that is mapped to [0, pt]
constexpr float kQf = 0.5f;              // exponent of feature differences
constexpr float kFeatureWidth = 0.082f;  // w, degrees: of the lines that the eye detects best
constexpr float kPi = 3.14159265f;
constexpr size_t kRowsPerTask = 8;

using Plane = std::vector<vec3>;

// ---- colour spaces (D65)

// IEC 61966-2-1; columns are the primaries.
const mat3 kRgbToXyz(vec3(0.4124564f, 0.2126729f, 0.0193339f),
                     vec3(0.3575761f, 0.7151522f, 0.1191920f),
                     vec3(0.1804375f, 0.0721750f, 0.9503041f));

vec3 white() {
  return kRgbToXyz * vec3(1.0f);
}

// Linear RGB to Y Cx Cz, which is CIELab without its cube roots.
vec3 to_ycxcz(vec3 rgb) {
  const vec3 xyz = kRgbToXyz * rgb / white();
  return vec3(116.0f * xyz.y - 16.0f, 500.0f * (xyz.x - xyz.y), 200.0f * (xyz.y - xyz.z));
}
vec3 from_ycxcz(vec3 c) {
  static const mat3 to_rgb = glm::inverse(kRgbToXyz);
  const float y = (c.x + 16.0f) / 116.0f;
  return to_rgb * (vec3(c.y / 500.0f + y, y, y - c.z / 200.0f) * white());
}

vec3 to_lab(vec3 rgb) {
  const auto curve = [](float t) {
    constexpr float kDelta = 6.0f / 29.0f;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t)
                                        : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
  };
  const vec3 xyz = kRgbToXyz * rgb / white();
  const vec3 f(curve(xyz.x), curve(xyz.y), curve(xyz.z));
  return vec3(116.0f * f.y - 16.0f, 500.0f * (f.x - f.y), 200.0f * (f.y - f.z));
}

// Colours look stronger where it is lighter (Hunt's effect).
vec3 hunt(vec3 lab) {
  return vec3(lab.x, 0.01f * lab.x * lab.y, 0.01f * lab.x * lab.z);
}

// The distance HyAB: steps in lightness and in colour are seen apart and add up.
float hyab(vec3 a, vec3 b) {
  const vec3 d = a - b;
  return std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

// ---- filters

// Weights of taps -radius .. radius.
struct Kernel {
  int radius = 0;
  std::vector<float> weight;

  explicit Kernel(int r) : radius(r), weight(static_cast<size_t>(2 * r + 1)) {}
  float& operator[](int tap) { return weight[static_cast<size_t>(tap + radius)]; }
  float operator[](int tap) const { return weight[static_cast<size_t>(tap + radius)]; }
};

// Makes the positive weights sum to 1, and the negative ones to -1.
void normalize(Kernel& kernel) {
  float positive = 0.0f, negative = 0.0f;
  for (const float w : kernel.weight) (w > 0.0f ? positive : negative) += w;
  for (float& w : kernel.weight) {
    if (w != 0.0f) w /= w > 0.0f ? positive : -negative;
  }
}

struct Size {
  int width, height;
};

// Runs body(pixel index, x, y) for all pixels.
template <class Body>
void for_each_pixel(Size size, const Body& body) {
  parallel_for(static_cast<size_t>(size.height), kRowsPerTask, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (int x = 0; x < size.width; ++x) {
        body(y * static_cast<size_t>(size.width) + static_cast<size_t>(x), x, static_cast<int>(y));
      }
    }
  });
}

// Index of a neighbour in the row or the column; beyond the border is what stands at it.
size_t in_row(Size size, int x, int y, int tap) {
  return static_cast<size_t>(y) * static_cast<size_t>(size.width) +
         static_cast<size_t>(std::clamp(x + tap, 0, size.width - 1));
}
size_t in_column(Size size, int x, int y, int tap) {
  return static_cast<size_t>(std::clamp(y + tap, 0, size.height - 1)) *
             static_cast<size_t>(size.width) +
         static_cast<size_t>(x);
}

// ---- colour pipeline (section 4.1)

// The contrast sensitivities of Y, Cx and Cz as taps: a Gaussian each, and a second one of Cz.
struct Sensitivity {
  int radius = 0;
  std::vector<vec4> taps;  // Y, Cx, Cz, second of Cz; each sums to 1
  float share = 0.0f;      // of Cz that its first Gaussian has
};

// Section 4.1: a * sqrt(pi / b) * exp(-pi^2 x^2 / b), x in degrees.
Sensitivity make_sensitivity(float pixels_per_degree) {
  constexpr float kB[4] = {0.0047f, 0.0053f, 0.04f, 0.025f};
  constexpr float kA[2] = {34.1f, 13.5f};  // of Cz; the others have no second part
  Sensitivity s;
  // Three standard deviations of the widest.
  s.radius =
      static_cast<int>(std::ceil(3.0f * std::sqrt(kB[2] / (2.0f * kPi * kPi)) * pixels_per_degree));
  vec4 sum(0.0f);
  for (int tap = -s.radius; tap <= s.radius; ++tap) {
    const float x = static_cast<float>(tap) / pixels_per_degree;
    const auto gauss = [&](float b) { return std::exp(-kPi * kPi * x * x / b); };
    s.taps.push_back(vec4(gauss(kB[0]), gauss(kB[1]), gauss(kB[2]), gauss(kB[3])));
    sum += s.taps.back();
  }
  for (vec4& weight : s.taps) weight /= sum;
  const float first = kA[0] * std::sqrt(kPi / kB[2]) * sum.z * sum.z;
  const float second = kA[1] * std::sqrt(kPi / kB[3]) * sum.w * sum.w;
  s.share = first / (first + second);
  return s;
}

// What the eye resolves, as Hunt-adjusted CIELab. `in` is Y Cx Cz.
Plane perceived(const Plane& in, Size size, const Sensitivity& s) {
  const auto weight = [&](int tap) { return s.taps[static_cast<size_t>(tap + s.radius)]; };
  std::vector<vec4> rows(in.size());
  for_each_pixel(size, [&](size_t i, int x, int y) {
    vec4 sum(0.0f);
    for (int tap = -s.radius; tap <= s.radius; ++tap) {
      const vec3 c = in[in_row(size, x, y, tap)];
      sum += weight(tap) * vec4(c, c.z);
    }
    rows[i] = sum;
  });
  Plane out(in.size());
  for_each_pixel(size, [&](size_t i, int x, int y) {
    vec4 c(0.0f);
    for (int tap = -s.radius; tap <= s.radius; ++tap) {
      c += weight(tap) * rows[in_column(size, x, y, tap)];
    }
    const vec3 filtered(c.x, c.y, c.z * s.share + c.w * (1.0f - s.share));
    out[i] = hunt(to_lab(clamp(from_ycxcz(filtered), 0.0f, 1.0f)));
  });
  return out;
}

// Section 4.1.3: compresses a distance and maps it to [0, 1].
float redistribute(float distance) {
  static const float most = std::pow(
      hyab(hunt(to_lab(vec3(0.0f, 1.0f, 0.0f))), hunt(to_lab(vec3(0.0f, 0.0f, 1.0f)))), kQc);
  const float error = std::pow(distance, kQc), knee = kPc * most;
  if (error < knee) return kPt / knee * error;
  return std::min(1.0f, kPt + (error - knee) / (most - knee) * (1.0f - kPt));
}

// ---- feature pipeline (section 4.2)

struct FeatureKernels {
  Kernel smooth, edge, point;
};

FeatureKernels make_feature_kernels(float pixels_per_degree) {
  const float deviation = 0.5f * kFeatureWidth * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0f * deviation));
  FeatureKernels k{Kernel(radius), Kernel(radius), Kernel(radius)};
  for (int tap = -radius; tap <= radius; ++tap) {
    const float x = static_cast<float>(tap) / deviation;
    const float gauss = std::exp(-0.5f * x * x);
    k.smooth[tap] = gauss;
    k.edge[tap] = -x * gauss;
    k.point[tap] = (x * x - 1.0f) * gauss;
  }
  normalize(k.smooth);
  normalize(k.edge);
  normalize(k.point);
  return k;
}

// Strength of edges (x) and points (y) at every pixel of the channel Y, scaled to [0, 1].
std::vector<vec2> features(const Plane& in, Size size, const FeatureKernels& k) {
  const int radius = k.smooth.radius;
  Plane rows(in.size());  // smoothed, first and second derivative along x
  for_each_pixel(size, [&](size_t i, int x, int y) {
    vec3 sum(0.0f);
    for (int tap = -radius; tap <= radius; ++tap) {
      const float lightness = (in[in_row(size, x, y, tap)].x + 16.0f) / 116.0f;
      sum += lightness * vec3(k.smooth[tap], k.edge[tap], k.point[tap]);
    }
    rows[i] = sum;
  });
  std::vector<vec2> out(in.size());
  for_each_pixel(size, [&](size_t i, int x, int y) {
    vec2 along_x(0.0f), along_y(0.0f);  // edge, point
    for (int tap = -radius; tap <= radius; ++tap) {
      const vec3 row = rows[in_column(size, x, y, tap)];
      along_x += k.smooth[tap] * vec2(row.y, row.z);
      along_y += row.x * vec2(k.edge[tap], k.point[tap]);
    }
    out[i] = sqrt(along_x * along_x + along_y * along_y);
  });
  return out;
}

// Equation 9.
float feature_difference(vec2 a, vec2 b) {
  const vec2 d = abs(a - b);
  return std::pow(std::max(d.x, d.y) / std::sqrt(2.0f), kQf);
}

// The picture over black, as Y Cx Cz.
Plane read_image(const Image8& image) {
  const std::array<float, 256>& linear = srgb_codes_to_linear();
  Plane out(image.pixels.size() / 4);
  for (size_t i = 0; i < out.size(); ++i) {
    const uint8_t* p = &image.pixels[4 * i];
    const float alpha = static_cast<float>(p[3]) / 255.0f;
    out[i] = to_ycxcz(alpha * vec3(linear[p[0]], linear[p[1]], linear[p[2]]));
  }
  return out;
}

}  // namespace

Result<std::vector<float>> flip_errors(const Image8& a, const Image8& b, const FlipConfig& config) {
  SINEW_CHECK(a.pixels.size() == size_t{4} * a.width * a.height);
  SINEW_CHECK(b.pixels.size() == size_t{4} * b.width * b.height);
  SINEW_CHECK(config.pixels_per_degree >= 1.0f && config.pixels_per_degree <= 1000.0f);
  SINEW_CHECKED(check_same_size(a, b));
  const Size size{static_cast<int>(a.width), static_cast<int>(a.height)};
  const Sensitivity sensitivity = make_sensitivity(config.pixels_per_degree);
  const FeatureKernels kernels = make_feature_kernels(config.pixels_per_degree);
  const Plane input_a = read_image(a), input_b = read_image(b);
  const Plane color_a = perceived(input_a, size, sensitivity);
  const Plane color_b = perceived(input_b, size, sensitivity);
  const std::vector<vec2> features_a = features(input_a, size, kernels);
  const std::vector<vec2> features_b = features(input_b, size, kernels);
  std::vector<float> errors(input_a.size());
  for_each_pixel(size, [&](size_t i, int, int) {
    const float color = redistribute(hyab(color_a[i], color_b[i]));
    const float feature = feature_difference(features_a[i], features_b[i]);
    errors[i] = std::pow(color, 1.0f - feature);  // equation 10
  });
  return errors;
}

double mean_error(const std::vector<float>& errors) {
  if (errors.empty()) return 0.0;
  return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
}

}  // namespace sinew
