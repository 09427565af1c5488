// Based on: Wavefront, "Object Files (.obj)", Advanced Visualizer manual, appendix B1, 1995;
// the polygonal part of it. Groups and objects do not matter here; curves, points and lines are
// ignored.
#include "sinew/io/obj/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "sinew/io/obj/text.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

class Parser {
 public:
  Parser(std::string_view text, const std::string& path, const LoadOptions& options)
      : lines_(text), path_(path), options_(options), memory_(text.size()) {}

  Result<PolygonModel> run();

 private:
  tl::unexpected<Error> error(std::string problem, std::string remedy = "") const {
    return fail({ErrorKind::bad_input, path_, fmt::format("line {}", lines_.number()),
                 std::move(problem), std::move(remedy)});
  }

  Result<void> read_line(std::string_view line);
  Result<void> read_position(ObjWords words);
  Result<void> read_texcoord(ObjWords words);
  Result<void> read_normal(ObjWords words);
  Result<void> read_face(ObjWords words);
  Result<PolygonCorner> read_corner(ObjWords& words);
  Result<uint32_t> read_index(ObjWords& words, size_t count, const char* what);
  Result<void> ignore(std::string_view statement);
  Result<void> check_memory();
  Result<size_t> read_numbers(ObjWords& words, std::span<float> out, size_t least);
  uint32_t part_of_face(bool has_normals);
  void use_material(std::string_view name);
  Result<void> finish();

  ObjLines lines_;
  const std::string& path_;
  const LoadOptions& options_;
  uint64_t memory_;  // bytes
  PolygonModel model_;

  uint32_t material_ = kNoIndex;
  bool smoothing_off_ = false;
  std::unordered_map<std::string, uint32_t> material_index_;
  // Parts by material (kNoIndex + 1 is 0): smooth, flat.
  std::vector<std::array<uint32_t, 2>> part_index_;
  IgnoredStatements ignored_;
  bool has_weights_ = false;
  std::vector<PolygonCorner> face_;
};

Result<PolygonModel> Parser::run() {
  std::string_view line;
  while (lines_.next(line)) {
    SINEW_CHECKED(read_line(line));
    if ((lines_.number() & 1023) == 0) SINEW_CHECKED(check_memory());
  }
  SINEW_CHECKED(finish());
  return std::move(model_);
}

Result<void> Parser::read_line(std::string_view line) {
  ObjWords words(line);
  if (words.at_end()) return {};
  const std::string_view statement = words.word();
  if (statement == "v") return read_position(words);
  if (statement == "f" || statement == "fo") return read_face(words);
  if (statement == "vt") return read_texcoord(words);
  if (statement == "vn") return read_normal(words);
  if (statement == "g" || statement == "o") return {};
  if (statement == "s") {
    smoothing_off_ = words.rest() == "off" || words.rest() == "0";
    return {};
  }
  if (statement == "usemtl") {
    use_material(words.rest());
    return {};
  }
  if (statement == "mtllib") {
    const std::string name(words.rest());
    if (name.empty()) return error("mtllib names no file");
    if (std::find(model_.libraries.begin(), model_.libraries.end(), name) ==
        model_.libraries.end()) {
      if (model_.libraries.size() >= 64) return error("names more than 64 material libraries");
      model_.libraries.push_back(name);
    }
    return {};
  }
  return ignore(statement);
}

Result<size_t> Parser::read_numbers(ObjWords& words, std::span<float> out, size_t least) {
  auto count = take_numbers(words, out, least);
  if (!count) return error(std::move(count.error()));
  return *count;
}

// x y z, then a weight w, or a colour r g b, or both.
Result<void> Parser::read_position(ObjWords words) {
  std::array<float, 7> value{};
  SINEW_TRY(const size_t count, read_numbers(words, value, 3));
  if (count == 5) return error("a vertex cannot have 5 numbers");
  if (model_.positions.size() >= kMostPolygonEntries) return error("has too many vertices");
  has_weights_ |= (count == 4 || count == 7) && value[3] != 1.0f;
  if (count >= 6) {
    model_.colors.resize(model_.positions.size(), vec3(1.0f));
    model_.colors.emplace_back(value[count - 3], value[count - 2], value[count - 1]);
  } else if (!model_.colors.empty()) {
    model_.colors.emplace_back(1.0f);
  }
  model_.positions.emplace_back(value[0], value[1], value[2]);
  return {};
}

Result<void> Parser::read_texcoord(ObjWords words) {
  std::array<float, 3> value{};
  SINEW_CHECKED(read_numbers(words, value, 1));
  if (model_.texcoords.size() >= kMostPolygonEntries)
    return error("has too many texture coordinates");
  model_.texcoords.emplace_back(value[0], value[1]);
  return {};
}

