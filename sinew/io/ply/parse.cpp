// Based on: Greg Turk, "The PLY Polygon File Format", 1994; the names of properties are those that
// Stanford's scans, MeshLab, Blender and VCGLib write.
#include "sinew/io/ply/parse.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "sinew/io/obj/text.h"
#include "sinew/io/ply/header.h"
#include "sinew/io/ply/values.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

// What a property of a vertex means: where its value goes in a row.
enum VertexSlot : int { kPosition = 0, kNormal = 3, kTexcoord = 6, kColor = 8, kSlots = 11 };
constexpr int kIgnored = -1;

struct SlotName {
  std::string_view name;
  int slot;
};
constexpr std::array<SlotName, 20> kSlotNames = {{
    {"x", kPosition},        {"y", kPosition + 1},          {"z", kPosition + 2},
    {"nx", kNormal},         {"ny", kNormal + 1},           {"nz", kNormal + 2},
    {"s", kTexcoord},        {"t", kTexcoord + 1},          {"u", kTexcoord},
    {"v", kTexcoord + 1},    {"texture_u", kTexcoord},      {"texture_v", kTexcoord + 1},
    {"red", kColor},         {"green", kColor + 1},         {"blue", kColor + 2},
    {"diffuse_red", kColor}, {"diffuse_green", kColor + 1}, {"diffuse_blue", kColor + 2},
    {"alpha", kIgnored},     {"diffuse_alpha", kIgnored},
}};

// What the type's largest value is as a share of 1: colours are bytes, or floats from 0 to 1.
double unit_of(PlyType type) {
  if (type == PlyType::f32 || type == PlyType::f64) return 1.0;
  const bool is_signed = type == PlyType::i8 || type == PlyType::i16 || type == PlyType::i32;
  return std::exp2(8.0 * size_of(type) - (is_signed ? 1 : 0)) - 1.0;
}

bool fits_float(double value) {
  return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
}

class Parser {
 public:
  Parser(std::string_view bytes, PlyHeader header, const std::string& path,
         const LoadOptions& options)
      : header_(std::move(header)),
        values_(header_.format, bytes.substr(header_.size)),
        path_(path),
        options_(options),
        file_bytes_(bytes.size()) {}

  Result<PolygonModel> run();

 private:
  tl::unexpected<Error> error(std::string problem, std::string remedy = "export it again") const {
    return fail({ErrorKind::bad_input, path_, fmt::format("{} {}", printable(where_->name), row_),
                 std::move(problem), std::move(remedy)});
  }
  Result<void> read_element(const PlyElement& element);
  Result<void> read_vertices(const PlyElement& element);
  Result<void> store_vertex(const std::array<double, kSlots>& row);
  Result<void> read_faces(const PlyElement& element, bool strips);
  Result<void> skip_rows(const PlyElement& element);
  Result<void> skip_property(const PlyProperty& property);
  Result<void> read_list(const PlyProperty& property, std::vector<double>& out);
  Result<uint64_t> read_count(const PlyProperty& property);
  Result<uint32_t> to_vertex(double index) const;
  Result<void> add_face(const std::vector<double>& indices, const std::vector<double>& texcoords);
  Result<void> add_strip(const std::vector<double>& indices);
  Result<void> check_memory(uint64_t more) const;
  Result<void> ignore(const PlyElement& element, std::span<const int> used);
  Result<void> finish();

  PlyHeader header_;
  PlyValues values_;
  const std::string& path_;
  const LoadOptions& options_;
  uint64_t file_bytes_;
  PolygonModel model_;
  const PlyElement* where_ = nullptr;
  uint64_t row_ = 0;
  bool has_normals_ = false, has_texcoords_ = false, has_colors_ = false;  // at vertices
  bool has_faces_ = false;
  uint64_t degenerate_ = 0;      // faces of fewer than 3 corners
  uint32_t first_texcoord_ = 0;  // of the vertices
  std::vector<PolygonCorner> face_;
};

