#include "gltf_compressor.h"

#include <draco/compression/expert_encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <map>
#include <numeric>

namespace sinew {
namespace {

using nlohmann::json;

size_t component_size(int type) {
  return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
}

size_t component_count(const json& accessor) {
  const std::string type = accessor["type"];
  return type == "MAT4" ? 16 : type == "SCALAR" ? 1 : static_cast<size_t>(type.back() - '0');
}

size_t element_size(const json& accessor) {
  return component_size(accessor["componentType"]) * component_count(accessor);
}

// Element i of an accessor.
const char* element(const GltfBuilder& asset, const json& accessor, size_t i) {
  const json& view = asset.json["bufferViews"][accessor["bufferView"].get<size_t>()];
  const size_t stride = view.value("byteStride", element_size(accessor));
  return asset.bytes.data() + view.value("byteOffset", size_t{0}) +
         accessor.value("byteOffset", size_t{0}) + i * stride;
}

uint32_t index_at(const GltfBuilder& asset, const json& accessor, size_t i) {
  uint32_t index = 0;
  std::memcpy(&index, element(asset, accessor, i), element_size(accessor));
  return index;
}

draco::DataType draco_type(int component_type) {
  static const std::map<int, draco::DataType> kTypes = {
      {5120, draco::DT_INT8},   {5121, draco::DT_UINT8},  {5122, draco::DT_INT16},
      {5123, draco::DT_UINT16}, {5125, draco::DT_UINT32}, {5126, draco::DT_FLOAT32}};
  return kTypes.at(component_type);
}

draco::GeometryAttribute::Type draco_meaning(const std::string& name) {
  if (name == "POSITION") return draco::GeometryAttribute::POSITION;
  if (name == "NORMAL") return draco::GeometryAttribute::NORMAL;
  if (name.starts_with("TEXCOORD")) return draco::GeometryAttribute::TEX_COORD;
  if (name.starts_with("COLOR")) return draco::GeometryAttribute::COLOR;
  return draco::GeometryAttribute::GENERIC;
}

// Returns the attribute's id in the mesh.
int add_attribute(const GltfBuilder& asset, const std::string& name, const json& accessor,
                  draco::Mesh& mesh) {
  const size_t count = accessor["count"];
  draco::GeometryAttribute attribute;
  attribute.Init(draco_meaning(name), nullptr, static_cast<int8_t>(component_count(accessor)),
                 draco_type(accessor["componentType"]), accessor.value("normalized", false),
                 static_cast<int64_t>(element_size(accessor)), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<uint32_t>(count));
  for (uint32_t i = 0; i < count; ++i) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          element(asset, accessor, i));
  }
  return id;
}

void set_faces(const GltfBuilder& asset, const json& primitive, size_t vertices,
               draco::Mesh& mesh) {
  std::vector<uint32_t> indices(vertices);
  std::iota(indices.begin(), indices.end(), 0u);
  if (primitive.contains("indices")) {
    const json& accessor = asset.json["accessors"][primitive["indices"].get<size_t>()];
    indices.resize(accessor["count"]);
    for (size_t i = 0; i < indices.size(); ++i) indices[i] = index_at(asset, accessor, i);
  }
  mesh.SetNumFaces(indices.size() / 3);
  for (uint32_t i = 0; i < indices.size() / 3; ++i) {
    mesh.SetFace(draco::FaceIndex(i),
                 {draco::PointIndex(indices[3 * i]), draco::PointIndex(indices[3 * i + 1]),
                  draco::PointIndex(indices[3 * i + 2])});
  }
}

void compress_primitive(GltfBuilder& asset, json& primitive, const DracoSettings& settings) {
  draco::Mesh mesh;
  json ids = json::object();
  int position = 0;
  std::vector<size_t> accessors;
  for (const auto& [name, index] : primitive["attributes"].items()) {
    const json& accessor = asset.json["accessors"][index.get<size_t>()];
    if (accessors.empty()) {
      set_faces(asset, primitive, accessor["count"], mesh);
      mesh.set_num_points(accessor["count"]);
    }
    const int id = add_attribute(asset, name, accessor, mesh);
    ids[name] = mesh.attribute(id)->unique_id();
    if (name == "POSITION") position = id;
    accessors.push_back(index);
  }
  if (settings.edgebreaker) {
    mesh.DeduplicateAttributeValues();
    mesh.DeduplicatePointIds();
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(settings.edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                 : draco::MESH_SEQUENTIAL_ENCODING);
  if (settings.position_bits > 0) {
    encoder.SetAttributeQuantization(position, settings.position_bits);
  }
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  const std::vector<char> bytes(buffer.data(), buffer.data() + buffer.size());
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", asset.view(bytes)},
                                                           {"attributes", ids}};
  if (primitive.contains("indices")) accessors.push_back(primitive["indices"]);
  for (const size_t index : accessors) asset.json["accessors"][index]["compressed"] = true;
}

