#include "sinew/io/ply/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "sinew/io/obj/text.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

static_assert(std::endian::native == std::endian::little, "little-endian values are not turned");

bool is_space(char c) {
  return is_blank(c) || c == '\n';
}

template <class T>
double load(const char* bytes, bool big_endian) {
  char turned[sizeof(T)];
  std::memcpy(turned, bytes, sizeof(T));
  if (big_endian) std::reverse(turned, turned + sizeof(T));
  return static_cast<double>(std::bit_cast<T>(turned));
}

double load(PlyType type, const char* bytes, bool big_endian) {
  switch (type) {
    case PlyType::i8:
      return load<int8_t>(bytes, big_endian);
    case PlyType::u8:
      return load<uint8_t>(bytes, big_endian);
    case PlyType::i16:
      return load<int16_t>(bytes, big_endian);
    case PlyType::u16:
      return load<uint16_t>(bytes, big_endian);
    case PlyType::i32:
      return load<int32_t>(bytes, big_endian);
    case PlyType::u32:
      return load<uint32_t>(bytes, big_endian);
    case PlyType::f32:
      return load<float>(bytes, big_endian);
    case PlyType::f64:
      break;
  }
  return load<double>(bytes, big_endian);
}

}  // namespace

void PlyValues::skip_blanks() {
  size_t blanks = 0;
  while (blanks < rest_.size() && is_space(rest_[blanks])) ++blanks;
  rest_.remove_prefix(blanks);
}

std::string_view PlyValues::take_word() {
  skip_blanks();
  size_t size = 0;
  while (size < rest_.size() && !is_space(rest_[size])) ++size;
  const std::string_view word = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return word;
}

bool PlyValues::take(PlyType type, double& out) {
  if (format_ == PlyFormat::ascii) {
    const std::string_view word = take_word();
    if (!word.empty() && take_number(word, out) == word.size()) return true;
    wrong_ = word;
    return false;
  }
  const size_t size = size_of(type);
  if (size > rest_.size()) return false;
  out = load(type, rest_.data(), format_ == PlyFormat::big_endian);
  rest_.remove_prefix(size);
  return true;
}

bool PlyValues::skip(PlyType type, uint64_t count) {
  if (format_ == PlyFormat::ascii) {
    for (uint64_t i = 0; i < count; ++i) {
      if (take_word().empty()) return false;
    }
    return true;
  }
  if (count > rest_.size() / size_of(type)) return false;
  rest_.remove_prefix(count * size_of(type));
  return true;
}

uint64_t PlyValues::left() {
  if (format_ == PlyFormat::ascii) skip_blanks();
  return rest_.size();
}

std::string PlyValues::problem() const {
  if (wrong_.empty()) return "the file is cut off here";
  return fmt::format("\"{}\" is not a number", printable(wrong_));
}

}  // namespace sinew
