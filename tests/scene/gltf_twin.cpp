#include "scene/gltf_twin.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <iterator>

namespace sinew::test {
namespace {

using glm::dmat4;
using glm::dquat;
using glm::dvec3;
using glm::dvec4;

constexpr size_t kNoParent = static_cast<size_t>(-1);

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
T number_at(const std::string& bytes, size_t at) {
  T out;
  std::memcpy(&out, bytes.data() + at, sizeof(T));
  return out;
}

std::string decode_base64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const size_t value = alphabet.find(c);
    if (value == std::string::npos) break;
    bits = bits << 6 | static_cast<uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    out.push_back(static_cast<char>(bits >> count & 0xff));
  }
  return out;
}

double component(const std::string& bytes, size_t at, int type, bool normalized) {
  switch (type) {
    case 5120:
      return number_at<int8_t>(bytes, at) / (normalized ? 127.0 : 1.0);
    case 5121:
      return number_at<uint8_t>(bytes, at) / (normalized ? 255.0 : 1.0);
    case 5122:
      return number_at<int16_t>(bytes, at) / (normalized ? 32767.0 : 1.0);
    case 5123:
      return number_at<uint16_t>(bytes, at) / (normalized ? 65535.0 : 1.0);
    case 5125:
      return number_at<uint32_t>(bytes, at);
    default:
      return number_at<float>(bytes, at);
  }
}

const std::map<int, size_t> kComponentBytes = {{5120, 1}, {5121, 1}, {5122, 2},
                                               {5123, 2}, {5125, 4}, {5126, 4}};