std::string encode(const std::string& data, size_t count, size_t stride, const std::string& mode) {
  std::string out;
  const auto bytes = [&] { return reinterpret_cast<unsigned char*>(out.data()); };
  if (mode == "ATTRIBUTES") {
    out.resize(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(bytes(), out.size(), data.data(), count, stride));
    return out;
  }
  std::vector<uint32_t> indices(count, 0);
  for (size_t i = 0; i < count; ++i) std::memcpy(&indices[i], data.data() + i * stride, stride);
  const size_t vertices = *std::max_element(indices.begin(), indices.end()) + size_t{1};
  if (mode == "TRIANGLES") {
    out.resize(meshopt_encodeIndexBufferBound(count, vertices));
    out.resize(meshopt_encodeIndexBuffer(bytes(), out.size(), indices.data(), count));
  } else {
    out.resize(meshopt_encodeIndexSequenceBound(count, vertices));
    out.resize(meshopt_encodeIndexSequence(bytes(), out.size(), indices.data(), count));
  }
  return out;
}

}  // namespace

GltfBuilder open_glb(const std::string& path) {
  const std::string file = slurp(path);
  uint32_t json_size = 0;
  std::memcpy(&json_size, file.data() + 12, 4);
  GltfBuilder asset;
  asset.json = json::parse(file.substr(20, json_size));
  asset.bytes = file.substr(20 + json_size + 8);
  return asset;
}

void compress_with_draco(GltfBuilder& asset, const DracoSettings& settings) {
  for (json& mesh : asset.json["meshes"]) {
    for (json& primitive : mesh["primitives"]) compress_primitive(asset, primitive, settings);
  }
  for (json& accessor : asset.json["accessors"]) {  // primitives may share some
    if (accessor.erase("compressed") == 0) continue;
    accessor.erase("bufferView");
    accessor.erase("byteOffset");
  }
  asset.json["extensionsRequired"].push_back("KHR_draco_mesh_compression");
}

int add_meshopt_view(GltfBuilder& asset, const std::string& data, size_t count, size_t stride,
                     const std::string& mode, const std::string& filter) {
  const std::string encoded = encode(data, count, stride, mode);
  const int compressed = asset.view(std::vector<char>(encoded.begin(), encoded.end()));
  json extension = asset.json["bufferViews"][static_cast<size_t>(compressed)];
  asset.json["bufferViews"].erase(static_cast<size_t>(compressed));
  extension["byteStride"] = stride;
  extension["count"] = count;
  extension["mode"] = mode;
  extension["filter"] = filter;
  asset.json["buffers"] = {json::object(), {{"byteLength", count * stride}}};
  json view = {{"buffer", 1}, {"byteLength", count * stride}};
  view["extensions"]["EXT_meshopt_compression"] = extension;
  return asset.add("bufferViews", view);
}

void compress_with_meshopt(GltfBuilder& asset, const MeshoptSettings& settings) {
  std::map<size_t, json> accessor_of_view;
  for (const json& accessor : asset.json["accessors"]) {
    if (accessor.contains("bufferView")) accessor_of_view[accessor["bufferView"]] = accessor;
  }
  std::map<size_t, bool> holds_indices;
  for (const json& mesh : asset.json["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      if (!primitive.contains("indices")) continue;
      const json& accessor = asset.json["accessors"][primitive["indices"].get<size_t>()];
      holds_indices[accessor["bufferView"]] = true;
    }
  }
  for (const auto& [index, accessor] : accessor_of_view) {
    const json view = asset.json["bufferViews"][index];
    const bool indices = holds_indices[index];
    const size_t stride = view.value("byteStride", element_size(accessor));
    const size_t size = view["byteLength"];
    if (!indices && (stride % 4 != 0 || stride > 256)) continue;
    const std::string data = asset.bytes.substr(view.value("byteOffset", size_t{0}), size);
    const int added = add_meshopt_view(asset, data, size / stride, stride,
                                       indices ? settings.index_mode : "ATTRIBUTES");
    asset.json["bufferViews"][index] = asset.json["bufferViews"][static_cast<size_t>(added)];
    asset.json["bufferViews"].erase(static_cast<size_t>(added));
  }
  asset.json["buffers"][1] = {{"byteLength", asset.bytes.size()}};
  asset.json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  asset.json["extensionsRequired"].push_back("EXT_meshopt_compression");
}

}  // namespace sinew
