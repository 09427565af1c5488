// Writes .vox files, version 200: models of at most 256^3, a palette, and a node for each object
// with one for each of its pieces below, whose shapes have a model a frame where something changes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <tuple>

#include "sinew/io/output_file.h"
#include "sinew/io/text.h"
#include "sinew/io/vox/quantize.h"
#include "sinew/io/vox/vox.h"
#include "sinew/math/srgb.h"

namespace sinew {
namespace vox {
namespace {

constexpr float kFarthest = 1 << 19;  // voxels from the origin

class ChunkWriter {
 public:
  void number(int64_t value) {
    const auto narrow = static_cast<int32_t>(value);
    const auto* const bytes = reinterpret_cast<const uint8_t*>(&narrow);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof narrow);
  }
  void byte(uint32_t value) { bytes_.push_back(static_cast<uint8_t>(value)); }
  void text(const std::string& value) {
    number(static_cast<int64_t>(value.size()));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
  }
  using Entries = std::vector<std::pair<std::string, std::string>>;
  void dictionary(const Entries& entries) {
    number(static_cast<int64_t>(entries.size()));
    for (const auto& [key, value] : entries) {
      text(key);
      text(value);
    }
  }
  // Appends a whole chunk without children.
  void chunk(const char* id, const ChunkWriter& content) {
    bytes_.insert(bytes_.end(), id, id + 4);
    number(static_cast<int64_t>(content.bytes_.size()));
    number(0);
    bytes_.insert(bytes_.end(), content.bytes_.begin(), content.bytes_.end());
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
};

// A voxel in the file's axes, in the world's voxels.
struct FileVoxel {
  glm::ivec3 at;
  uint8_t color;
};

// (x, y, z) of a voxel with +Y up is (x, -z - 1, y) with +Z up.
glm::ivec3 to_z_up(glm::ivec3 v) {
  return {v.x, -v.z - 1, v.y};
}

using Piece = std::array<int, 3>;  // which 256^3 of the world
Piece piece_of(glm::ivec3 at) {
  const auto floor_div = [](int a) { return a >= 0 ? a / 256 : -((-a + 255) / 256); };
  return {floor_div(at.x), floor_div(at.y), floor_div(at.z)};
}

// What a .vox file can say of a material.
struct Surface {
  float metal = 0.0f, roughness = 1.0f, emission = 0.0f;
  auto operator<=>(const Surface&) const = default;
};
Surface surface_of(const Material& material) {
  Surface surface;
  surface.metal = std::clamp(material.metallic, 0.0f, 1.0f);
  if (surface.metal > 0.0f) surface.roughness = std::clamp(material.roughness, 0.0f, 1.0f);
  const vec3 e = material.emissive;
  surface.emission = std::clamp(std::max({e.x, e.y, e.z}), 0.0f, 1e4f);
  return surface;
}

class Writer {
 public:
  Writer(std::span<const VoxObject> objects, std::span<const Material> materials)
      : objects_(objects), materials_(materials) {}

  Result<SavedVox> write(const std::string& path);

 private:
  Result<void> check();
  void make_palette();
  void write_object(const VoxObject& object, int32_t id);
  void write_piece(const std::vector<std::vector<FileVoxel>>& frames, glm::ivec3 low,
                   glm::ivec3 high);
  std::vector<FileVoxel> voxels_of(const VoxObject& object, size_t frame) const;
  void write_model(glm::ivec3 size, glm::ivec3 low, const std::vector<FileVoxel>& voxels);
  void write_transform(int32_t id, int32_t child, const std::string& name, glm::ivec3 at);
  void write_group(int32_t id, const std::vector<int32_t>& children);
  void write_colors();

