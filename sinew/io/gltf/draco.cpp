// Based on: "KHR_draco_mesh_compression", glTF extension, 2018; the Draco library decodes. It takes
// memory for whatever counts the data claim, so its decoders are derived from: they ask here first,
// once the counts are known and before anything is made of them.
#include "sinew/io/gltf/draco.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace sinew::gltf {
namespace {

// Runs of equal symbols cost next to nothing, so a few bytes may honestly mean many triangles; but
// beyond this many, each byte of the data must account for no more than so many of them.
constexpr uint64_t kFreeFaces = uint64_t{1} << 20;
constexpr uint64_t kMostFacesPerByte = 256;
// What the decoder keeps, about: corner tables for the mesh and its attributes, and the faces.
constexpr uint64_t kBytesPerFace = 128;
constexpr uint16_t kOldestVersion = DRACO_BITSTREAM_VERSION(2, 2);  // the extension's

// What may stand in the way of decoding, apart from damage that Draco itself sees.
class Guard {
 public:
  Guard(const Json& primitive, uint64_t bytes, MemoryBudget& budget)
      : primitive_(primitive), bytes_(bytes), budget_(budget) {}

  bool allow_faces(uint64_t faces, uint64_t vertices) {
    const uint64_t most = kFreeFaces + kMostFacesPerByte * bytes_;
    if (faces > most || vertices > 3 * most) {
      return refuse(primitive_.error(
          fmt::format("its {} compressed bytes cannot hold {} triangles and {} vertices", bytes_,
                      faces, vertices),
          "check that the file is complete, or export it again"));
    }
    return take(faces + vertices / 3, kBytesPerFace);
  }
  bool take(uint64_t count, uint64_t size) {
    const Result<void> taken = budget_.take(primitive_, count, size);
    return taken || refuse(fail(taken.error()));
  }
  bool refuse(tl::unexpected<Error> error) {
    refusal_ = std::move(error.value());
    return false;
  }
  const std::optional<Error>& refusal() const { return refusal_; }
  const Json& primitive() const { return primitive_; }

 private:
  const Json& primitive_;
  uint64_t bytes_;  // compressed
  MemoryBudget& budget_;
  std::optional<Error> refusal_;
};

// `Base` is one of Draco's two mesh decoders.
template <class Base>
class GuardedDecoder : public Base {
 public:
  explicit GuardedDecoder(Guard& guard) : guard_(guard) {}

 protected:
  // Both begin with two counts.
  bool DecodeConnectivity() override {
    if (this->bitstream_version() < kOldestVersion) {
      return guard_.refuse(guard_.primitive().error("its Draco data are older than version 2.2",
                                                    "export the file again"));
    }
    constexpr bool kEdgebreaker = std::is_same_v<Base, draco::MeshEdgebreakerDecoder>;
    draco::DecoderBuffer ahead = *this->buffer();
    uint32_t first = 0, second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    const uint32_t faces = kEdgebreaker ? second : first;
    const uint32_t vertices = kEdgebreaker ? first : second;
    return guard_.allow_faces(faces, vertices) && Base::DecodeConnectivity();
  }

  // The attributes are declared, but not yet decoded: into integers, then into what they are.
  bool DecodeAllAttributes() override {
    uint64_t bytes = 0;  // a vertex
    for (int i = 0; i < this->point_cloud()->num_attributes(); ++i) {
      const auto components =
          static_cast<uint64_t>(this->point_cloud()->attribute(i)->num_components());
      bytes += components * (sizeof(int32_t) + sizeof(float)) + sizeof(uint32_t);
    }
    return guard_.take(this->point_cloud()->num_points(), bytes) && Base::DecodeAllAttributes();
  }

