#include "sinew/scene/procedural/stage.h"

#include <cmath>
#include <utility>

namespace sinew {

quat facing(vec3 direction, vec3 up) {
  const vec3 back = -normalize(direction);
  vec3 right = cross(up, back);
  if (dot(right, right) < 1e-12f) right = cross(vec3(0.0f, 0.0f, 1.0f), back);
  right = normalize(right);
  return normalize(glm::quat_cast(mat3(right, cross(back, right), back)));
}

uint32_t add_node(Scene& scene, std::string name, vec3 translation, int32_t parent) {
  Node node;
  node.name = std::move(name);
  node.translation = translation;
  node.parent = parent;
  scene.nodes.push_back(std::move(node));
  return static_cast<uint32_t>(scene.nodes.size() - 1);
}

uint32_t add_mesh_node(Scene& scene, Mesh mesh, int32_t parent) {
  const uint32_t node = add_node(scene, mesh.name, vec3(0.0f), parent);
  scene.nodes[node].mesh = static_cast<int32_t>(scene.meshes.size());
  scene.meshes.push_back(std::move(mesh));
  return node;
}

uint32_t add_sun(Scene& scene, std::string name, const SunConfig& config) {
  const uint32_t node = add_node(scene, name);
  scene.nodes[node].rotation = facing(-config.from);
  scene.nodes[node].light = static_cast<int32_t>(scene.lights.size());
  Light light;
  light.name = std::move(name);
  light.type = LightType::directional;
  light.color = config.color;
  light.intensity = config.lux;
  scene.lights.push_back(std::move(light));
  return node;
}

uint32_t add_lamp(Scene& scene, std::string name, vec3 position, vec3 color, float candela) {
  const uint32_t node = add_node(scene, name, position);
  scene.nodes[node].light = static_cast<int32_t>(scene.lights.size());
  Light light;
  light.name = std::move(name);
  light.type = LightType::point;
  light.color = color;
  light.intensity = candela;
  scene.lights.push_back(std::move(light));
  return node;
}

uint32_t add_camera(Scene& scene, std::string name, const CameraConfig& config, int32_t parent) {
  const uint32_t node = add_node(scene, name, config.eye, parent);
  scene.nodes[node].rotation = facing(config.target - config.eye);
  scene.nodes[node].camera = static_cast<int32_t>(scene.cameras.size());
  Camera camera;
  camera.name = std::move(name);
  camera.yfov = config.yfov;
  scene.cameras.push_back(std::move(camera));
  return node;
}

Material colored_material(std::string name, vec3 color, float roughness, float metallic) {
  Material material;
  material.name = std::move(name);
  material.base_color = vec4(color, 1.0f);
  material.roughness = roughness;
  material.metallic = metallic;
  return material;
}

Channel value_channel(uint32_t node, ChannelPath path, uint32_t width, std::vector<float> times,
                      std::vector<float> values) {
  Channel channel;
  channel.node = node;
  channel.path = path;
  channel.width = width;
  channel.times = std::move(times);
  channel.values = std::move(values);
  return channel;
}

Channel translation_channel(uint32_t node, std::vector<float> times,
                            const std::vector<vec3>& keys) {
  std::vector<float> values;
  values.reserve(3 * keys.size());
  for (const vec3 k : keys) values.insert(values.end(), {k.x, k.y, k.z});
  return value_channel(node, ChannelPath::translation, 3, std::move(times), std::move(values));
}

Channel rotation_channel(uint32_t node, std::vector<float> times, const std::vector<quat>& keys) {
  std::vector<float> values;
  values.reserve(4 * keys.size());
  for (const quat& k : keys) values.insert(values.end(), {k.x, k.y, k.z, k.w});
  return value_channel(node, ChannelPath::rotation, 4, std::move(times), std::move(values));
}

std::vector<float> even_times(uint32_t count, double duration) {
  std::vector<float> times(count + 1);
  for (uint32_t i = 0; i <= count; ++i) times[i] = static_cast<float>(duration * i / count);
  return times;
}

}  // namespace sinew
