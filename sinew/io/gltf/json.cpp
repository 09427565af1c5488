#include "sinew/io/gltf/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace sinew::gltf {
namespace {

constexpr size_t kMostLevels = 256;

// Whole numbers from 0 to 2^53, also where an exporter wrote them as 3.0.
std::optional<uint64_t> as_unsigned(const nlohmann::json& value) {
  constexpr double kLargest = 9007199254740992.0;
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  if (!(number >= 0.0 && number <= kLargest) || number != std::floor(number)) return std::nullopt;
  return static_cast<uint64_t>(number);
}

std::optional<float> as_float(const nlohmann::json& value) {
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  if (!(std::abs(number) <= double{std::numeric_limits<float>::max()})) return std::nullopt;
  return static_cast<float>(number);
}

// How deep arrays and objects nest. Checked before parsing: each level costs memory out of
// proportion to its one byte.
size_t nesting_depth(std::string_view text) {
  size_t depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '[' || c == '{')) {
      deepest = std::max(deepest, ++depth);
    } else if (!in_string && (c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

const nlohmann::json* Json::find(const char* key) const {
  if (!value_ || !value_->is_object()) return nullptr;
  const auto member = value_->find(key);
  return member == value_->end() ? nullptr : &*member;
}

tl::unexpected<Error> Json::error(std::string problem, std::string remedy) const {
  return fail({ErrorKind::bad_input, file_ ? *file_ : std::string(), element_, std::move(problem),
               std::move(remedy)});
}

tl::unexpected<Error> Json::wrong(const char* key, std::string_view wanted) const {
  return error(fmt::format("\"{}\" is not {}", key, wanted), "correct the file or export it again");
}

Result<const nlohmann::json*> Json::array(const char* key) const {
  const nlohmann::json* value = find(key);
  if (value && !value->is_array()) return wrong(key, "an array");
  return value;
}

Result<Json> Json::object(const char* key) const {
  const nlohmann::json* value = find(key);
  if (value && !value->is_object()) return wrong(key, "an object");
  return Json(value, file_, element_);
}

Result<std::vector<Json>> Json::objects(const char* key, std::string_view name,
                                        std::string_view prefix) const {
  SINEW_TRY(const nlohmann::json* const values, array(key));
  std::vector<Json> result;
  if (!values) return result;
  result.reserve(values->size());
  for (const nlohmann::json& value : *values) {
    if (!value.is_object()) return wrong(key, "an array of objects");
    result.emplace_back(&value, file_, fmt::format("{}{} {}", prefix, name, result.size()));
  }
  return result;
}

Result<std::vector<std::string>> Json::keys(const char* key) const {
  SINEW_TRY(const Json member, object(key));
  std::vector<std::string> result;
  if (!member.value_) return result;
  for (const auto& item : member.value_->items()) result.push_back(item.key());
  return result;
}

Result<std::optional<uint32_t>> Json::index(const char* key, size_t count) const {
  const nlohmann::json* value = find(key);
  if (!value) return std::nullopt;
  const std::optional<uint64_t> number = as_unsigned(*value);
  if (!number) return wrong(key, "an index (a whole number, 0 or more)");
  if (*number >= count) {
    return error(fmt::format("\"{}\" is {}, but the file has only {} of them", key, *number, count),
                 "correct the file or export it again");
  }
  return static_cast<uint32_t>(*number);
}

Result<uint32_t> Json::required_index(const char* key, size_t count) const {
  SINEW_TRY(const std::optional<uint32_t> value, index(key, count));
  if (!value) return error(fmt::format("\"{}\" is missing", key));
  return *value;
}

Result<std::vector<uint32_t>> Json::indices(const char* key, size_t count) const {
  SINEW_TRY(const nlohmann::json* const values, array(key));
  std::vector<uint32_t> result;
  if (!values) return result;
  result.reserve(values->size());
  for (const nlohmann::json& value : *values) {
    const std::optional<uint64_t> number = as_unsigned(value);
    if (!number) return wrong(key, "an array of indices");
    if (*number >= count) {
      return error(
          fmt::format("\"{}\" holds {}, but the file has only {} of them", key, *number, count));
    }
    result.push_back(static_cast<uint32_t>(*number));
  }
  return result;
}

Result<uint64_t> Json::unsigned_number(const char* key, uint64_t fallback, uint64_t largest) const {
  const nlohmann::json* value = find(key);
  if (!value) return fallback;
  const std::optional<uint64_t> number = as_unsigned(*value);
  if (!number || *number > largest) {
    return wrong(key, fmt::format("a whole number from 0 to {}", largest));
  }
  return *number;
}

Result<float> Json::number(const char* key, float fallback) const {
  const nlohmann::json* value = find(key);
  if (!value) return fallback;
  const std::optional<float> number = as_float(*value);
  if (!number) return wrong(key, "a number within the range of float");
  return *number;
}

Result<bool> Json::numbers(const char* key, std::span<float> out) const {
  if (!has(key)) return false;
  SINEW_TRY(const std::vector<float> values, number_list(key));
  if (values.size() != out.size()) {
    return wrong(key, fmt::format("an array of {} numbers", out.size()));
  }
  std::copy(values.begin(), values.end(), out.begin());
  return true;
}

Result<std::vector<float>> Json::number_list(const char* key) const {
  SINEW_TRY(const nlohmann::json* const values, array(key));
  std::vector<float> result;
  if (!values) return result;
  result.reserve(values->size());
  for (const nlohmann::json& value : *values) {
    const std::optional<float> number = as_float(value);
    if (!number) return wrong(key, "an array of numbers within the range of float");
    result.push_back(*number);
  }
  return result;
}

Result<bool> Json::boolean(const char* key, bool fallback) const {
  const nlohmann::json* value = find(key);
  if (!value) return fallback;
  if (!value->is_boolean()) return wrong(key, "true or false");
  return value->get<bool>();
}

Result<std::string> Json::text(const char* key, std::string_view fallback) const {
  const nlohmann::json* value = find(key);
  if (!value) return std::string(fallback);
  if (!value->is_string()) return wrong(key, "a text");
  return value->get<std::string>();
}

Result<std::vector<std::string>> Json::texts(const char* key) const {
  SINEW_TRY(const nlohmann::json* const values, array(key));
  std::vector<std::string> result;
  if (!values) return result;
  for (const nlohmann::json& value : *values) {
    if (!value.is_string()) return wrong(key, "an array of texts");
    result.push_back(value.get<std::string>());
  }
  return result;
}

Result<std::unique_ptr<Document>> Document::parse(std::string_view text, const std::string& file) {
  if (nesting_depth(text) > kMostLevels) {
    return fail({ErrorKind::bad_input, file, "",
                 fmt::format("its JSON nests more than {} levels deep", kMostLevels), ""});
  }
  std::unique_ptr<Document> document(new Document);
  document->file_ = file;
  try {
    document->value_ = std::make_unique<nlohmann::json>(nlohmann::json::parse(text));
  } catch (const nlohmann::json::exception& exception) {
    return fail({ErrorKind::bad_input, file, "",
                 fmt::format("is not valid JSON: {}", exception.what()),
                 "check that the file is complete"});
  }
  if (!document->value_->is_object()) {
    return fail({ErrorKind::bad_input, file, "", "is not a glTF file: its JSON is no object", ""});
  }
  return document;
}

Document::~Document() = default;

Json Document::root() const {
  return Json(value_.get(), &file_, "");
}

}  // namespace sinew::gltf