Result<PolygonModel> Parser::run() {
  for (const PlyElement& element : header_.elements) {
    where_ = &element;
    row_ = 0;
    // Counts that the file cannot hold end here, before memory is taken for them.
    const uint64_t least = element.least_row(header_.format);
    if (least > 0 && element.count > (values_.left() + 1) / least) {
      return fail({ErrorKind::bad_input, path_, fmt::format("element {}", printable(element.name)),
                   fmt::format("the file is cut off: it cannot hold {} of them", element.count),
                   "check that the file is complete"});
    }
    SINEW_CHECKED(read_element(element));
  }
  SINEW_CHECKED(finish());
  return std::move(model_);
}

Result<void> Parser::read_element(const PlyElement& element) {
  if (element.name == "vertex") return read_vertices(element);
  if (element.name == "face") return read_faces(element, false);
  if (element.name == "tristrips") return read_faces(element, true);
  SINEW_CHECKED(ignore(element, {}));
  return skip_rows(element);
}

Result<void> Parser::skip_rows(const PlyElement& element) {
  if (element.properties.empty()) return {};
  for (row_ = 0; row_ < element.count; ++row_) {
    for (const PlyProperty& property : element.properties) SINEW_CHECKED(skip_property(property));
  }
  return {};
}

Result<uint64_t> Parser::read_count(const PlyProperty& property) {
  double count = 0.0;
  if (!values_.take(*property.count_type, count)) return error(values_.problem());
  // A value takes at least a byte, so this bounds lists before memory is taken for them.
  if (!(count >= 0.0 && count <= static_cast<double>(values_.left()) &&
        count == std::floor(count))) {
    return error(fmt::format("\"{}\" cannot have {} entries", printable(property.name), count));
  }
  return static_cast<uint64_t>(count);
}

Result<void> Parser::skip_property(const PlyProperty& property) {
  uint64_t count = 1;
  if (property.count_type) {
    SINEW_TRY(count, read_count(property));
  }
  if (!values_.skip(property.type, count)) return error(values_.problem());
  return {};
}

Result<void> Parser::read_list(const PlyProperty& property, std::vector<double>& out) {
  SINEW_TRY(const uint64_t count, read_count(property));
  // Each entry may become a triangle of three corners.
  SINEW_CHECKED(check_memory(count * (sizeof(double) + 4 * sizeof(PolygonCorner))));
  out.resize(count);
  for (double& value : out) {
    if (!values_.take(property.type, value)) return error(values_.problem());
  }
  return {};
}

// One warning an element, or an error where nothing may be left out.
Result<void> Parser::ignore(const PlyElement& element, std::span<const int> used) {
  std::vector<std::string> names;
  for (size_t i = 0; i < element.properties.size(); ++i) {
    const bool known = i < used.size() && used[i] != kIgnored;
    if (!known && !element.properties[i].name.ends_with("alpha")) {
      names.push_back(printable(element.properties[i].name));
    }
  }
  if (names.empty()) return {};
  if (names.size() > 8) names.resize(8, "...");
  std::string text = fmt::format("properties of \"{}\" are not supported: {}",
                                 printable(element.name), fmt::join(names, ", "));
  if (options_.strict) {
    return fail({ErrorKind::bad_input, path_, "", std::move(text), "load it without strict"});
  }
  model_.warnings.push_back(std::move(text) + ": ignored");
  return {};
}