  std::span<const VoxObject> objects_;
  std::span<const Material> materials_;
  SavedVox saved_;
  std::vector<uint32_t> surface_of_material_;
  std::vector<Surface> surfaces_;
  Palette palette_;
  ChunkWriter models_, nodes_;
  int32_t next_id_ = 0;
  std::vector<int32_t> pieces_;  // of the object that is written: their transforms
};

Result<void> Writer::check() {
  const auto bad = [](std::string problem, std::string remedy) {
    return fail({ErrorKind::bad_input, "", "", std::move(problem), std::move(remedy)});
  };
  if (objects_.empty()) return bad("there are no voxels to write", "give some");
  saved_.frames = 1;
  for (const VoxObject& object : objects_) {
    const auto frames = static_cast<uint32_t>(object.frames.size());
    if (frames == 0 || (frames > 1 && saved_.frames > 1 && frames != saved_.frames)) {
      return bad(fmt::format("object '{}' has {} frames", object.name, frames),
                 "give each object one frame, or all the same number");
    }
    saved_.frames = std::max(saved_.frames, frames);
    const vec3 far = glm::abs(object.grid.origin / object.grid.voxel);
    if (!(std::max({far.x, far.y, far.z}) < kFarthest)) {
      return bad(fmt::format("object '{}' is too far from the origin", object.name),
                 "move it nearer");
    }
    const float ratio = object.grid.voxel / objects_[0].grid.voxel;
    if (!(std::abs(ratio - 1.0f) < 1e-3f)) {
      return bad(fmt::format("voxels of object '{}' have another size than those of '{}'",
                             object.name, objects_[0].name),
                 "voxelise all objects with one --voxel-size");
    }
    for (const std::vector<PlainVoxel>& voxels : object.frames) {
      saved_.voxels += voxels.size();
      for (const PlainVoxel& v : voxels) {
        if (v.material >= materials_.size()) {
          return bad(fmt::format("object '{}' has material {}, but there are {}", object.name,
                                 v.material, materials_.size()),
                     "correct the voxels");
        }
      }
    }
  }
  return {};
}

void Writer::make_palette() {
  std::map<Surface, uint32_t> known;
  bool too_many = false;
  for (const Material& material : materials_) {
    Surface surface = surface_of(material);
    if (known.size() >= kVoxColors && !known.contains(surface)) {
      surface = surfaces_[0];
      too_many = true;
    }
    const auto [place, is_new] = known.try_emplace(surface, surfaces_.size());
    if (is_new) surfaces_.push_back(surface);
    surface_of_material_.push_back(place->second);
  }
  if (too_many) {
    saved_.warnings.push_back(
        fmt::format(".vox files have {} materials; others look like the first", kVoxColors));
  }
  std::map<SurfaceColor, uint64_t> counts;
  for (const VoxObject& object : objects_) {
    for (const std::vector<PlainVoxel>& voxels : object.frames) {
      for (const PlainVoxel& v : voxels) ++counts[{surface_of_material_[v.material], v.color}];
    }
  }
  palette_ = quantize(counts, kVoxColors);
  saved_.colors = static_cast<uint32_t>(palette_.entries.size());
  if (counts.size() > palette_.entries.size()) {
    saved_.warnings.push_back(fmt::format(".vox files have {} colours; {} were drawn together",
                                          kVoxColors, counts.size()));
  }
}

std::vector<FileVoxel> Writer::voxels_of(const VoxObject& object, size_t frame) const {
  const vec3 origin = glm::round(object.grid.origin / object.grid.voxel);
  std::vector<FileVoxel> result;
  for (const PlainVoxel& v : object.frames[frame]) {
    const glm::ivec3 at = glm::ivec3(origin) + glm::ivec3(voxel_of(v.voxel));
    const uint8_t entry = palette_.index.at({surface_of_material_[v.material], v.color});
    result.push_back({to_z_up(at), static_cast<uint8_t>(entry + 1)});
  }
  return result;
}

void Writer::write_model(glm::ivec3 size, glm::ivec3 low, const std::vector<FileVoxel>& voxels) {
  ChunkWriter dimensions, content;
  for (int axis = 0; axis < 3; ++axis) dimensions.number(size[axis]);
  models_.chunk("SIZE", dimensions);
  content.number(static_cast<int64_t>(voxels.size()));
  for (const FileVoxel& v : voxels) {
    const glm::ivec3 local = v.at - low;
    for (int axis = 0; axis < 3; ++axis) content.byte(static_cast<uint32_t>(local[axis]));
    content.byte(v.color);
  }
  models_.chunk("XYZI", content);
  ++saved_.models;
}

void Writer::write_transform(int32_t id, int32_t child, const std::string& name, glm::ivec3 at) {
  ChunkWriter node;
  node.number(id);
  node.dictionary(name.empty() ? ChunkWriter::Entries{} : ChunkWriter::Entries{{"_name", name}});
  node.number(child);
  node.number(-1);
  node.number(-1);
  node.number(1);
  if (at == glm::ivec3(0)) {
    node.dictionary({});
  } else {
    node.dictionary({{"_t", fmt::format("{} {} {}", at.x, at.y, at.z)}});
  }
  nodes_.chunk("nTRN", node);
}

void Writer::write_group(int32_t id, const std::vector<int32_t>& children) {
  ChunkWriter node;
  node.number(id);
  node.dictionary({});
  node.number(static_cast<int64_t>(children.size()));
  for (const int32_t child : children) node.number(child);
  nodes_.chunk("nGRP", node);
}

bool is_same(const std::vector<FileVoxel>& a, const std::vector<FileVoxel>& b) {
  return std::ranges::equal(a, b, [](const FileVoxel& x, const FileVoxel& y) {
    return x.at == y.at && x.color == y.color;
  });
}

// A shape, and the transform that puts it in its place: all frames have one size.
void Writer::write_piece(const std::vector<std::vector<FileVoxel>>& frames, glm::ivec3 low,
                         glm::ivec3 high) {
  const glm::ivec3 size = high - low + 1;
  const int32_t transform = next_id_++, shape = next_id_++;
  std::vector<std::pair<size_t, uint32_t>> keys;  // frame, model
  for (size_t f = 0; f < frames.size(); ++f) {
    if (f > 0 && is_same(frames[f], frames[f - 1])) continue;
    keys.push_back({f, saved_.models});
    write_model(size, low, frames[f]);
  }
  // The last frame says how long it goes on.
  if (keys.size() > 1 && keys.back().first + 1 < frames.size()) {
    keys.push_back({frames.size() - 1, keys.back().second});
  }
  write_transform(transform, shape, "", low + size / 2);
  ChunkWriter node;
  node.number(shape);
  node.dictionary({});
  node.number(static_cast<int64_t>(keys.size()));
  for (const auto& [frame, model] : keys) {
    node.number(model);
    node.dictionary(keys.size() == 1 ? ChunkWriter::Entries{}
                                     : ChunkWriter::Entries{{"_f", std::to_string(frame)}});
  }
  nodes_.chunk("nSHP", node);
  pieces_.push_back(transform);
}

void Writer::write_object(const VoxObject& object, int32_t id) {
  struct Box {
    glm::ivec3 low, high;
  };
  std::map<Piece, std::pair<Box, std::vector<std::vector<FileVoxel>>>> pieces;
  for (size_t f = 0; f < object.frames.size(); ++f) {
    for (const FileVoxel& v : voxels_of(object, f)) {
      const auto [place, is_new] = pieces.try_emplace(piece_of(v.at));
      auto& [box, frames] = place->second;
      if (is_new) {
        box = {v.at, v.at};
        frames.resize(object.frames.size());
      }
      box = {min(box.low, v.at), max(box.high, v.at)};
      frames[f].push_back(v);
    }
  }
  pieces_.clear();
  const int32_t group = next_id_++;
  for (const auto& [place, content] : pieces) {
    write_piece(content.second, content.first.low, content.first.high);
  }
  write_transform(id, group, object.name, glm::ivec3(0));
  write_group(group, pieces_);
}

void Writer::write_colors() {
  ChunkWriter colors;
  for (size_t i = 0; i < 256; ++i) {
    const bool used = i < palette_.entries.size();
    for (size_t k = 0; k < 3; ++k) colors.byte(used ? palette_.entries[i].srgb[k] : 0u);
    colors.byte(used ? 255u : 0u);
  }
  nodes_.chunk("RGBA", colors);
  for (size_t i = 0; i < palette_.entries.size(); ++i) {
    const Surface& surface = surfaces_[palette_.entries[i].surface];
    ChunkWriter::Entries entries;
    if (surface.emission > 0.0f) {
      // What shines has its colour times the emission; brighter than 1 goes by decades.
      const auto& srgb = palette_.entries[i].srgb;
      const float color = srgb_codes_to_linear()[std::max({srgb[0], srgb[1], srgb[2], uint8_t{1}})];
      const float emission = std::min(surface.emission / color, 1e4f);
      const float power = std::max(0.0f, std::ceil(std::log10(emission)));
      entries = {{"_type", "_emit"},
                 {"_emit", fmt::format("{:.6g}", emission / std::pow(10.0f, power))},
                 {"_flux", fmt::format("{:.6g}", power)}};
    } else if (surface.metal > 0.0f) {
      entries = {{"_type", "_metal"},
                 {"_metal", fmt::format("{:.6g}", surface.metal)},
                 {"_rough", fmt::format("{:.6g}", surface.roughness)}};
    } else {
      continue;
    }
    ChunkWriter material;
    material.number(static_cast<int64_t>(i) + 1);
    material.dictionary(entries);
    nodes_.chunk("MATL", material);
  }
}

Result<SavedVox> Writer::write(const std::string& path) {
  SINEW_CHECKED(check());
  make_palette();
  next_id_ = 2;  // after the root and its group
  std::vector<int32_t> roots;
  for (const VoxObject& object : objects_) {
    roots.push_back(next_id_++);
    write_object(object, roots.back());
  }
  write_transform(0, 1, "", glm::ivec3(0));
  write_group(1, roots);
  write_colors();
  const uint64_t children = uint64_t{models_.bytes().size()} + nodes_.bytes().size();
  if (children > INT32_MAX) {
    return fail({ErrorKind::bad_input, path, "",
                 fmt::format("would have {} bytes, but .vox files end at 2 GiB", children),
                 "use a lower resolution or fewer frames"});
  }
  ChunkWriter head;
  for (const char c : {'V', 'O', 'X', ' '}) head.byte(static_cast<uint8_t>(c));
  head.number(200);
  for (const char c : {'M', 'A', 'I', 'N'}) head.byte(static_cast<uint8_t>(c));
  head.number(0);
  head.number(static_cast<int64_t>(children));
  SINEW_TRY(OutputFile file, OutputFile::create(path));
  for (const ChunkWriter* const part : {&head, &models_, &nodes_}) {
    SINEW_CHECKED(file.write(part->bytes()));
  }
  SINEW_CHECKED(file.publish());
  saved_.path = path;
  saved_.bytes = file.size();
  return std::move(saved_);
}

}  // namespace
}  // namespace vox

Result<SavedVox> save_vox(std::span<const VoxObject> objects, std::span<const Material> materials,
                          const std::string& path) {
  SINEW_CHECKED(check_save_vox(path));
  return vox::Writer(objects, materials).write(path);
}

Result<void> check_save_vox(const std::string& path) {
  if (path != "-" && extension_of(path) != ".vox") {
    return fail({ErrorKind::usage, path, "", "is no name of a file of MagicaVoxel",
                 "name the output .vox"});
  }
  return check_writable(path);
}

}  // namespace sinew
