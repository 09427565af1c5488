// One tree for a whole animation of your own vertices: a tower of plates, each turning at its own
// speed and flying outwards. A tree built for the first frame decays as its parts mix; one that is
// optimised over a few frames suits them all. Hits are the same, what rays cost is not.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "sinew/sinew.h"

namespace {

using sinew::vec3;

constexpr int kPlates = 60;
constexpr int kSide = 12;        // squares along each side of a plate
constexpr int kFrames = 48;      // of the animation
constexpr int kLookedAt = 5;     // frames that the tree is made for
constexpr float kRadius = 4.0f;  // of the orbit of the outermost plate
constexpr int kRays = 20000;

struct Mesh {
  std::vector<vec3> positions;
  std::vector<sinew::uvec3> triangles;
};

Mesh make_plates() {
  Mesh mesh;
  for (int plate = 0; plate < kPlates; ++plate) {
    const float height = 0.05f * static_cast<float>(plate);
    const unsigned first = static_cast<unsigned>(mesh.positions.size());
    for (int row = 0; row <= kSide; ++row) {
      for (int column = 0; column <= kSide; ++column) {
        mesh.positions.emplace_back(static_cast<float>(column) / kSide - 0.5f, height,
                                    static_cast<float>(row) / kSide - 0.5f);
        if (row == kSide || column == kSide) continue;
        const unsigned corner = first + static_cast<unsigned>(row * (kSide + 1) + column);
        mesh.triangles.emplace_back(corner, corner + 1, corner + kSide + 2);
        mesh.triangles.emplace_back(corner, corner + kSide + 2, corner + kSide + 1);
      }
    }
  }
  return mesh;
}

// Where the vertices are in a frame: plates fly out along spirals, the later ones further.
std::vector<vec3> positions_in(const Mesh& rest, int frame) {
  const float t = static_cast<float>(frame) / (kFrames - 1);
  std::vector<vec3> out = rest.positions;
  const size_t per_plate = out.size() / kPlates;
  for (size_t v = 0; v < out.size(); ++v) {
    const float plate = static_cast<float>(v / per_plate);
    const float angle = t * (2.0f + 0.7f * plate), radius = t * kRadius * plate / kPlates;
    const vec3 p = out[v];
    out[v] = {std::cos(angle) * (p.x + radius) - std::sin(angle) * p.z, p.y,
              std::sin(angle) * (p.x + radius) + std::cos(angle) * p.z};
  }
  return out;
}

// Rays from a ring of points around the box, through its inside.
std::vector<sinew::Ray> rays_through(const sinew::Box& box) {
  std::vector<sinew::Ray> rays(kRays);
  for (int i = 0; i < kRays; ++i) {
    const float turn = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / kRays;
    const float along = std::fmod(0.618034f * static_cast<float>(i), 1.0f) - 0.5f;
    sinew::Ray& ray = rays[static_cast<size_t>(i)];
    ray.origin = box.center() + 10.0f * vec3(std::cos(turn), 0.4f, std::sin(turn));
    ray.direction = box.center() + along * box.extent() - ray.origin;
  }
  return rays;
}

// The second time, when everything that rays need is made.
double nanoseconds_a_ray(const sinew::Bvh& bvh, const std::vector<sinew::Ray>& rays,
                         std::vector<sinew::Hit>& hits) {
  bvh.closest_hits(rays, hits);
  const auto start = std::chrono::steady_clock::now();
  bvh.closest_hits(rays, hits);
  const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
  return elapsed.count() / static_cast<double>(rays.size());
}

}  // namespace

int main() {
  const Mesh mesh = make_plates();

  // The boxes of all triangles in a few frames of the animation.
  std::vector<std::vector<sinew::Box>> boxes;
  for (int i = 0; i < kLookedAt; ++i) {
    const std::vector<vec3> positions = positions_in(mesh, i * (kFrames - 1) / (kLookedAt - 1));
    sinew::triangle_boxes(positions, mesh.triangles, boxes.emplace_back(mesh.triangles.size()));
  }
  const sinew::FrameBoxes frames = sinew::make_frame_boxes(std::move(boxes));
  const sinew::TimedTree tree = sinew::traced_tree(sinew::build_optimized(frames), frames, 0.0);

  auto usual = sinew::build(mesh.positions, mesh.triangles);
  auto suited = sinew::build(mesh.positions, mesh.triangles, tree.tree, tree.areas);
  for (const auto* built : {&usual, &suited}) {
    if (*built) continue;
    std::fprintf(stderr, "%s\n", built->error().message().c_str());
    return 1;
  }

  std::vector<sinew::Hit> hits(kRays), same_hits(kRays);
  for (int frame = 0; frame < kFrames; frame += 6) {
    const std::vector<vec3> positions = positions_in(mesh, frame);
    if (!usual->update(positions) || !suited->update(positions)) return 1;
    const std::vector<sinew::Ray> rays = rays_through(usual->box());
    const double usual_ns = nanoseconds_a_ray(*usual, rays, hits);
    const double suited_ns = nanoseconds_a_ray(*suited, rays, same_hits);
    int found = 0, different = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
      if (hits[i]) ++found;
      if (hits[i].t != same_hits[i].t || hits[i].primitive != same_hits[i].primitive) ++different;
    }
    std::printf("frame %2d: %5d hits, %d differ; %4.0f ns a ray, with the suited tree %4.0f\n",
                frame, found, different, usual_ns, suited_ns);
  }
}
