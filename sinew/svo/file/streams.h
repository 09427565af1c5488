// Streams of bytes, one after another, each of values of one kind, so that a general compressor
// finds alike what is alike. Numbers wider than a byte go by planes: all low bytes, then all high.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sinew::svo_file {

// What takes how much of a file, for reports.
enum class Part : uint8_t { tables, topology, normals, colors, levels, lattice };
inline constexpr size_t kParts = 6;

// Small numbers of both signs as small numbers.
inline uint16_t fold(uint16_t difference) {
  return static_cast<uint16_t>(difference << 1 ^ (difference & 0x8000 ? 0xffff : 0));
}
inline uint16_t unfold(uint16_t folded) {
  return static_cast<uint16_t>(folded >> 1 ^ (folded & 1 ? 0xffff : 0));
}

class StreamWriter {
 public:
  // Values of T, or of anything that converts to it: at(i) for i in [0, count).
  template <class T, class At>
  void add(Part part, size_t count, const At& at) {
    for (size_t plane = 0; plane < sizeof(T); ++plane) {
      for (size_t i = 0; i < count; ++i) {
        bytes_.push_back(static_cast<uint8_t>(static_cast<T>(at(i)) >> (8 * plane)));
      }
      end(part);
    }
  }
  template <class T>
  void add(Part part, const std::vector<T>& values) {
    add<T>(part, values.size(), [&](size_t i) { return values[i]; });
  }

  const std::vector<uint8_t>& bytes() const { return bytes_; }
  const std::vector<size_t>& ends() const { return ends_; }  // of streams
  const std::vector<Part>& parts() const { return parts_; }  // one a stream

 private:
  void end(Part part) {
    ends_.push_back(bytes_.size());
    parts_.push_back(part);
  }

  std::vector<uint8_t> bytes_;
  std::vector<size_t> ends_;
  std::vector<Part> parts_;
};

// Takes streams off the front. What is missing reads as nothing and clears ok().
class StreamReader {
 public:
  explicit StreamReader(std::span<const uint8_t> bytes) : left_(bytes) {}

  template <class T>
  std::vector<T> take(size_t count) {
    std::vector<T> values;
    if (left_.size() / sizeof(T) < count) {
      ok_ = false;
      return values;
    }
    values.resize(count);
    for (size_t plane = 0; plane < sizeof(T); ++plane) {
      const uint8_t* const from = left_.data() + plane * count;
      for (size_t i = 0; i < count; ++i) {
        values[i] = static_cast<T>(values[i] | static_cast<T>(T{from[i]} << (8 * plane)));
      }
    }
    left_ = left_.subspan(count * sizeof(T));
    return values;
  }

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && left_.empty(); }
  size_t left() const { return left_.size(); }

 private:
  std::span<const uint8_t> left_;
  bool ok_ = true;
};

}  // namespace sinew::svo_file
