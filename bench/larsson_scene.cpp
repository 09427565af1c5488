#include "bench/larsson_scene.h"

#include <algorithm>
#include <cmath>

#include "sinew/io/load.h"
#include "sinew/math/color.h"
#include "sinew/render/lights.h"

namespace sinew::bench {
namespace {

constexpr float kLeastMirror = 0.1f;      // of the reflectance at normal incidence
constexpr float kMirrorRoughness = 0.2f;  // at most

bool is_mirror(const Material& material) {
  const float grazing = (material.ior - 1.0f) / (material.ior + 1.0f);
  const float dielectric = material.specular * grazing * grazing * largest(material.specular_color);
  return material.roughness <= kMirrorRoughness &&
         std::max(material.metallic, dielectric) >= kLeastMirror;
}

}  // namespace

Result<TableScene> TableScene::make(const std::string& input) {
  TableScene out;
  SINEW_TRY(out.scene_, load(input));
  const Scene& scene = out.scene_;
  if (scene.clips.empty() || scene.cameras.empty() || scene.default_frames <= 0) {
    return fail({ErrorKind::usage, input, "", "it has no clip, no camera or no number of frames",
                 "give a study scene or an AFF animation"});
  }
  sample(scene, 0, scene.clips[0].start, out.pose_);
  if (out.lights().empty()) {
    return fail({ErrorKind::usage, input, "", "it has no point lights", "give a scene with some"});
  }
  for (uint32_t i = 0; i < scene.objects.size(); ++i) out.add_body(i);
  if (out.moving_triangles() == 0) {
    return fail(
        {ErrorKind::usage, input, "", "nothing in it deforms", "give a scene with meshes that do"});
  }
  return out;
}

void TableScene::add_body(uint32_t object) {
  const Mesh& mesh = scene_.meshes[scene_.objects[object].mesh];
  BodyInput body;
  body.triangles = mesh.triangles;
  body.moves = deforms(motion_of(mesh, scene_.objects[object].skin >= 0));
  std::vector<vec3> shape(mesh.positions.size());
  const Pose first = pose_.objects[object];
  for (uint32_t key = 0; key < std::max(mesh.keys, 1u); ++key) {
    if (mesh.keys > 0) {
      pose_.objects[object].key = key;
      pose_.objects[object].key_fraction = 0.0f;
    }
    world_positions(scene_, pose_, object, shape);
    body.key_shapes.push_back(shape);
  }
  pose_.objects[object] = first;
  positions_.push_back(body.key_shapes[0]);
  keys_.push_back(0.0f);
  bodies_.push_back(std::move(body));
}

void TableScene::set_frame(uint32_t frame) {
  const double time = scene_.clips[0].start + (frame - 1) / scene_.default_fps;
  sample(scene_, 0, time, pose_);
  for (uint32_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].moves) continue;
    world_positions(scene_, pose_, b, positions_[b]);
    keys_[b] = static_cast<float>(pose_.objects[b].key) + pose_.objects[b].key_fraction;
  }
}

std::vector<vec3> TableScene::lights() const {
  std::vector<ShadingLight> lights;
  gather_lights(scene_, pose_, camera(), lights);
  std::vector<vec3> out;
  for (const ShadingLight& light : lights) {
    if (light.type == LightType::point) out.push_back(light.position);
  }
  return out;
}

uint64_t TableScene::moving_triangles() const {
  uint64_t count = 0;
  for (const BodyInput& body : bodies_) count += body.moves ? body.triangles.size() : 0;
  return count;
}

uint64_t TableScene::largest_moving_body() const {
  uint64_t most = 0;
  for (const BodyInput& body : bodies_) {
    if (body.moves) most = std::max<uint64_t>(most, body.triangles.size());
  }
  return most;
}

bool TableScene::mirrors(uint32_t body, uint32_t triangle) const {
  const Mesh& mesh = scene_.meshes[scene_.objects[body].mesh];
  return is_mirror(scene_.materials[mesh.material_of(triangle)]);
}

vec3 TableScene::normal(uint32_t body, uint32_t triangle) const {
  const uvec3 t = bodies_[body].triangles[triangle];
  const std::vector<vec3>& p = positions_[body];
  const vec3 across = cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
  const float size = length(across);
  return size > 0.0f ? across / size : vec3(0.0f);
}

namespace {

// Rays that start at hits: how far before the surface, and to which lights.
struct Bounce {
  const TableScene& scene;
  std::vector<vec3> lights;
  float lift = 0.0f;

  void follow(std::span<const Ray> rays, std::span<const Hit> hits, std::vector<Ray>& shadow,
              std::vector<Ray>* reflection) const {
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit& hit = hits[i];
      if (!hit) continue;
      vec3 normal = scene.normal(hit.object, hit.primitive);
      if (dot(normal, rays[i].direction) > 0.0f) normal = -normal;
      const vec3 at = rays[i].origin + hit.t * rays[i].direction + lift * normal;
      for (const vec3& light : lights) {
        const vec3 to_light = light - at;
        if (dot(to_light, normal) <= 0.0f) continue;
        shadow.push_back({.origin = at, .direction = to_light, .t_max = 1.0f});
      }
      if (reflection == nullptr || !scene.mirrors(hit.object, hit.primitive)) continue;
      const vec3 d = rays[i].direction;
      reflection->push_back({.origin = at, .direction = d - 2.0f * dot(normal, d) * normal});
    }
  }
};

}  // namespace

void make_rays(const TableScene& scene, TableEngine& engine, uint32_t width, uint32_t height,
               uint32_t step, TableRays& out) {
  for (auto* rays : {&out.primary, &out.shadow, &out.reflection, &out.reflection_shadow}) {
    rays->clear();
  }
  const CameraRays camera_rays(scene.camera(), width, height);
  for (uint32_t y = 0; y < height; y += step) {
    for (uint32_t x = 0; x < width; x += step) {
      const float half = 0.5f * static_cast<float>(step);
      out.primary.push_back(
          camera_rays(static_cast<float>(x) + half, static_cast<float>(y) + half));
    }
  }
  Box box;
  for (const std::vector<vec3>& positions : scene.frame().positions) {
    for (const vec3& p : positions) box.extend(p);
  }
  const Bounce bounce{scene, scene.lights(), 1e-5f * length(box.extent())};
  std::vector<Hit> hits(out.primary.size());
  engine.closest_hits(out.primary, hits);
  bounce.follow(out.primary, hits, out.shadow, &out.reflection);
  hits.resize(out.reflection.size());
  engine.closest_hits(out.reflection, hits);
  bounce.follow(out.reflection, hits, out.reflection_shadow, nullptr);
}

}  // namespace sinew::bench
