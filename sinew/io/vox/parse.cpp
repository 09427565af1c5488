#include "sinew/io/vox/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "sinew/io/text.h"
#include "sinew/io/vox/vox.h"

namespace sinew::vox {
namespace {

constexpr int32_t kHighestFrame = 1'000'000;
constexpr int32_t kFarthest = 1 << 20;  // voxels from the origin

// Takes values off the front of a chunk. What is missing reads as zero and clears ok().
class Bytes {
 public:
  explicit Bytes(std::span<const uint8_t> bytes) : left_(bytes) {}

  int32_t number() {
    int32_t value = 0;
    if (const auto bytes = take(4); !bytes.empty()) std::memcpy(&value, bytes.data(), 4);
    return value;
  }
  // Numbers that count what follows: not negative.
  size_t count() {
    const int32_t value = number();
    if (value < 0) ok_ = false;
    return ok_ ? static_cast<size_t>(value) : 0;
  }
  std::string_view text() {
    const auto bytes = take(count());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::span<const uint8_t> take(size_t size) {
    if (size > left_.size()) ok_ = false;
    if (!ok_) return {};
    const auto result = left_.first(size);
    left_ = left_.subspan(size);
    return result;
  }
  bool ok() const { return ok_; }
  bool empty() const { return left_.empty(); }

 private:
  std::span<const uint8_t> left_;
  bool ok_ = true;
};

using Dictionary = std::map<std::string_view, std::string_view>;

Dictionary take_dictionary(Bytes& bytes) {
  Dictionary result;
  for (size_t left = bytes.count(); left > 0 && bytes.ok(); --left) {
    const std::string_view key = bytes.text();
    result[key] = bytes.text();
  }
  return result;
}

std::string_view get(const Dictionary& dictionary, std::string_view key) {
  const auto found = dictionary.find(key);
  return found == dictionary.end() ? std::string_view() : found->second;
}

// A number of the dictionary, if it has one that is finite.
bool get_number(const Dictionary& dictionary, std::string_view key, float& out) {
  double value = 0.0;
  const std::string_view text = get(dictionary, key);
  if (text.empty() || take_number(text, value) != text.size()) return false;
  if (!std::isfinite(static_cast<float>(value))) return false;
  out = static_cast<float>(value);
  return true;
}

// "1 -2 3": integers within +-limit.
template <size_t N>
bool get_integers(std::string_view text, int32_t limit, std::array<int32_t, N>& out) {
  for (int32_t& number : out) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    double value = 0.0;
    const size_t length = take_number(text, value);
    if (length == 0 || !(std::abs(value) <= limit) || value != std::floor(value)) return false;
    number = static_cast<int32_t>(value);
    text.remove_prefix(length);
  }
  return text.find_first_not_of(' ') == std::string_view::npos;
}

class Parser {
 public:
  explicit Parser(const std::string& path) : path_(path) { file_.palette = default_palette(); }

  Result<VoxFile> parse(std::span<const uint8_t> bytes);

 private:
  Result<void> read_chunk(std::string_view id, Bytes content);
  Result<void> read_size(Bytes& content);
  Result<void> read_voxels(Bytes& content);
  Result<void> read_palette(Bytes& content);
  Result<void> read_material(Bytes& content);
  Result<void> read_layer(Bytes& content);
  Result<void> read_transform(Bytes& content);
  Result<void> read_group(Bytes& content);
  Result<void> read_shape(Bytes& content);
  Result<VoxNode*> add_node(int32_t id, NodeKind kind);
  Result<int32_t> frame_of(const Dictionary& attributes);
  Result<void> check_models() const;

  tl::unexpected<Error> error(std::string problem) const {
    return fail({ErrorKind::bad_input, path_, element_, std::move(problem), "export it again"});
  }

