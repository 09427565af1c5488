// New vertices every frame, as a simulation has them: a lidar over a rippling surface. The tree is
// built once, and every sweep only moves its boxes.
#include <cmath>
#include <cstdio>
#include <vector>

#include "sinew/sinew.h"

namespace {

using sinew::vec3;

constexpr int kSide = 200;       // squares along each side of the surface
constexpr float kSize = 20.0f;   // metres
constexpr float kHeight = 3.0f;  // of the lidar above the middle, metres
constexpr int kBeams = 1800;

// The height of the surface: rings that run outwards.
float ripple(float x, float y, double seconds) {
  const float distance = std::sqrt(x * x + y * y);
  return 0.3f * std::sin(1.5f * distance - 4.0f * static_cast<float>(seconds));
}

void move(std::vector<vec3>& positions, double seconds) {
  for (vec3& p : positions) p.z = ripple(p.x, p.y, seconds);
}

}  // namespace

int main() {
  std::vector<vec3> positions;
  std::vector<sinew::uvec3> triangles;
  for (int row = 0; row <= kSide; ++row) {
    for (int column = 0; column <= kSide; ++column) {
      positions.emplace_back(kSize * (static_cast<float>(column) / kSide - 0.5f),
                             kSize * (static_cast<float>(row) / kSide - 0.5f), 0.0f);
      if (row == kSide || column == kSide) continue;
      const unsigned corner = static_cast<unsigned>(row * (kSide + 1) + column);
      triangles.emplace_back(corner, corner + 1, corner + kSide + 2);
      triangles.emplace_back(corner, corner + kSide + 2, corner + kSide + 1);
    }
  }
  auto surface = sinew::build(positions, triangles);
  if (!surface) {
    std::fprintf(stderr, "%s\n", surface.error().message().c_str());
    return 1;
  }

  // One ring of beams, 30 degrees below the horizon.
  std::vector<sinew::Ray> beams(kBeams);
  for (int i = 0; i < kBeams; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / kBeams;
    beams[static_cast<size_t>(i)].origin = {0.0f, 0.0f, kHeight};
    beams[static_cast<size_t>(i)].direction = {0.866f * std::cos(angle), 0.866f * std::sin(angle),
                                               -0.5f};
  }
  for (int sweep = 0; sweep < 10; ++sweep) {
    const double seconds = 0.1 * sweep;
    move(positions, seconds);
    if (const auto updated = surface->update(positions); !updated) {
      std::fprintf(stderr, "%s\n", updated.error().message().c_str());
      return 1;
    }
    double sum = 0.0, largest_error = 0.0;
    for (const sinew::Ray& beam : beams) {
      const auto hit = surface->closest_hit(beam);
      if (!hit) continue;
      sum += static_cast<double>(hit->t);
      const vec3 point = beam.origin + hit->t * beam.direction;
      const float error = point.z - ripple(point.x, point.y, seconds);
      largest_error = std::fmax(largest_error, static_cast<double>(std::fabs(error)));
    }
    std::printf("%.1f s: mean range %.3f m; the mesh is within %.1f mm of the formula\n", seconds,
                sum / kBeams, 1000.0 * largest_error);
  }
}
