// A click on an animated character: which joints move the point below it? The frame is updated
// lazily, so that all but the few triangles that the ray comes near stay where they were.
// Run it as: 04_pick_a_character [walk.glb [seconds]]
#include <cstdio>
#include <cstdlib>
#include <string>

#include "sinew/sinew.h"

namespace {

using sinew::vec3;

int report(const sinew::Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return 1;
}

std::string name_of_joint(const sinew::Scene& scene, uint32_t object, uint32_t joint) {
  const sinew::Skin& skin = scene.skins[static_cast<size_t>(scene.objects[object].skin)];
  return scene.nodes[skin.joints[joint]].name;
}

void print_pick(const sinew::Scene& scene, const sinew::Pick& pick) {
  std::printf("hit object %u, triangle %u, at (%.3f, %.3f, %.3f)\n", pick.hit.object,
              pick.hit.primitive, pick.point.x, pick.point.y, pick.point.z);
  for (const sinew::JointWeight& j : pick.joints) {
    std::printf("  %3.0f%% moved by %s\n", 100.0f * j.weight,
                name_of_joint(scene, pick.hit.object, j.joint).c_str());
  }
}

int pick(const std::string& input, double seconds) {
  const auto scene = sinew::load(input);
  if (!scene) return report(scene.error());
  auto world = sinew::prepare(*scene, {.update = sinew::UpdateMode::lazy});
  if (!world) return report(world.error());
  if (const auto moved = world->set_time(seconds); !moved) return report(moved.error());

  // From beside the scene through its middle.
  const sinew::Box box = world->box();
  sinew::Ray ray;
  ray.origin = box.center() + vec3(2.0f * box.extent().x, 0.0f, 0.0f);
  ray.direction = box.center() - ray.origin;
  if (const auto found = world->pick(ray)) {
    print_pick(*scene, *found);
  } else {
    std::printf("hit nothing\n");
  }
  if (const auto nearest = world->nearest_point(ray.origin)) {
    std::printf("nearest to the eye: object %u, %.3f away\n", nearest->object, nearest->distance);
  }
  const sinew::UpdateStats stats = world->stats();
  std::printf("moved %llu of %llu parts\n", static_cast<unsigned long long>(stats.treelets_made),
              static_cast<unsigned long long>(stats.treelets));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return pick(argc > 1 ? argv[1] : "study:creature", argc > 2 ? std::atof(argv[2]) : 0.4);
}