  const std::string& path_;
  std::string element_;  // the chunk that is read
  VoxFile file_;
  bool has_size_ = false;  // the last model waits for its voxels
};

Result<VoxFile> Parser::parse(std::span<const uint8_t> bytes) {
  Bytes file(bytes);
  const auto magic = file.take(4);
  if (magic.empty() || std::memcmp(magic.data(), "VOX ", 4) != 0) {
    return error("is no .vox file of MagicaVoxel");
  }
  file_.version = file.number();
  const auto main = file.take(4);
  const size_t content = file.count(), children = file.count();
  file.take(content);
  Bytes chunks(file.take(children));
  if (!file.ok() || std::memcmp(main.data(), "MAIN", 4) != 0) return error("ends too soon");
  if (file_.version != 150 && file_.version != 200) {
    return error(fmt::format("is of version {}; 150 and 200 are known", file_.version));
  }
  for (size_t i = 0; !chunks.empty(); ++i) {
    const auto id = chunks.take(4);
    const size_t size = chunks.count(), below = chunks.count();
    const Bytes own(chunks.take(size));
    chunks.take(below);
    if (!chunks.ok()) return error(fmt::format("chunk {} reaches past the end", i));
    const std::string_view name(reinterpret_cast<const char*>(id.data()), 4);
    element_ = fmt::format("chunk {} ({})", i, printable(name));
    SINEW_CHECKED(read_chunk(name, own));
  }
  element_.clear();
  SINEW_CHECKED(check_models());
  return std::move(file_);
}

Result<void> Parser::read_chunk(std::string_view id, Bytes content) {
  if (id == "SIZE") return read_size(content);
  if (id == "XYZI") return read_voxels(content);
  if (id == "RGBA") return read_palette(content);
  if (id == "MATL") return read_material(content);
  if (id == "LAYR") return read_layer(content);
  if (id == "nTRN") return read_transform(content);
  if (id == "nGRP") return read_group(content);
  if (id == "nSHP") return read_shape(content);
  return {};
}

Result<void> Parser::read_size(Bytes& content) {
  Model model;
  for (int axis = 0; axis < 3; ++axis) {
    const size_t side = content.count();
    if (side < 1 || side > kVoxModel) {
      return error(fmt::format("a model is 1 to {} voxels long", kVoxModel));
    }
    model.size[axis] = static_cast<uint32_t>(side);
  }
  if (!content.ok()) return error("ends too soon");
  if (has_size_) return error("the model before it has no voxels");
  file_.models.push_back(std::move(model));
  has_size_ = true;
  return {};
}

Result<void> Parser::read_voxels(Bytes& content) {
  if (!has_size_) return error("has no size before it");
  has_size_ = false;
  Model& model = file_.models.back();
  const size_t count = content.count();
  const auto bytes = content.take(sizeof(Voxel) * count);
  if (!content.ok()) return error("ends too soon");
  model.voxels.resize(count);
  if (count > 0) std::memcpy(model.voxels.data(), bytes.data(), bytes.size());
  for (const Voxel& v : model.voxels) {
    if (v.x >= model.size.x || v.y >= model.size.y || v.z >= model.size.z) {
      return error(fmt::format("voxel ({}, {}, {}) is outside of its model", v.x, v.y, v.z));
    }
  }
  return {};
}

Result<void> Parser::read_palette(Bytes& content) {
  const auto bytes = content.take(4 * 256);
  if (!content.ok()) return error("ends too soon");
  // Colour i + 1 stands at i; the last entry is not used.
  std::memcpy(file_.palette[1].data(), bytes.data(), size_t{4} * 255);
  return {};
}

Result<void> Parser::read_material(Bytes& content) {
  const int32_t id = content.number();
  const Dictionary values = take_dictionary(content);
  if (!content.ok()) return error("ends too soon");
  VoxMaterial material;
  const std::string_view type = get(values, "_type");
  float weight = 1.0f;  // of older files: how much of its type it is
  get_number(values, "_weight", weight);
  get_number(values, "_rough", material.roughness);
  if (type == "_metal") {
    material.metal = weight;
    get_number(values, "_metal", material.metal);
  } else if (type == "_emit") {
    float power = 0.0f;  // decades
    material.emission = weight;
    get_number(values, "_emit", material.emission);
    get_number(values, "_flux", power);
    material.emission =
        std::max(material.emission, 0.0f) * std::pow(10.0f, std::clamp(power, 0.0f, 4.0f));
  } else if (type == "_glass") {
    material.glass = true;
  }
  if (type != "_metal" && type != "_glass") material.roughness = 1.0f;
  material.metal = std::clamp(material.metal, 0.0f, 1.0f);
  material.roughness = std::clamp(material.roughness, 0.0f, 1.0f);
  material.emission = std::clamp(material.emission, 0.0f, 1e4f);
  if (id >= 1 && id <= static_cast<int32_t>(kVoxColors)) file_.materials[id] = material;
  return {};
}

Result<void> Parser::read_layer(Bytes& content) {
  const int32_t id = content.number();
  const Dictionary attributes = take_dictionary(content);
  if (!content.ok()) return error("ends too soon");
  file_.layer_hidden[id] = get(attributes, "_hidden") == "1";
  return {};
}

Result<VoxNode*> Parser::add_node(int32_t id, NodeKind kind) {
  const auto [place, is_new] = file_.nodes.try_emplace(id);
  if (!is_new) return error(fmt::format("there is a node {} already", id));
  place->second.kind = kind;
  return &place->second;
}

Result<int32_t> Parser::frame_of(const Dictionary& attributes) {
  const std::string_view text = get(attributes, "_f");
  std::array<int32_t, 1> frame{0};
  if (!text.empty() && (!get_integers(text, kHighestFrame, frame) || frame[0] < 0)) {
    return error(fmt::format("\"{}\" is no frame", printable(text)));
  }
  return frame[0];
}

// A byte: the columns of rows 0 and 1 in two bits each, then the three signs.
Result<Rotation> rotation_of(std::string_view text) {
  std::array<int32_t, 1> packed{0b0000100};
  Rotation result;
  const bool is_byte = text.empty() || get_integers(text, 127, packed);
  const auto bits = static_cast<uint32_t>(packed[0]);
  const uint32_t first = bits & 3, second = bits >> 2 & 3;
  if (!is_byte || packed[0] < 0 || first == second || first > 2 || second > 2) {
    return fail({ErrorKind::bad_input, "", "", "", ""});
  }
  result.column = {static_cast<uint8_t>(first), static_cast<uint8_t>(second),
                   static_cast<uint8_t>(3 - first - second)};
  for (uint32_t row = 0; row < 3; ++row) result.sign[row] = bits >> (4 + row) & 1 ? -1 : 1;
  return result;
}

Result<void> Parser::read_transform(Bytes& content) {
  const int32_t id = content.number();
  const Dictionary attributes = take_dictionary(content);
  const int32_t child = content.number();
  content.number();  // reserved
  const int32_t layer = content.number();
  const size_t frames = content.count();
  if (!content.ok() || frames == 0) return error("ends too soon");
  SINEW_TRY(VoxNode* const node, add_node(id, NodeKind::transform));
  node->name = get(attributes, "_name");
  node->hidden = get(attributes, "_hidden") == "1";
  node->layer = layer;
  node->children = {child};
  for (size_t i = 0; i < frames; ++i) {
    const Dictionary frame = take_dictionary(content);
    if (!content.ok()) return error("ends too soon");
    TransformKey key;
    SINEW_TRY(key.frame, frame_of(frame));
    const Result<Rotation> rotation = rotation_of(get(frame, "_r"));
    if (!rotation) return error(fmt::format("\"{}\" is no rotation", printable(get(frame, "_r"))));
    key.rotation = *rotation;
    std::array<int32_t, 3> at{0, 0, 0};
    const std::string_view translation = get(frame, "_t");
    if (!translation.empty() && !get_integers(translation, kFarthest, at)) {
      return error(fmt::format("\"{}\" is no translation", printable(translation)));
    }
    key.translation = glm::ivec3(at[0], at[1], at[2]);
    if (i > 0 && key.frame <= node->places.back().frame) return error("its frames do not rise");
    node->places.push_back(key);
  }
  return {};
}

Result<void> Parser::read_group(Bytes& content) {
  const int32_t id = content.number();
  take_dictionary(content);
  const size_t count = content.count();
  if (!content.ok()) return error("ends too soon");
  SINEW_TRY(VoxNode* const node, add_node(id, NodeKind::group));
  for (size_t i = 0; i < count && content.ok(); ++i) node->children.push_back(content.number());
  if (!content.ok()) return error("ends too soon");
  return {};
}

Result<void> Parser::read_shape(Bytes& content) {
  const int32_t id = content.number();
  take_dictionary(content);
  const size_t count = content.count();
  if (!content.ok() || count == 0) return error("ends too soon");
  SINEW_TRY(VoxNode* const node, add_node(id, NodeKind::shape));
  for (size_t i = 0; i < count; ++i) {
    const int32_t model = content.number();
    const Dictionary attributes = take_dictionary(content);
    if (!content.ok() || model < 0) return error("ends too soon");
    ModelKey key;
    key.model = static_cast<uint32_t>(model);
    SINEW_TRY(key.frame, frame_of(attributes));
    if (i > 0 && key.frame <= node->models.back().frame) return error("its frames do not rise");
    node->models.push_back(key);
  }
  return {};
}

Result<void> Parser::check_models() const {
  if (has_size_) return error("its last model has no voxels");
  for (const auto& [id, node] : file_.nodes) {
    for (const ModelKey& key : node.models) {
      if (key.model < file_.models.size()) continue;
      return error(fmt::format("node {} shows model {}, but there are {}", id, key.model,
                               file_.models.size()));
    }
  }
  return {};
}

}  // namespace

mat3 Rotation::matrix() const {
  mat3 result(0.0f);
  for (int row = 0; row < 3; ++row) {
    result[column[static_cast<size_t>(row)]][row] = sign[static_cast<size_t>(row)];
  }
  return result;
}

std::array<std::array<uint8_t, 4>, 256> default_palette() {
  constexpr uint8_t kSteps[6] = {0xff, 0xcc, 0x99, 0x66, 0x33, 0x00};
  constexpr uint8_t kRamp[10] = {0xee, 0xdd, 0xbb, 0xaa, 0x88, 0x77, 0x55, 0x44, 0x22, 0x11};
  std::array<std::array<uint8_t, 4>, 256> palette{};
  size_t next = 1;
  for (size_t i = 0; i < 215; ++i) {  // a cube of 6^3 without black, blue changing fastest
    palette[next++] = {kSteps[i / 36], kSteps[i / 6 % 6], kSteps[i % 6], 255};
  }
  for (size_t channel = 0; channel < 4; ++channel) {  // red, green, blue, grey
    for (const uint8_t value : kRamp) {
      std::array<uint8_t, 4> color{0, 0, 0, 255};
      for (size_t k = 0; k < 3; ++k) {
        if (channel == k || channel == 3) color[k] = value;
      }
      palette[next++] = color;
    }
  }
  return palette;
}

Result<VoxFile> parse_file(std::span<const uint8_t> bytes, const std::string& path) {
  return Parser(path).parse(bytes);
}

}  // namespace sinew::vox
