// Files, scopes and the order of things. Settings and primitives have files of their own.
#include "sinew/io/aff/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "sinew/io/asset_folder.h"
#include "sinew/io/output_file.h"
#include "sinew/io/text.h"

namespace sinew::aff {
namespace {

constexpr size_t kDeepestInclude = 32;
constexpr size_t kDeepestScope = 1024;
constexpr uint32_t kMostIncludes = 100'000;
constexpr uint64_t kMostTextBytes = uint64_t{1} << 30;

}  // namespace

Affine affine(const glm::dmat4& m) {
  return Affine(vec3(m[0]), vec3(m[1]), vec3(m[2]), vec3(m[3]));
}

Reader::Reader(Scene& scene, const std::filesystem::path& path, const LoadOptions& options)
    : scene_(scene),
      path_(path.string()),
      folder_(asset_folder(path)),
      options_(options),
      materials_(scene, folder_),
      detail_(std::numeric_limits<int64_t>::max()) {
  scene_.environment = {vec3(0.0f), vec3(0.0f), vec3(0.0f), vec3(0.0f)};
}

Result<Content> Reader::run() {
  scopes_.push_back({});
  content_.objects.emplace_back().name = std::filesystem::path(path_).stem().string();
  std::error_code ignored;
  const auto canonical = std::filesystem::weakly_canonical(path_, ignored);
  SINEW_CHECKED(read_file(canonical.string(), path_));
  materials_.set_ambient_light(ambient_light_);
  content_.bytes = bytes_;
  return std::move(content_);
}

Result<void> Reader::charge(uint64_t bytes, const Words& words) {
  bytes_ += bytes;
  if (bytes_ <= options_.memory_limit) return {};
  return words.error("the scene takes more than the memory limit", "raise the memory limit");
}

uint64_t Reader::memory_left() const {
  return options_.memory_limit - std::min(bytes_, options_.memory_limit);
}

Result<const std::string*> Reader::text_of(const std::string& file, const std::string& name) {
  auto known = texts_.find(file);
  if (known == texts_.end()) {
    SINEW_TRY(std::string text, sinew::read_file(name, std::min(memory_left(), kMostTextBytes)));
    bytes_ += text.size();
    known = texts_.emplace(file, std::move(text)).first;
  }
  text_bytes_ += known->second.size();
  if (text_bytes_ > kMostTextBytes) {
    return fail({ErrorKind::bad_input, name, "",
                 fmt::format("the files, each counted as often as it is included, hold more than "
                             "{} bytes",
                             kMostTextBytes),
                 "include fewer files"});
  }
  return &known->second;
}

Result<void> Reader::read_file(const std::string& file, const std::string& name) {
  SINEW_TRY(const std::string* text, text_of(file, name));
  including_.push_back(file);
  Words words(*text, name);
  SINEW_CHECKED(read_statements(words));
  including_.pop_back();
  return {};
}

Result<void> Reader::read_statements(Words& words) {
  const size_t outermost = scopes_.size();
  std::vector<size_t> opened;  // positions
  while (!words.at_end()) {
    const std::string_view statement = words.word();
    if (statement == "}") {
      if (scopes_.size() == outermost) return words.error("closes a brace that is not open");
      scopes_.pop_back();
      opened.pop_back();
      continue;
    }
    const size_t position = words.position();
    SINEW_TRY(bool known, read_structure(statement, words));
    if (!known) {
      SINEW_TRY(known, read_setting(statement, words));
    }
    if (!known) {
      SINEW_TRY(known, read_primitive(statement, words));
    }
    if (!known) {
      return words.error(fmt::format("\"{}\" is no statement of AFF", printable(statement)));
    }
    if (scopes_.size() > outermost + opened.size()) opened.push_back(position);
  }
  if (opened.empty()) return {};
  return words.error(
      fmt::format("the file ends within the braces of line {}", words.line_of(opened.back())),
      "check that the file is complete");
}

Result<bool> Reader::read_structure(std::string_view statement, Words& words) {
  Result<void> done;
  if (statement == "i") {
    done = read_include(words);
  } else if (statement == "d") {
    done = words.integer(detail_);
  } else if (statement == "xs") {
    done = read_static_transform(words);
  } else if (statement == "x") {
    done = read_animated_transform(words);
  } else if (statement == "k") {
    done = read_keys(words);
  } else {
    return false;
  }
  return done.map([] { return true; });
}

// "i level file". What a file sets (its materials) holds on after its end.
Result<void> Reader::read_include(Words& words) {
  int64_t level = 0;
  SINEW_CHECKED(words.integer(level));
  SINEW_TRY(const std::string name, words.name("a file name"));
  if (level > detail_) return {};
  const auto file = within_folder(folder_, name);
  if (!file) {
    return words.error("file \"" + printable(name) + "\" lies outside the scene's folder",
                       "put it beside the top file");
  }
  std::error_code ignored;
  if (!std::filesystem::exists(*file, ignored)) {
    return words.error("file \"" + printable(name) + "\" is missing", "put it beside the top file");
  }
  const std::string path = file->string();
  if (std::ranges::find(including_, path) != including_.end()) {
    return words.error("file \"" + printable(name) + "\" includes itself", "break the cycle");
  }
  if (including_.size() > kDeepestInclude) {
    return words.error(fmt::format("files include each other more than {} deep", kDeepestInclude),
                       "include fewer files");
  }
  if (++includes_ > kMostIncludes) {
    return words.error(fmt::format("more than {} files are included", kMostIncludes),
                       "include fewer files");
  }
  Scope scope = scopes_.back();
  if (!scope.in_include) {
    SINEW_CHECKED(open_object(file->stem().string(), scope.frame, to_frame(), words));
    scope.to_object = glm::dmat4(1.0);
    scope.object = content_.objects.size() - 1;
    scope.in_include = true;
  }
  scopes_.push_back(scope);
  SINEW_CHECKED(read_file(path, path));
  scopes_.pop_back();
  return {};
}

// "xs sx sy sz  ax ay az degrees  tx ty tz {": first scaled, then turned, then moved.
Result<void> Reader::read_static_transform(Words& words) {
  double v[10];
  SINEW_CHECKED(words.numbers(v));
  const glm::dvec3 axis(v[3], v[4], v[5]);
  const double length = glm::length(axis), angle = glm::radians(v[6]);
  if (length == 0.0 && angle != 0.0) {
    return words.error("turns about an axis without direction", "give an axis that is not 0 0 0");
  }
  SINEW_CHECKED(words.expect("{"));
  if (scopes_.size() > kDeepestScope) return words.error("transforms are nested too deep");
  const glm::dvec3 turn = length > 0.0 ? axis * (std::sin(0.5 * angle) / length) : glm::dvec3(0.0);
  glm::dmat4 m = glm::mat4_cast(glm::dquat(std::cos(0.5 * angle), turn.x, turn.y, turn.z));
  for (int i = 0; i < 3; ++i) m[i] *= v[i];
  m[3] = glm::dvec4(v[7], v[8], v[9], 1.0);
  Scope scope = scopes_.back();
  scope.to_object = scope.to_object * m;
  scopes_.push_back(scope);
  return {};
}

// "x name {": what is within moves by the keyframes of that name, which come later.
Result<void> Reader::read_animated_transform(Words& words) {
  SINEW_TRY(std::string name, words.name("the name of a transform"));
  SINEW_CHECKED(words.expect("{"));
  if (scopes_.size() > kDeepestScope) return words.error("transforms are nested too deep");
  Node node;
  SINEW_TRY(node.parent, node_here(words));
  node.name = name;
  SINEW_TRY(const uint32_t index, add_node(std::move(node), words));
  content_.named_nodes.push_back({name, index});
  Scope scope;
  scope.frame = static_cast<int32_t>(index);
  SINEW_CHECKED(open_object(std::move(name), scope.frame, glm::dmat4(1.0), words));
  scope.object = content_.objects.size() - 1;
  scopes_.push_back(scope);
  return {};
}

Result<void> Reader::read_keys(Words& words) {
  SINEW_TRY(Keyframes keys, read_keyframes(words, memory_left(), scene_.warnings));
  for (const Channel& channel : keys.channels) {
    SINEW_CHECKED(charge(channel.times.size() * 4 + channel.values.size() * 4, words));
  }
  std::string name = keys.name;
  content_.keyframes.insert_or_assign(std::move(name), std::move(keys));
  return {};
}

glm::dmat4 Reader::to_frame() const {
  const Scope& scope = scopes_.back();
  return content_.objects[scope.object].to_frame * scope.to_object;
}

Result<void> Reader::open_object(std::string name, int32_t frame, const glm::dmat4& to_frame,
                                 const Words& words) {
  SINEW_CHECKED(charge(sizeof(Object) + sizeof(Mesh) + sizeof(Node) + 4 * name.size(), words));
  Object& object = content_.objects.emplace_back();
  object.name = std::move(name);
  object.frame = frame;
  object.to_frame = to_frame;
  return {};
}

Result<uint32_t> Reader::add_node(Node node, const Words& words) {
  SINEW_CHECKED(charge(2 * sizeof(Node) + 4 * node.name.size(), words));
  scene_.nodes.push_back(std::move(node));
  return static_cast<uint32_t>(scene_.nodes.size() - 1);
}

Result<int32_t> Reader::node_here(const Words& words) {
  const glm::dmat4 matrix = to_frame();
  if (matrix == glm::dmat4(1.0)) return scopes_.back().frame;
  Node node;
  node.parent = scopes_.back().frame;
  node.has_matrix = true;
  node.matrix = affine(matrix);
  SINEW_TRY(const uint32_t index, add_node(std::move(node), words));
  return static_cast<int32_t>(index);
}

}  // namespace sinew::aff
