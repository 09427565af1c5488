// Checked access to a JSON document: every reader says what it wants and answers with the value or
// an Error that names the file, the element ("material 3") and the key. nlohmann::json parses; it
// stays inside json.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::gltf {

// A view of one value of a Document, or of nothing. Readers whose key may be absent say what comes
// back then; a view of nothing behaves as an empty object. The document must outlive it.
class Json {
 public:
  Json() = default;
  Json(const nlohmann::json* value, const std::string* file, std::string element)
      : value_(value), file_(file), element_(std::move(element)) {}

  bool has(const char* key) const { return find(key) != nullptr; }
  const std::string& element() const { return element_; }
  // An Error of this element, as a failed Result.
  tl::unexpected<Error> error(std::string problem, std::string remedy = {}) const;

  // Absent: a view of nothing. The member keeps this element's name.
  Result<Json> object(const char* key) const;
  // An array of objects, each named "<name> <index>" behind `prefix`. Absent: empty.
  Result<std::vector<Json>> objects(const char* key, std::string_view name,
                                    std::string_view prefix = {}) const;
  // The members of an object. Absent: empty.
  Result<std::vector<std::string>> keys(const char* key) const;

  // An index below `count`. Absent: nullopt.
  Result<std::optional<uint32_t>> index(const char* key, size_t count) const;
  // The same, but absence is an error.
  Result<uint32_t> required_index(const char* key, size_t count) const;
  // An array of indices below `count`. Absent: empty.
  Result<std::vector<uint32_t>> indices(const char* key, size_t count) const;

  Result<uint64_t> unsigned_number(const char* key, uint64_t fallback, uint64_t largest) const;
  Result<float> number(const char* key, float fallback) const;
  // Exactly out.size() numbers. Absent: `out` keeps what it holds, and false comes back.
  Result<bool> numbers(const char* key, std::span<float> out) const;
  Result<std::vector<float>> number_list(const char* key) const;
  Result<bool> boolean(const char* key, bool fallback) const;
  Result<std::string> text(const char* key, std::string_view fallback = {}) const;
  Result<std::vector<std::string>> texts(const char* key) const;

 private:
  const nlohmann::json* find(const char* key) const;
  tl::unexpected<Error> wrong(const char* key, std::string_view wanted) const;
  Result<const nlohmann::json*> array(const char* key) const;

  const nlohmann::json* value_ = nullptr;
  const std::string* file_ = nullptr;
  std::string element_;
};

// A parsed document. Not movable: views point into it.
class Document {
 public:
  static Result<std::unique_ptr<Document>> parse(std::string_view text, const std::string& file);
  ~Document();

  Json root() const;
  const std::string& file() const { return file_; }

 private:
  Document() = default;
  std::unique_ptr<nlohmann::json> value_;
  std::string file_;
};

}  // namespace sinew::gltf
