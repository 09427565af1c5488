// Traces a ray at a mesh that moves: build once, update every frame. Then the same with a scene
// from a file. Run it as: 01_trace_a_ray [walk.glb]
#include <cstdio>
#include <vector>

#include "sinew/sinew.h"

namespace {

using sinew::vec3;

// A single mesh: bring your own vertices and triangles.
int trace_a_mesh() {
  std::vector<vec3> positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  const std::vector<sinew::uvec3> triangles = {{0, 1, 2}};

  auto bvh = sinew::build(positions, triangles);
  if (!bvh) {
    std::fprintf(stderr, "%s\n", bvh.error().message().c_str());
    return 1;
  }
  for (int frame = 0; frame < 3; ++frame) {
    for (vec3& p : positions) p.z = -0.5f * static_cast<float>(frame);
    if (const auto updated = bvh->update(positions); !updated) {
      std::fprintf(stderr, "%s\n", updated.error().message().c_str());
      return 1;
    }
    const sinew::Ray ray{.origin = {0, 0, 5}, .direction = {0, 0, -1}};
    if (const auto hit = bvh->closest_hit(ray)) {
      std::printf("frame %d: the triangle is %.1f away\n", frame, static_cast<double>(hit->t));
    }
  }
  return 0;
}

// A whole scene: what a file or a study scene holds, at any time of its animation.
int trace_a_scene(const char* input) {
  const auto scene = sinew::load(input);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message().c_str());
    return 1;
  }
  auto world = sinew::prepare(*scene);
  if (!world) {
    std::fprintf(stderr, "%s\n", world.error().message().c_str());
    return 1;
  }
  for (const double time : {0.0, 0.25, 0.5}) {
    if (const auto moved = world->set_time(time); !moved) {
      std::fprintf(stderr, "%s\n", moved.error().message().c_str());
      return 1;
    }
    const sinew::Box box = world->box();
    const vec3 above = box.center() + vec3(0, box.extent().y, 0);
    const auto hit = world->closest_hit({.origin = above, .direction = {0, -1, 0}});
    if (hit) {
      std::printf("%.2f s: object %u, triangle %u, %.3f below\n", time, hit->object, hit->primitive,
                  static_cast<double>(hit->t));
    } else {
      std::printf("%.2f s: nothing below\n", time);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (const int failed = trace_a_mesh()) return failed;
  return trace_a_scene(argc > 1 ? argv[1] : "study:creature");
}