Result<void> Parser::read_normal(ObjWords words) {
  std::array<float, 3> value{};
  SINEW_CHECKED(read_numbers(words, value, 3));
  if (model_.normals.size() >= kMostPolygonEntries) return error("has too many normals");
  model_.normals.emplace_back(value[0], value[1], value[2]);
  return {};
}

// Indices count from 1; negative ones count back from the last entry so far.
Result<uint32_t> Parser::read_index(ObjWords& words, size_t count, const char* what) {
  int64_t index = 0;
  if (!words.integer(index))
    return error(fmt::format("\"{}\" is not an index", printable(words.word())));
  const int64_t from_zero = index < 0 ? static_cast<int64_t>(count) + index : index - 1;
  if (index == 0 || from_zero < 0 || from_zero >= static_cast<int64_t>(count)) {
    return error(
        fmt::format("{} {} does not exist: there are {} above this line", what, index, count),
        "export the file again");
  }
  return static_cast<uint32_t>(from_zero);
}

// v, v/vt, v//vn or v/vt/vn
Result<PolygonCorner> Parser::read_corner(ObjWords& words) {
  PolygonCorner corner;
  SINEW_TRY(corner.position, read_index(words, model_.positions.size(), "vertex"));
  if (words.take('/')) {
    if (words.take('/')) {
      SINEW_TRY(corner.normal, read_index(words, model_.normals.size(), "normal"));
    } else {
      SINEW_TRY(corner.texcoord, read_index(words, model_.texcoords.size(), "texture coordinate"));
      if (words.take('/')) {
        SINEW_TRY(corner.normal, read_index(words, model_.normals.size(), "normal"));
      }
    }
  }
  if (!words.end_word())
    return error(fmt::format("\"{}\" is not part of a face", printable(words.word())));
  return corner;
}

Result<void> Parser::read_face(ObjWords words) {
  face_.clear();
  while (!words.at_end()) {
    SINEW_TRY(const PolygonCorner corner, read_corner(words));
    face_.push_back(corner);
  }
  if (face_.size() < 3) return error("a face needs at least 3 corners");
  if (model_.triangle_part.size() + face_.size() >= kMostPolygonEntries / 3) {
    return error("has too many faces");
  }
  const bool has_normals = std::all_of(face_.begin(), face_.end(), [](const PolygonCorner& corner) {
    return corner.normal != kNoIndex;
  });
  const uint32_t part = part_of_face(has_normals);
  add_fan(face_, part, model_);
  return {};
}

void Parser::use_material(std::string_view name) {
  const auto [entry, added] = material_index_.try_emplace(
      std::string(name), static_cast<uint32_t>(model_.materials.size()));
  if (added) {
    model_.materials.emplace_back(name);
    memory_ += 2 * name.size() + 200;
  }
  material_ = entry->second;
}

uint32_t Parser::part_of_face(bool has_normals) {
  const bool flat = smoothing_off_ && !has_normals;
  const size_t slot = material_ == kNoIndex ? 0 : material_ + size_t{1};
  if (slot >= part_index_.size()) part_index_.resize(slot + 1, {kNoIndex, kNoIndex});
  uint32_t& part = part_index_[slot][flat];
  if (part == kNoIndex) {
    part = static_cast<uint32_t>(model_.parts.size());
    model_.parts.push_back({material_, flat});
  }
  return part;
}

Result<void> Parser::ignore(std::string_view statement) {
  if (options_.strict) {
    return error(fmt::format("statement \"{}\" is not supported", printable(statement)),
                 "load it without strict");
  }
  if (!ignored_.add(statement, lines_.number())) {
    return error(fmt::format("\"{}\" is one unknown statement too many", printable(statement)),
                 "give an OBJ file");
  }
  return {};
}

Result<void> Parser::check_memory() {
  if (memory_ + model_.bytes() > options_.memory_limit) {
    return error(fmt::format("loading would take more than {} bytes", options_.memory_limit),
                 "raise the memory limit");
  }
  return {};
}

Result<void> Parser::finish() {
  SINEW_CHECKED(check_memory());
  if (model_.corners.empty()) {
    return fail({ErrorKind::bad_input, path_, "", "has no faces", "give an OBJ file with faces"});
  }
  if (has_weights_) {
    if (options_.strict) {
      return fail({ErrorKind::bad_input, path_, "", "vertices with weights are not supported",
                   "load it without strict"});
    }
    model_.warnings.push_back("weights of vertices (v x y z w) are not supported: ignored");
  }
  ignored_.append_warnings("", model_.warnings);
  return {};
}

}  // namespace

Result<PolygonModel> parse_obj(std::string_view text, const std::string& path,
                               const LoadOptions& options) {
  return Parser(text, path, options).run();
}

}  // namespace sinew