const std::map<std::string, size_t> kComponents = {
    {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};

// By angles, as appendix C of the specification writes it.
std::vector<double> slerp(const double* from, const double* to, double u) {
  dvec4 a = glm::normalize(dvec4(from[0], from[1], from[2], from[3]));
  const dvec4 b = glm::normalize(dvec4(to[0], to[1], to[2], to[3]));
  double d = glm::dot(a, b);
  const double sign = d < 0.0 ? -1.0 : 1.0;
  d = std::min(std::abs(d), 1.0);
  const double angle = std::acos(d);
  dvec4 q = angle < 1e-5 ? a * (1.0 - u) + sign * u * b
                         : (std::sin(angle * (1.0 - u)) * a + sign * std::sin(angle * u) * b) /
                               std::sin(angle);
  q = glm::normalize(q);
  return {q.x, q.y, q.z, q.w};
}

dvec3 vec3_at(const std::vector<double>& values, size_t index) {
  return {values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

dmat4 mat4_at(const std::vector<double>& values, size_t index) {
  dmat4 m;
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = values[16 * index + i];
  return m;
}

}  // namespace

// What the channels say, by (node, path), and the nodes' matrices.
struct GltfTwin::Frame {
  std::map<std::pair<size_t, std::string>, Numbers> animated;
  std::vector<dmat4> world;
};

GltfTwin::GltfTwin(const std::string& path) {
  read_file(path);
  parent_.assign(json_["nodes"].size(), kNoParent);
  for (const size_t root : json_["scenes"][json_.value("scene", 0)]["nodes"]) {
    visit(root, kNoParent);
  }
}

void GltfTwin::read_file(const std::string& path) {
  const std::string file = bytes_of(path);
  const bool binary = file.substr(0, 4) == "glTF";
  const size_t json_size = binary ? number_at<uint32_t>(file, 12) : file.size();
  json_ = Json::parse(file.substr(binary ? 20 : 0, json_size));
  for (const Json& buffer : json_["buffers"]) {
    if (!buffer.contains("uri")) {
      buffers_.push_back(file.substr(20 + json_size + 8));
      continue;
    }
    const std::string uri = buffer["uri"];
    buffers_.push_back(uri.starts_with("data:")
                           ? decode_base64(uri.substr(uri.find(',') + 1))
                           : bytes_of(std::filesystem::path(path).parent_path() / uri));
  }
}

void GltfTwin::visit(size_t node, size_t parent) {
  parent_[node] = parent;
  order_.push_back(node);
  if (json_["nodes"][node].contains("mesh")) objects_.push_back(node);
  for (const size_t child : json_["nodes"][node].value("children", Json::array())) {
    visit(child, node);
  }
}

int GltfTwin::animation_count() const {
  return static_cast<int>(json_.value("animations", Json::array()).size());
}

std::string GltfTwin::object_name(size_t object) const {
  return json_["nodes"][objects_[object]].value("name", "");
}

double GltfTwin::animation_end(int animation) const {
  double end = 0.0;
  for (const Json& sampler : json_["animations"][animation]["samplers"]) {
    end = std::max(end, accessor(sampler["input"]).back());
  }
  return end;
}

const GltfTwin::Numbers& GltfTwin::accessor(size_t index) const {
  const auto found = decoded_.find(index);
  if (found != decoded_.end()) return found->second;
  return decoded_[index] = decode(json_["accessors"][index]);
}

GltfTwin::Numbers GltfTwin::decode(const Json& accessor) const {
  const Json& view = json_["bufferViews"][accessor["bufferView"].get<size_t>()];
  const int type = accessor["componentType"];
  const size_t components = kComponents.at(accessor["type"]), bytes = kComponentBytes.at(type);
  const size_t stride = view.value("byteStride", components * bytes);
  const size_t begin =
      view.value("byteOffset", size_t{0}) + accessor.value("byteOffset", size_t{0});
  const std::string& buffer = buffers_[view["buffer"].get<size_t>()];
  Numbers out;
  for (size_t i = 0; i < accessor["count"]; ++i) {
    for (size_t c = 0; c < components; ++c) {
      out.push_back(component(buffer, begin + i * stride + c * bytes, type,
                              accessor.value("normalized", false)));
    }
  }
  return out;
}

GltfTwin::Numbers GltfTwin::sample(const Json& sampler, double time, bool rotation) const {
  const Numbers& times = accessor(sampler["input"]);
  const Numbers& values = accessor(sampler["output"]);
  const std::string how = sampler.value("interpolation", "LINEAR");
  const size_t parts = how == "CUBICSPLINE" ? 3 : 1;
  const size_t width = values.size() / times.size() / parts;
  const auto part = [&](size_t key, size_t which) {
    return &values[(key * parts + which) * width];
  };
  const size_t middle = parts / 2;  // where a key's own value stands

  size_t key = 0;
  while (key + 1 < times.size() && times[key + 1] <= time) ++key;
  const double* here = part(key, middle);
  Numbers out(here, here + width);
  if (how != "STEP" && key + 1 < times.size() && time > times[key]) {
    const double span = times[key + 1] - times[key], u = (time - times[key]) / span;
    const double* next = part(key + 1, middle);
    if (how == "LINEAR" && rotation) return slerp(here, next, u);
    for (size_t i = 0; i < width; ++i) {
      out[i] = (1.0 - u) * here[i] + u * next[i];
      if (how == "LINEAR") continue;
      const double leaving = span * part(key, 2)[i], entering = span * part(key + 1, 0)[i];
      // Horner form of appendix C's polynomial.
      const double d = next[i] - here[i];
      out[i] = here[i] + u * (leaving + u * ((3.0 * d - 2.0 * leaving - entering) +
                                             u * (leaving + entering - 2.0 * d)));
    }
  }
  if (!rotation) return out;
  const double length = std::hypot(std::hypot(out[0], out[1]), std::hypot(out[2], out[3]));
  for (double& x : out) x /= length;
  return out;
}

GltfTwin::Frame GltfTwin::frame(int animation, double time) const {
  Frame frame;
  if (animation != kRest) {
    const Json& clip = json_["animations"][animation];
    for (const Json& channel : clip["channels"]) {
      const std::string path = channel["target"]["path"];
      frame.animated[{channel["target"]["node"], path}] =
          sample(clip["samplers"][channel["sampler"].get<size_t>()], time, path == "rotation");
    }
  }
  frame.world.resize(parent_.size(), dmat4(1.0));
  for (const size_t node : order_) {
    const dmat4 to_parent = local(node, frame);
    frame.world[node] =
        parent_[node] == kNoParent ? to_parent : frame.world[parent_[node]] * to_parent;
  }
  return frame;
}

dmat4 GltfTwin::local(size_t node, const Frame& frame) const {
  const Json& json = json_["nodes"][node];
  if (json.contains("matrix")) return mat4_at(json["matrix"].get<Numbers>(), 0);
  const auto value = [&](const char* path, Numbers fallback) {
    const auto found = frame.animated.find({node, path});
    return found != frame.animated.end() ? found->second : json.value(path, fallback);
  };
  const Numbers t = value("translation", {0, 0, 0});
  const Numbers r = value("rotation", {0, 0, 0, 1});
  const Numbers s = value("scale", {1, 1, 1});
  dmat4 m = glm::mat4_cast(glm::normalize(dquat(r[3], r[0], r[1], r[2])));
  for (int axis = 0; axis < 3; ++axis) m[axis] *= s[axis];
  m[3] = dvec4(vec3_at(t, 0), 1.0);
  return m;
}

std::vector<dvec3> GltfTwin::primitive_points(size_t node, const Json& primitive,
                                              const Frame& frame) const {
  const Json& json = json_["nodes"][node];
  const Json& attributes = primitive["attributes"];
  const Numbers& rest = accessor(attributes["POSITION"]);
  std::vector<dvec3> points;
  for (size_t v = 0; v < rest.size() / 3; ++v) points.push_back(vec3_at(rest, v));

  const Json targets = primitive.value("targets", Json::array());
  Numbers weights = json_["meshes"][json["mesh"].get<size_t>()].value("weights", Numbers());
  weights = json.value("weights", weights);
  const auto animated = frame.animated.find({node, "weights"});
  if (animated != frame.animated.end()) weights = animated->second;
  weights.resize(targets.size(), 0.0);
  for (size_t t = 0; t < targets.size(); ++t) {
    if (!targets[t].contains("POSITION")) continue;
    const Numbers& deltas = accessor(targets[t]["POSITION"]);
    for (size_t v = 0; v < points.size(); ++v) points[v] += weights[t] * vec3_at(deltas, v);
  }

  if (!json.contains("skin") || !attributes.contains("JOINTS_0")) {
    for (dvec3& p : points) p = dvec3(frame.world[node] * dvec4(p, 1.0));
    return points;
  }
  const Json& skin = json_["skins"][json["skin"].get<size_t>()];
  const Numbers& inverse_bind = accessor(skin["inverseBindMatrices"]);
  for (size_t v = 0; v < points.size(); ++v) {
    dvec3 sum(0.0);
    double total = 0.0;
    for (int set = 0; attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
      const Numbers& joints = accessor(attributes["JOINTS_" + std::to_string(set)]);
      const Numbers& of_set = accessor(attributes["WEIGHTS_" + std::to_string(set)]);
      for (size_t k = 4 * v; k < 4 * v + 4; ++k) {
        const size_t joint = static_cast<size_t>(joints[k]);
        const dmat4& world = frame.world[skin["joints"][joint].get<size_t>()];
        sum += of_set[k] * dvec3(world * (mat4_at(inverse_bind, joint) * dvec4(points[v], 1.0)));
        total += of_set[k];
      }
    }
    points[v] = sum / total;
  }
  return points;
}

std::vector<std::vector<dvec3>> GltfTwin::corners(int animation, double time) const {
  const Frame at_time = frame(animation, time);
  std::vector<std::vector<dvec3>> out;
  for (const size_t node : objects_) {
    std::vector<dvec3>& corners = out.emplace_back();
    const size_t mesh = json_["nodes"][node]["mesh"];
    for (const Json& primitive : json_["meshes"][mesh]["primitives"]) {
      const std::vector<dvec3> points = primitive_points(node, primitive, at_time);
      if (!primitive.contains("indices")) {
        corners.insert(corners.end(), points.begin(), points.end());
        continue;
      }
      for (const double index : accessor(primitive["indices"])) {
        corners.push_back(points[static_cast<size_t>(index)]);
      }
    }
  }
  return out;
}

}  // namespace sinew::test
