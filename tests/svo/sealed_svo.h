// Encoded octrees from parts that nobody has packed or summed yet, so that what is changed in them
// reaches the decoder behind the checksums. See svo/file/file.h for the layout.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "sinew/base/packing.h"
#include "sinew/svo/file/file.h"

namespace sinew::test {

struct UnsealedSvo {
  uint32_t flags = 0;
  std::vector<uint8_t> head;  // without the sizes and checksums of pages, which it ends with
  std::vector<std::vector<uint8_t>> pages;  // skeletons, then details
};

inline constexpr size_t kSealPerPage = 4 + 4 + 8;

template <class T>
void put(std::vector<uint8_t>& out, T value) {
  const auto* const bytes = reinterpret_cast<const uint8_t*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

// Numbers as the format has them: all lowest bytes, then the next.
template <class T>
void put_planes(std::vector<uint8_t>& out, const std::vector<T>& values) {
  for (size_t plane = 0; plane < sizeof(T); ++plane) {
    for (const T value : values) out.push_back(static_cast<uint8_t>(value >> 8 * plane));
  }
}

template <class T>
std::vector<T> slice(const std::vector<T>& values, size_t from, size_t to) {
  return {values.begin() + static_cast<ptrdiff_t>(from),
          values.begin() + static_cast<ptrdiff_t>(to)};
}

inline std::vector<uint8_t> seal(const UnsealedSvo& parts) {
  std::vector<uint8_t> pages, head = parts.head;
  std::vector<uint32_t> unpacked_sizes, sizes;
  std::vector<uint64_t> sums;
  for (const std::vector<uint8_t>& page : parts.pages) {
    const std::vector<uint8_t> packed = pack(page, {}, 1).bytes;
    unpacked_sizes.push_back(static_cast<uint32_t>(page.size()));
    sizes.push_back(static_cast<uint32_t>(packed.size()));
    sums.push_back(checksum(packed));
    pages.insert(pages.end(), packed.begin(), packed.end());
  }
  const size_t half = parts.pages.size() / 2;
  for (const size_t from : {size_t{0}, half}) {
    const size_t to = from == 0 ? half : parts.pages.size();
    put_planes(head, slice(unpacked_sizes, from, to));
    put_planes(head, slice(sizes, from, to));
    put_planes(head, slice(sums, from, to));
  }
  const std::vector<uint8_t> packed = pack(head, {}, 1).bytes;
  std::vector<uint8_t> out = {'s', 'v', 'o', '2'};
  put(out, parts.flags);
  put(out, uint64_t{48} + packed.size() + pages.size());
  put(out, uint64_t{head.size()});
  put(out, uint64_t{packed.size()});
  put(out, checksum(packed));
  put(out, checksum(out));
  out.insert(out.end(), packed.begin(), packed.end());
  out.insert(out.end(), pages.begin(), pages.end());
  return out;
}

inline UnsealedSvo unseal(std::span<const uint8_t> bytes) {
  const SvoIndex index = *decode_svo_index(bytes, UINT64_MAX);
  UnsealedSvo parts;
  std::memcpy(&parts.flags, bytes.data() + 4, 4);
  uint64_t unpacked = 0, packed = 0;
  std::memcpy(&unpacked, bytes.data() + 16, 8);
  std::memcpy(&packed, bytes.data() + 24, 8);
  parts.head.resize(unpacked);
  unpack(bytes.subspan(48, packed), parts.head);
  parts.head.resize(unpacked - kSealPerPage * 2 * index.details.size());
  for (const std::vector<SvoPage>* const pages : {&index.skeletons, &index.details}) {
    for (const SvoPage& page : *pages) {
      std::vector<uint8_t>& raw = parts.pages.emplace_back(page.unpacked);
      unpack(bytes.subspan(page.offset, page.packed), raw);
    }
  }
  return parts;
}

}  // namespace sinew::test
