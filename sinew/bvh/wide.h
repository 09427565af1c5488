// Bvh8: the traced layout. Eight children a node, four triangles a packet, cut into treelets.
//
//   Layout (constant)                     Bvh8 (one a pose)
//   ------------------------------       --------------------------------
//   children of every node                nodes:   8 boxes + 8 child words
//   triangles and corners of packets      packets: 4 triangles as vertices
//   treelets: which nodes, packets        links:   what is made of every treelet
//             and vertices
//
//                 [0 root]                        nodes [0, upper_nodes) are the upper tree
//                /   |    \                       (parents before children);
//            [1]    [2]   (treelet 0)             then each treelet's nodes and packets stand
//            / \      \                           together, its root first:
//   (treelet 1) ...  (treelet 2)
//                                                 nodes   | upper | t0 ...... | t1 .. | t2 ....
//                                                 packets         | t0 .. | t1 .... | t2 .
//
// A treelet is the unit that updates make: everything inside depends only on the positions of its
// own vertices. A child word says what hangs below a box:
//
//   31 30 29 ............................ 0
//    0  index of an inner node
//    1  0  first packet << 3 | packets - 1  a leaf: 1 to 8 packets
//    1  1  index of a treelet, which is looked up in `links` (traverse.h); in trees that are made
//          as a whole, treelets are linked by the words of their roots instead
//   0xffffffff                              no child; its box is empty, so no ray enters
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/buffer.h"
#include "sinew/base/error.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/tree.h"
#include "sinew/math/vec.h"

namespace sinew {

inline constexpr uint32_t kWidth = 8;   // children of a node
inline constexpr uint32_t kPacket = 4;  // triangles in a packet
inline constexpr uint32_t kNoChild = 0xffffffffu;
inline constexpr uint32_t kLeafBit = 0x80000000u;
inline constexpr uint32_t kTreeletBits = 0xc0000000u;
inline constexpr uint32_t kMaxLeafPackets = 8;
inline constexpr uint32_t kMaxPackets = 1u << 27;     // what a leaf word can address
inline constexpr uint32_t kTreeletTriangles = 64;     // in a treelet at most, unless told otherwise
inline constexpr uint32_t kMaxTreeletTriangles = 85;  // so that a byte numbers their vertices
inline constexpr uint32_t kMaxTreeletVertices = 255;
inline constexpr uint32_t kMaxDepth = 80;  // nodes from a root to a leaf; sizes the stacks
inline constexpr uint32_t kNoPrimitive = 0xffffffffu;

// Boxes as structure of arrays, so one SIMD test takes all eight.
struct alignas(64) Node8 {
  float low[3][kWidth];  // x, y, z
  float high[3][kWidth];
  uint32_t child[kWidth];  // child words
  uint32_t unused[kWidth];
};
static_assert(sizeof(Node8) == 256);

Node8 empty_node();

// The box of child number `lane`.
inline Box lane_box(const Node8& node, uint32_t lane) {
  return {vec3(node.low[0][lane], node.low[1][lane], node.low[2][lane]),
          vec3(node.high[0][lane], node.high[1][lane], node.high[2][lane])};
}
inline void set_lane_box(Node8& node, uint32_t lane, const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][lane] = box.min[axis];
    node.high[axis][lane] = box.max[axis];
  }
}

// Triangles as vertices, not edges, so neighbours share exact corners (watertight). Unused lanes
// repeat lane 0's triangle.
struct alignas(16) TrianglePacket {
  float v[3][3][kPacket];  // [corner][axis][lane]
};
static_assert(sizeof(TrianglePacket) == 144);

struct Treelet {
  uint32_t first_node = 0;
  uint32_t node_count = 0;  // 0: the treelet is a single leaf
  uint32_t first_packet = 0;
  uint32_t packet_count = 0;
  uint32_t first_vertex = 0;  // in Bvh8Layout::vertices
  uint32_t vertex_count = 0;
  uint32_t parent_node = 0;  // whose box and child word number `parent_lane` are this treelet's;
  uint32_t parent_lane = 0;  // without meaning if the layout has no upper nodes
};
static_assert(sizeof(Treelet) == 32);

