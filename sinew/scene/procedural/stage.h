// What surrounds the body of a study scene: nodes, lights, cameras and baked animation channels.
#pragma once

#include <string>
#include <vector>

#include "sinew/scene/scene.h"

namespace sinew {

// The rotation that turns -Z to `direction` with +Y as near to `up` as can be.
quat facing(vec3 direction, vec3 up = vec3(0.0f, 1.0f, 0.0f));

uint32_t add_node(Scene& scene, std::string name, vec3 translation = vec3(0.0f),
                  int32_t parent = -1);
uint32_t add_mesh_node(Scene& scene, Mesh mesh, int32_t parent = -1);

struct SunConfig {
  vec3 from{1.0f};  // direction towards the light
  vec3 color{1.0f};
  float lux = 3.0f;
};
uint32_t add_sun(Scene& scene, std::string name, const SunConfig& config);
uint32_t add_lamp(Scene& scene, std::string name, vec3 position, vec3 color, float candela);

struct CameraConfig {
  vec3 eye{0.0f, 1.0f, 5.0f};
  vec3 target{0.0f};
  float yfov = 0.6f;  // radians
};
uint32_t add_camera(Scene& scene, std::string name, const CameraConfig& config,
                    int32_t parent = -1);

Material colored_material(std::string name, vec3 color, float roughness, float metallic = 0.0f);

// Linearly interpolated channels with keys at `times`.
Channel translation_channel(uint32_t node, std::vector<float> times, const std::vector<vec3>& keys);
Channel rotation_channel(uint32_t node, std::vector<float> times, const std::vector<quat>& keys);
Channel value_channel(uint32_t node, ChannelPath path, uint32_t width, std::vector<float> times,
                      std::vector<float> values);

// count + 1 equally spaced times from 0 to `duration` seconds.
std::vector<float> even_times(uint32_t count, double duration);

}  // namespace sinew
