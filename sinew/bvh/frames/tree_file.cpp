#include "sinew/bvh/frames/tree_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "sinew/base/check.h"

namespace sinew {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kMagic[8] = {'s', 'i', 'n', 'e', 'w', 't', 'r', 'e'};
constexpr uint32_t kVersion = 1;
constexpr size_t kHashAt = 40;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t bodies;
  uint64_t key;
  int32_t clip;
  uint32_t unused;
  uint64_t size;
  uint64_t hash;
};
static_assert(sizeof(Header) == 48);

template <class T>
void append(std::vector<uint8_t>& out, std::span<const T> values) {
  const auto* const first = reinterpret_cast<const uint8_t*>(values.data());
  out.insert(out.end(), first, first + values.size_bytes());
}

template <class T>
void append_value(std::vector<uint8_t>& out, const T& value) {
  append(out, std::span<const T>(&value, 1));
}

uint64_t hash_of(std::span<const uint8_t> bytes) {
  const uint64_t head = XXH3_64bits(bytes.data(), kHashAt);
  return XXH3_64bits_withSeed(bytes.data() + sizeof(Header), bytes.size() - sizeof(Header), head);
}

tl::unexpected<Error> damaged(const std::string& problem) {
  return fail({ErrorKind::bad_input, "", "", problem, "make it again with `sinew optimize`"});
}

// Takes values off the front of the bytes; false if there are not as many.
class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : left_(bytes) {}

  template <class T>
  bool take(T& out) {
    if (left_.size() < sizeof(T)) return false;
    std::memcpy(&out, left_.data(), sizeof(T));
    left_ = left_.subspan(sizeof(T));
    return true;
  }
  template <class T>
  bool take(uint32_t count, std::vector<T>& out) {
    const uint64_t bytes = uint64_t{count} * sizeof(T);
    if (left_.size() < bytes) return false;
    out.resize(count);
    if (count > 0) std::memcpy(out.data(), left_.data(), bytes);  // no null pointers to memcpy()
    left_ = left_.subspan(bytes);
    return true;
  }
  size_t left() const { return left_.size(); }

 private:
  std::span<const uint8_t> left_;
};

bool take_tree(Reader& reader, uint32_t primitives, TimedTree& out) {
  uint32_t nodes = 0, unused = 0;
  return reader.take(out.begin) && reader.take(nodes) && reader.take(unused) && unused == 0 &&
         reader.take(nodes, out.tree.nodes) && reader.take(primitives, out.tree.primitives) &&
         reader.take(nodes, out.areas);
}

Result<std::vector<TimedTree>> take_body(Reader& reader) {
  uint32_t primitives = 0, count = 0;
  if (!reader.take(primitives) || !reader.take(count)) return damaged("it ends too soon");
  if (count == 0) return damaged("a body has no tree");
  std::vector<TimedTree> trees;
  for (uint32_t i = 0; i < count; ++i) {
    TimedTree tree;
    if (!take_tree(reader, primitives, tree)) return damaged("it ends too soon");
    if (const std::string problem = validate(tree.tree, primitives); !problem.empty()) {
      return damaged("a tree is damaged: " + problem);
    }
    if (!std::ranges::all_of(tree.areas, [](float area) { return area >= 0.0f; })) {
      return damaged("an area is no area");
    }
    if (!std::isfinite(tree.begin) || (i > 0 && !(tree.begin > trees.back().begin))) {
      return damaged("the times of trees do not rise");
    }
    trees.push_back(std::move(tree));
  }
  return trees;
}

}  // namespace

std::vector<uint8_t> encode_trees(const TreeFile& trees) {
  Header header = {};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kVersion;
  header.bodies = static_cast<uint32_t>(trees.bodies.size());
  header.key = trees.key;
  header.clip = trees.clip;
  std::vector<uint8_t> out;
  append_value(out, header);
  for (const std::vector<TimedTree>& body : trees.bodies) {
    SINEW_CHECK(!body.empty());
    append_value(out, static_cast<uint32_t>(body.front().tree.primitives.size()));
    append_value(out, static_cast<uint32_t>(body.size()));
    for (const TimedTree& tree : body) {
      SINEW_CHECK(tree.areas.size() == tree.tree.nodes.size());
      append_value(out, tree.begin);
      append_value(out, static_cast<uint32_t>(tree.tree.nodes.size()));
      append_value(out, uint32_t{0});
      append(out, std::span<const TreeNode>(tree.tree.nodes));
      append(out, std::span<const uint32_t>(tree.tree.primitives));
      append(out, std::span<const float>(tree.areas));
    }
  }
  header.size = out.size();
  std::memcpy(out.data(), &header, sizeof(header));
  header.hash = hash_of(out);
  std::memcpy(out.data(), &header, sizeof(header));
  return out;
}

Result<TreeFile> decode_trees(std::span<const uint8_t> bytes) {
  Header header;
  if (bytes.size() < sizeof(kMagic) || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    return damaged("this is no file of trees");
  }
  if (bytes.size() < sizeof(header)) return damaged("it ends too soon");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.version != kVersion) {
    return damaged("it is of version " + std::to_string(header.version) + ", this program reads " +
                   std::to_string(kVersion));
  }
  if (header.size != bytes.size()) {
    return damaged("it has " + std::to_string(bytes.size()) + " bytes, not " +
                   std::to_string(header.size));
  }
  if (header.hash != hash_of(bytes)) return damaged("it is damaged: its checksum does not fit");
  if (header.unused != 0) return damaged("its header holds what it should not");
  TreeFile out{.key = header.key, .clip = header.clip, .bodies = {}};
  Reader reader(bytes.subspan(sizeof(header)));
  for (uint32_t body = 0; body < header.bodies; ++body) {
    SINEW_TRY(out.bodies.emplace_back(), take_body(reader));
  }
  if (reader.left() > 0) return damaged("it has bytes after its end");
  return out;
}

}  // namespace sinew