inline constexpr uint32_t inner_word(uint32_t node) {
  return node;
}
inline constexpr uint32_t leaf_word(uint32_t first_packet, uint32_t packets) {
  return kLeafBit | first_packet << 3 | (packets - 1);
}
inline constexpr uint32_t treelet_word(uint32_t treelet) {
  return kTreeletBits | treelet;
}
inline constexpr bool is_inner_word(uint32_t word) {
  return (word & kLeafBit) == 0;
}
inline constexpr bool is_leaf_word(uint32_t word) {
  return (word >> 30) == 2;
}
inline constexpr bool is_treelet_word(uint32_t word) {  // of a word that is not kNoChild
  return word >= kTreeletBits;
}
inline constexpr uint32_t treelet_of(uint32_t word) {
  return word & ~kTreeletBits;
}
inline constexpr uint32_t leaf_first(uint32_t word) {
  return (word & ~kLeafBit) >> 3;
}
inline constexpr uint32_t leaf_packets(uint32_t word) {
  return (word & 7u) + 1;
}

// How the treelet is linked once it is made.
inline uint32_t made_word(const Treelet& t) {
  return t.node_count > 0 ? inner_word(t.first_node) : leaf_word(t.first_packet, t.packet_count);
}

// The corners of a packet's triangles, as numbers within their treelet's vertices.
struct PacketCorners {
  uint8_t v[kPacket][3];  // [lane][corner]
  uint32_t place = 0;     // of the treelet's vertices, see place_of()
};
static_assert(sizeof(PacketCorners) == 16);
using PacketPrimitives = std::array<uint32_t, kPacket>;  // kNoPrimitive: an unused lane

// What stays the same while the body moves.
struct Bvh8Layout {
  uint32_t upper_nodes = 0;  // 0: the whole body is treelet 0 (or nothing)
  std::vector<std::array<uint32_t, kWidth>> children;  // of every node; treelets by treelet word
  std::vector<PacketCorners> packet_corners;
  std::vector<PacketPrimitives> packet_primitives;
  std::vector<Treelet> treelets;
  std::vector<uint32_t> vertices;  // of every treelet, each once: indices of the body's
  uint32_t depth = 0;              // nodes on the longest path
  uint32_t vertex_count = 0;
  uint32_t triangle_count = 0;
};

// Where the vertices of a treelet stand in Bvh8::vertices: there is one place more than vertices
// between treelets, because they are read four floats at a time.
inline uint32_t place_of(const Bvh8Layout& layout, uint32_t treelet) {
  return layout.treelets[treelet].first_vertex + treelet;
}

// What one pose looks like. Linear buffers, indices only. Every treelet has its place in them;
// pages of treelets that were never made are never touched. Trees that are made as a whole hold
// packed triangles. Treelets that hang by links hold their vertices instead, a fraction of the
// bytes, and rays pack what they test.
struct Bvh8 {
  Buffer<Node8> nodes;
  Buffer<TrianglePacket> packets;
  Buffer<vec3> vertices;
  std::vector<uint32_t> links;  // one a treelet, see visit.h; atomic while rays are traced
  uint32_t root = kNoChild;     // child word of the whole
  bool by_links = false;        // treelets hang by treelet words, not by the words of their roots
  Box box;                      // of everything; empty if there is nothing
};

Box node_box(const Node8& node);  // of all its children

// Bytes of nodes, packed triangles and treelets: of what is constant, and of one pose with
// everything made.
size_t bytes_of(const Bvh8Layout& layout);
size_t bytes_of(const Bvh8& bvh);

// Collapses the tree into eight-wide nodes, the children of largest area first, and cuts it into
// treelets of at most `treelet_triangles` (1 to kMaxTreeletTriangles). `areas`: one a node, of one
// frame or a weighted sum over several.
Result<Bvh8Layout> make_layout(const Tree& tree, std::span<const float> areas,
                               std::span<const uvec3> triangles, uint32_t vertex_count,
                               uint32_t treelet_triangles = kTreeletTriangles);

// An error if a triangle refers to a vertex that does not exist.
Result<void> check_triangles(std::span<const uvec3> triangles, size_t vertex_count);

// From triangles to a layout in one step: binned SAH over `positions`, then make_layout. Triangles
// that are not finite there get a place all the same, for they may be finite later. Errors: those
// of check_triangles().
Result<Bvh8Layout> build_layout(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                const BuildConfig& config);

// Structure, child words, containment of every box, and equality of packed vertices with
// `positions`. Empty text if all hold, else what is wrong and where.
std::string validate(const Bvh8Layout& layout, const Bvh8& bvh, std::span<const vec3> positions,
                     std::span<const uvec3> triangles);

}  // namespace sinew