Result<void> Parser::read_vertices(const PlyElement& element) {
  std::array<double, kSlots> row{}, unit;
  std::array<bool, kSlots> given{};
  std::vector<int> slots(element.properties.size(), kIgnored);
  unit.fill(1.0);
  for (size_t i = 0; i < slots.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    for (const SlotName& known : kSlotNames) {
      if (known.name != property.name || property.count_type || known.slot == kIgnored) continue;
      slots[i] = known.slot;
      given[known.slot] = true;
      if (known.slot >= kColor) unit[known.slot] = unit_of(property.type);
    }
  }
  const auto all = [&](int slot, int count) {
    return std::all_of(&given[slot], &given[slot] + count, [](bool is) { return is; });
  };
  if (!all(kPosition, 3)) return error("vertices need the properties x, y and z");
  if (element.count > kMostPolygonEntries) return error("has too many vertices");
  has_normals_ = all(kNormal, 3);
  has_texcoords_ = all(kTexcoord, 2);
  has_colors_ = all(kColor, 3);
  first_texcoord_ = static_cast<uint32_t>(model_.texcoords.size());
  SINEW_CHECKED(ignore(element, slots));
  const uint64_t vertex_bytes = 3 * sizeof(vec3) + sizeof(vec2);
  SINEW_CHECKED(check_memory(element.count * vertex_bytes));
  model_.positions.reserve(element.count);
  for (row_ = 0; row_ < element.count; ++row_) {
    for (size_t i = 0; i < slots.size(); ++i) {
      if (slots[i] == kIgnored) {
        SINEW_CHECKED(skip_property(element.properties[i]));
      } else if (double& value = row[slots[i]]; !values_.take(element.properties[i].type, value)) {
        return error(values_.problem());
      } else {
        value /= unit[slots[i]];
      }
    }
    SINEW_CHECKED(store_vertex(row));
  }
  return {};
}

// Scanners leave normals that are not numbers where they knew none; nothing else may be so.
Result<void> Parser::store_vertex(const std::array<double, kSlots>& row) {
  std::array<float, kSlots> value;
  for (int i = 0; i < kSlots; ++i) {
    const bool fits = fits_float(row[i]);
    if (!fits && (i < kNormal || i >= kTexcoord)) return error("has a number that is not finite");
    value[i] = fits ? static_cast<float>(row[i]) : 0.0f;
  }
  model_.positions.emplace_back(value[0], value[1], value[2]);
  if (has_normals_) model_.normals.emplace_back(value[3], value[4], value[5]);
  if (has_texcoords_) model_.texcoords.emplace_back(value[6], value[7]);
  if (has_colors_) model_.colors.emplace_back(value[8], value[9], value[10]);
  return {};
}

Result<uint32_t> Parser::to_vertex(double index) const {
  if (!(index >= 0.0 && index < static_cast<double>(kMostPolygonEntries) &&
        index == std::floor(index))) {
    return error(fmt::format("{} is not a vertex", index));
  }
  return static_cast<uint32_t>(index);
}

// The list that names the vertices of a face or strip, or -1.
int index_list(const PlyElement& element) {
  const int plural = element.find("vertex_indices", true);
  return plural >= 0 ? plural : element.find("vertex_index", true);
}

// Polygons, or strips of triangles.
Result<void> Parser::read_faces(const PlyElement& element, bool strips) {
  if (element.count == 0) return {};
  const int index_property = index_list(element);
  const int texcoord_property = strips ? -1 : element.find("texcoord", true);
  if (index_property < 0) return error("needs the list vertex_indices");
  has_faces_ = true;
  std::vector<int> used(element.properties.size(), kIgnored);
  used[index_property] = 0;
  if (texcoord_property >= 0) used[texcoord_property] = 0;
  SINEW_CHECKED(ignore(element, used));
  std::vector<double> indices, texcoords;
  for (row_ = 0; row_ < element.count; ++row_) {
    for (int i = 0; i < static_cast<int>(used.size()); ++i) {
      const PlyProperty& property = element.properties[i];
      if (used[i] == kIgnored) {
        SINEW_CHECKED(skip_property(property));
      } else {
        SINEW_CHECKED(read_list(property, i == index_property ? indices : texcoords));
      }
    }
    if (strips) {
      SINEW_CHECKED(add_strip(indices));
    } else {
      SINEW_CHECKED(add_face(indices, texcoords));
    }
  }
  return {};
}