 private:
  Guard& guard_;
};

template <class Base>
draco::Status decode(draco::DecoderBuffer& buffer, Guard& guard, draco::Mesh& out) {
  GuardedDecoder<Base> decoder(guard);
  return decoder.Decode(draco::DecoderOptions(), &buffer, &out);
}

Result<void> decode_mesh(std::span<const uint8_t> bytes, Guard& guard, draco::Mesh& out) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::DecoderBuffer ahead = buffer;
  draco::DracoHeader header{};
  draco::Status status = draco::PointCloudDecoder::DecodeHeader(&ahead, &header);
  if (status.ok()) {
    if (header.encoder_type != draco::TRIANGULAR_MESH) {
      return guard.primitive().error("its Draco data are no mesh", "export the file again");
    }
    status = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
                 ? decode<draco::MeshEdgebreakerDecoder>(buffer, guard, out)
                 : decode<draco::MeshSequentialDecoder>(buffer, guard, out);
  }
  if (guard.refusal()) return fail(*guard.refusal());
  if (!status.ok()) {
    return guard.primitive().error(
        fmt::format("its Draco data are damaged ({})", status.error_msg_string()),
        "check that the file is complete, or export it again");
  }
  return {};
}

template <class T>
bool convert(const draco::PointAttribute& from, uint32_t count, DracoAttribute& to) {
  to.bytes.resize(size_t{count} * to.components * sizeof(T));
  T* out = reinterpret_cast<T*>(to.bytes.data());
  for (uint32_t i = 0; i < count; ++i, out += to.components) {
    const draco::AttributeValueIndex index = from.mapped_index(draco::PointIndex(i));
    if (index.value() >= from.size() ||
        !from.ConvertValue<T>(index, static_cast<int8_t>(to.components), out)) {
      return false;
    }
  }
  return true;
}

bool convert(const draco::PointAttribute& from, uint32_t count, DracoAttribute& to) {
  switch (to.type) {
    case ComponentType::i8:
      return convert<int8_t>(from, count, to);
    case ComponentType::u8:
      return convert<uint8_t>(from, count, to);
    case ComponentType::i16:
      return convert<int16_t>(from, count, to);
    case ComponentType::u16:
      return convert<uint16_t>(from, count, to);
    case ComponentType::u32:
      return convert<uint32_t>(from, count, to);
    case ComponentType::f32:
      break;
  }
  return convert<float>(from, count, to);
}

Result<void> read_attribute(const draco::Mesh& from, const Json& primitive, MemoryBudget& budget,
                            DracoAttribute& to) {
  const draco::PointAttribute* attribute = from.GetAttributeByUniqueId(to.unique_id);
  if (!attribute) {
    return primitive.error(
        fmt::format("its Draco data have no attribute {} ({})", to.unique_id, to.name));
  }
  SINEW_CHECKED(budget.take(primitive, uint64_t{from.num_points()} * to.components, sizeof(float)));
  // Draco reads stored bools as they lie there, and damaged ones are no bools.
  if (attribute->data_type() == draco::DT_BOOL ||
      uint32_t{attribute->num_components()} != to.components ||
      !convert(*attribute, from.num_points(), to)) {
    return primitive.error(
        fmt::format("its Draco data do not hold {} as its accessor says", to.name),
        "export the file again");
  }
  return {};
}

Result<void> read_indices(const draco::Mesh& from, const Json& primitive, DracoMesh& to) {
  to.vertex_count = from.num_points();
  to.indices.reserve(size_t{3} * from.num_faces());
  for (uint32_t i = 0; i < from.num_faces(); ++i) {
    const draco::Mesh::Face& face = from.face(draco::FaceIndex(i));
    for (const draco::PointIndex& corner : face) {
      if (corner.value() >= to.vertex_count) {
        return primitive.error(fmt::format("its triangle {} has the vertex {} of {}", i,
                                           corner.value(), to.vertex_count));
      }
      to.indices.push_back(corner.value());
    }
  }
  return {};
}

}  // namespace

Result<void> decode_draco(const Json& primitive, std::span<const uint8_t> bytes,
                          MemoryBudget& budget, DracoMesh& mesh) {
  Guard guard(primitive, bytes.size(), budget);
  draco::Mesh decoded;
  SINEW_CHECKED(decode_mesh(bytes, guard, decoded));
  if (decoded.num_faces() == 0 || decoded.num_points() == 0) {
    return primitive.error("its Draco data hold no triangles");
  }
  SINEW_CHECKED(read_indices(decoded, primitive, mesh));
  for (DracoAttribute& attribute : mesh.attributes) {
    SINEW_CHECKED(read_attribute(decoded, primitive, budget, attribute));
  }
  return {};
}

}  // namespace sinew::gltf
