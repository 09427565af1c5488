// Files of trees. Random bytes seldom have a right size and checksum, so these are put right first;
// the file as it came is tried as well. Trees that are taken can be laid out and refit.
#include "sinew/bvh/frames/tree_file.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "fuzz.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/wide.h"

namespace {

constexpr size_t kSizeAt = 32, kHashAt = 40, kHeader = 48;  // see tree_file.h

std::vector<uint8_t> sealed(const uint8_t* data, size_t size) {
  std::vector<uint8_t> bytes(data, data + size);
  if (size < kHeader) return bytes;
  const uint64_t whole = size;
  std::memcpy(bytes.data() + kSizeAt, &whole, sizeof(whole));
  const uint64_t head = XXH3_64bits(bytes.data(), kHashAt);
  const uint64_t hash = XXH3_64bits_withSeed(bytes.data() + kHeader, size - kHeader, head);
  std::memcpy(bytes.data() + kHashAt, &hash, sizeof(hash));
  return bytes;
}

void use(const sinew::TimedTree& timed) {
  const auto count = static_cast<uint32_t>(timed.tree.primitives.size());
  sinew::fuzz::require(sinew::validate(timed.tree, count).empty(), "a tree that is none");
  const std::vector<sinew::Box> boxes(count, {sinew::vec3(0.0f), sinew::vec3(1.0f)});
  sinew::refit(timed.tree, boxes);
  const std::vector<sinew::uvec3> triangles(count, sinew::uvec3(0, 1, 2));
  sinew::fuzz::check_error(sinew::make_layout(timed.tree, timed.areas, triangles, 3));
}

void check(std::span<const uint8_t> bytes) {
  const sinew::Result<sinew::TreeFile> file = sinew::decode_trees(bytes);
  sinew::fuzz::check_error(file);
  if (!file) return;
  const std::vector<uint8_t> again = sinew::encode_trees(*file);
  sinew::fuzz::require(std::ranges::equal(again, bytes), "a file that comes back differently");
  for (const auto& body : file->bodies) {
    for (const sinew::TimedTree& tree : body) use(tree);
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  check({data, size});
  check(sealed(data, size));
  return 0;
}