// Texture coordinates, if the face has any, are u, v for each of its corners.
Result<void> Parser::add_face(const std::vector<double>& indices,
                              const std::vector<double>& texcoords) {
  if (indices.size() < 3) {
    ++degenerate_;
    return {};
  }
  if (!texcoords.empty() && texcoords.size() != 2 * indices.size()) {
    return error(fmt::format("has {} texture coordinates for {} corners", texcoords.size() / 2,
                             indices.size()));
  }
  face_.clear();
  for (size_t i = 0; i < indices.size(); ++i) {
    PolygonCorner corner;
    SINEW_TRY(corner.position, to_vertex(indices[i]));
    if (!texcoords.empty()) {
      const double u = texcoords[2 * i], v = texcoords[2 * i + 1];
      if (!fits_float(u) || !fits_float(v)) return error("has a number that is not finite");
      corner.texcoord = static_cast<uint32_t>(model_.texcoords.size());
      model_.texcoords.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
    face_.push_back(corner);
  }
  if (model_.corners.size() + 3 * face_.size() >= kMostPolygonEntries) {
    return error("has too many faces");
  }
  add_fan(face_, 0, model_);
  return {};
}

// -1 begins a new strip; every second triangle turns round; vertices that repeat only lead on.
Result<void> Parser::add_strip(const std::vector<double>& indices) {
  size_t begin = 0;
  std::vector<double> corners(3);
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] == -1.0) {
      begin = i + 1;
      continue;
    }
    if (i < begin + 2) continue;
    const bool turned = (i - begin) % 2 == 1;
    corners = {indices[i - 2], indices[i - 1], indices[i]};
    if (turned) std::swap(corners[0], corners[1]);
    const bool leads_on =
        corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2];
    if (!leads_on) SINEW_CHECKED(add_face(corners, {}));
  }
  return {};
}

Result<void> Parser::check_memory(uint64_t more) const {
  if (file_bytes_ + model_.bytes() + more <= options_.memory_limit) return {};
  return error(fmt::format("loading would take more than {} bytes", options_.memory_limit),
               "raise the memory limit");
}

Result<void> Parser::finish() {
  if (!has_faces_) {
    return fail({ErrorKind::bad_input, path_, "",
                 model_.positions.empty() ? "holds no mesh" : "is a point cloud: it has no faces",
                 "give a PLY file with faces"});
  }
  if (model_.corners.empty()) {
    return fail({ErrorKind::bad_input, path_, "", "has no face of three corners or more",
                 "give a PLY file with faces"});
  }
  const size_t vertices = model_.positions.size();
  for (size_t i = 0; i < model_.corners.size(); ++i) {
    PolygonCorner& corner = model_.corners[i];
    if (corner.position >= vertices) {
      return fail({ErrorKind::bad_input, path_, fmt::format("triangle {}", i / 3),
                   fmt::format("vertex {} does not exist: there are {}", corner.position, vertices),
                   "export it again"});
    }
    if (has_normals_) corner.normal = corner.position;
    if (has_texcoords_ && corner.texcoord == kNoIndex) {
      corner.texcoord = first_texcoord_ + corner.position;
    }
  }
  model_.parts.push_back({});
  if (!header_.textures.empty()) model_.texture = header_.textures[0];
  if (header_.textures.size() > 1) {
    model_.warnings.push_back("more than one texture is not supported: the first serves all faces");
  }
  if (degenerate_ > 0) {
    model_.warnings.push_back(
        fmt::format("{} faces have fewer than 3 corners: left out", degenerate_));
  }
  if (header_.format != PlyFormat::ascii && values_.left() > 0) {
    model_.warnings.push_back(
        fmt::format("{} bytes after the last element: ignored", values_.left()));
  }
  return {};
}

}  // namespace

Result<PolygonModel> parse_ply(std::string_view bytes, const std::string& path,
                               const LoadOptions& options) {
  SINEW_TRY(PlyHeader header, parse_ply_header(bytes, path));
  return Parser(bytes, std::move(header), path, options).run();
}

}  // namespace sinew
