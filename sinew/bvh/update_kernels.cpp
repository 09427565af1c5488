// Makes treelets: packs their triangles' vertices and computes their boxes, bottom-up.
// Differs from a textbook refit in that a node's eight child boxes are written together, and in
// that the unit of work is a treelet, so it can be done eagerly by many threads or on a ray's first
// visit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/update_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/bvh/update_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;

// A box whose rows are (x, y, z, anything).
struct RowBox {
  V4 low, high;

  // Written out: an implicit constructor would not be compiled for the target.
  HWY_INLINE RowBox()
      : low(hn::Set(D4(), __builtin_inff())), high(hn::Set(D4(), -__builtin_inff())) {}

  // The new row comes first: where it is NaN, x86's min and max keep the second operand.
  void extend(V4 row) {
    low = hn::Min(row, low);
    high = hn::Max(row, high);
  }
};

// Loads vertices as four floats. The fourth belongs to the next vertex; the last vertex of all has
// none, so it is read from a padded copy.
class VertexReader {
 public:
  VertexReader(const vec3* positions, uint32_t count) : positions_(positions), last_(count - 1) {
    for (int axis = 0; axis < 3; ++axis) padded_[axis] = positions[last_][axis];
  }
  V4 load(uint32_t vertex) const {
    return hn::LoadU(D4(), vertex == last_ ? padded_ : &positions_[vertex].x);
  }

 private:
  const vec3* positions_;
  uint32_t last_;
  alignas(16) float padded_[4] = {};
};

// Packs four triangles and extends the box by them.
HWY_INLINE void pack(const PacketVertices& vertices, const VertexReader& reader,
                     TrianglePacket& out, RowBox& box) {
  const D4 d;
  for (int corner = 0; corner < 3; ++corner) {
    const V4 a = reader.load(vertices.v[0][corner]);
    const V4 b = reader.load(vertices.v[1][corner]);
    const V4 c = reader.load(vertices.v[2][corner]);
    const V4 e = reader.load(vertices.v[3][corner]);
    box.extend(a);
    box.extend(b);
    box.extend(c);
    box.extend(e);
    const V4 ac_low = hn::InterleaveLower(d, a, c), ac_high = hn::InterleaveUpper(d, a, c);
    const V4 be_low = hn::InterleaveLower(d, b, e), be_high = hn::InterleaveUpper(d, b, e);
    hn::Store(hn::InterleaveLower(d, ac_low, be_low), d, out.v[corner][0]);
    hn::Store(hn::InterleaveUpper(d, ac_low, be_low), d, out.v[corner][1]);
    hn::Store(hn::InterleaveLower(d, ac_high, be_high), d, out.v[corner][2]);
  }
}

HWY_INLINE void store_lane(const RowBox& box, Node8& node, uint32_t lane) {
  const D4 d;
  alignas(16) float low[4], high[4];
  hn::Store(box.low, d, low);
  hn::Store(box.high, d, high);
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][lane] = low[axis];
    node.high[axis][lane] = high[axis];
  }
}

// Union of a node's eight child boxes; absent children are empty and change nothing.
HWY_INLINE RowBox node_box(const Node8& node) {
  const D4 d;
  alignas(16) float low[4] = {}, high[4] = {};
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = hn::GetLane(
        hn::MinOfLanes(d, hn::Min(hn::Load(d, node.low[axis]), hn::Load(d, node.low[axis] + 4))));
    high[axis] = hn::GetLane(
        hn::MaxOfLanes(d, hn::Max(hn::Load(d, node.high[axis]), hn::Load(d, node.high[axis] + 4))));
  }
  RowBox box;
  box.low = hn::Load(d, low);
  box.high = hn::Load(d, high);
  return box;
}

HWY_INLINE RowBox pack_leaf(const UpdateJob& job, const VertexReader& reader, uint32_t word) {
  RowBox box;
  const uint32_t first = leaf_first(word);
  for (uint32_t p = first; p < first + leaf_packets(word); ++p) {
    pack(job.packet_vertices[p], reader, job.packets[p], box);
  }
  return box;
}

void make_treelets_kernel(const UpdateJob& job, uint32_t begin, uint32_t end) {
  const VertexReader reader(job.positions, job.vertex_count);
  for (uint32_t t = begin; t < end; ++t) {
    const Treelet& treelet = job.treelets[t];
    RowBox box;
    if (treelet.node_count == 0) box = pack_leaf(job, reader, made_word(treelet));
    // Children stand after their parents, so backwards is bottom-up.
    for (uint32_t n = treelet.first_node + treelet.node_count; n-- > treelet.first_node;) {
      Node8& node = job.nodes[n];
      for (uint32_t lane = 0; lane < kWidth; ++lane) {
        const uint32_t word = node.child[lane];
        if (word == kNoChild) break;  // absent children stand last
        store_lane(is_leaf_word(word) ? pack_leaf(job, reader, word) : node_box(job.nodes[word]),
                   node, lane);
      }
    }
    if (treelet.node_count > 0) box = node_box(job.nodes[treelet.first_node]);
    if (job.upper_nodes > 0) {
      store_lane(box, job.nodes[treelet.parent_node], treelet.parent_lane);
    } else {
      const D4 d;
      alignas(16) float low[4], high[4];
      hn::Store(box.low, d, low);
      hn::Store(box.high, d, high);
      *job.root_box = {vec3(low[0], low[1], low[2]), vec3(high[0], high[1], high[2])};
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(make_treelets_kernel);

void make_treelets(const UpdateJob& job, uint32_t begin, uint32_t end) {
  HWY_DYNAMIC_DISPATCH(make_treelets_kernel)(job, begin, end);
}

}  // namespace sinew
#endif
