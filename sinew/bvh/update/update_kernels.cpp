// Makes treelets: packs their triangles' vertices and computes their boxes, bottom-up.
// Differs from a textbook refit in that a node's eight child boxes are written together, and in
// that the unit of work is a treelet, so it can be done eagerly by many threads or on a ray's first
// visit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/update/update_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/bvh/update/update_kernels.h"
#include "sinew/bvh/pack-inl.h"

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

// Finds values that are not finite: such a value times 0 is NaN and stays in the sum.
struct FiniteCheck {
  V4 sum;

  HWY_INLINE FiniteCheck() : sum(hn::Zero(D4())) {}
  HWY_INLINE void add(V4 row) { sum = hn::Add(sum, hn::Mul(row, hn::Zero(D4()))); }
  HWY_INLINE bool holds() const {  // of the rows' first three values
    const D4 d;
    alignas(16) float values[4];
    hn::Store(sum, d, values);
    return values[0] + values[1] + values[2] == 0.0f;
  }
};

// A vertex as four floats. The fourth belongs to the next vertex; the last of all has none.
HWY_INLINE V4 load_vertex(const UpdateJob& job, uint32_t vertex) {
  const D4 d;
  if (HWY_LIKELY(vertex + 1 < job.layout->vertex_count)) {
    return hn::LoadU(d, &job.positions[vertex].x);
  }
  const vec3 p = job.positions[vertex];
  alignas(16) const float padded[4] = {p.x, p.y, p.z, 0.0f};
  return hn::Load(d, padded);
}

// Copies a treelet's vertices to `at`, four floats each, so that the next covers the fourth.
HWY_INLINE void gather(const UpdateJob& job, const Treelet& treelet, TreeletVertices& at,
                       FiniteCheck& finite) {
  const uint32_t* const vertices = job.layout->vertices.data() + treelet.first_vertex;
  for (uint32_t i = 0; i < treelet.vertex_count; ++i) {
    const V4 row = load_vertex(job, vertices[i]);
    finite.add(row);
    hn::StoreU(row, D4(), &at[i].x);
  }
}

HWY_INLINE void extend(const PacketCorners& corners, const vec3* at, RowBox& box) {
  for (const auto& lane : corners.v) {
    for (const uint8_t corner : lane) box.extend(hn::LoadU(D4(), &at[corner].x));
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
HWY_INLINE RowBox children_box(const Node8& node) {
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

template <bool kPack>
HWY_INLINE RowBox make_leaf(const UpdateJob& job, const vec3* at, uint32_t word) {
  RowBox box;
  const uint32_t first = leaf_first(word);
  for (uint32_t p = first; p < first + leaf_packets(word); ++p) {
    const PacketCorners& corners = job.layout->packet_corners[p];
    if (kPack) pack_triangles(corners, at, job.packets[p]);
    extend(corners, at, box);
  }
  return box;
}

template <bool kPack>
HWY_INLINE RowBox make(const UpdateJob& job, const Treelet& treelet, const vec3* at) {
  if (treelet.node_count == 0) return make_leaf<kPack>(job, at, made_word(treelet));
  // Children stand after their parents, so backwards is bottom-up.
  for (uint32_t n = treelet.first_node + treelet.node_count; n-- > treelet.first_node;) {
    Node8& node = job.nodes[n];
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = job.layout->children[n][lane];
      node.child[lane] = word;
      node.unused[lane] = 0;
      RowBox box;
      if (word != kNoChild) {
        box = is_leaf_word(word) ? make_leaf<kPack>(job, at, word) : children_box(job.nodes[word]);
      }
      store_lane(box, node, lane);
    }
  }
  return children_box(job.nodes[treelet.first_node]);
}

HWY_INLINE Box to_box(const RowBox& box) {
  const D4 d;
  alignas(16) float low[4], high[4];
  hn::Store(box.low, d, low);
  hn::Store(box.high, d, high);
  return {vec3(low[0], low[1], low[2]), vec3(high[0], high[1], high[2])};
}

bool make_treelets_kernel(const UpdateJob& job, uint32_t begin, uint32_t end, Box& root_box) {
  TreeletVertices at;
  FiniteCheck finite;
  for (uint32_t t = begin; t < end; ++t) {
    const Treelet& treelet = job.layout->treelets[t];
    gather(job, treelet, at, finite);
    const RowBox box = make<true>(job, treelet, at.data());
    if (job.layout->upper_nodes > 0) {
      store_lane(box, job.nodes[treelet.parent_node], treelet.parent_lane);
    } else {
      root_box = to_box(box);
    }
  }
  return finite.holds();
}

void make_treelet_kernel(const UpdateJob& job, uint32_t treelet, const vec3* at) {
  make<false>(job, job.layout->treelets[treelet], at);
}

void pack_treelet_kernel(const Bvh8Layout& layout, uint32_t treelet, const TreeletVertices& at,
                         TrianglePacket* out) {
  const Treelet& t = layout.treelets[treelet];
  for (uint32_t p = 0; p < t.packet_count; ++p) {
    pack_triangles(layout.packet_corners[t.first_packet + p], at.data(), out[p]);
  }
}

bool treelet_boxes_kernel(const UpdateJob& job, uint32_t begin, Box* out, size_t count) {
  FiniteCheck finite;
  for (size_t i = 0; i < count; ++i) {
    const Treelet& treelet = job.layout->treelets[begin + i];
    const uint32_t* const vertices = job.layout->vertices.data() + treelet.first_vertex;
    RowBox box;
    for (uint32_t k = 0; k < treelet.vertex_count; ++k) {
      const V4 row = load_vertex(job, vertices[k]);
      box.extend(row);
      finite.add(row);
    }
    out[i] = to_box(box);
  }
  return finite.holds();
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(make_treelets_kernel);
HWY_EXPORT(make_treelet_kernel);
HWY_EXPORT(pack_treelet_kernel);
HWY_EXPORT(treelet_boxes_kernel);

bool make_treelets(const UpdateJob& job, uint32_t begin, uint32_t end, Box& root_box) {
  return HWY_DYNAMIC_DISPATCH(make_treelets_kernel)(job, begin, end, root_box);
}

void make_treelet(const UpdateJob& job, uint32_t treelet, const vec3* at) {
  HWY_DYNAMIC_DISPATCH(make_treelet_kernel)(job, treelet, at);
}

void pack_treelet(const Bvh8Layout& layout, uint32_t treelet, const TreeletVertices& at,
                  TrianglePacket* out) {
  HWY_DYNAMIC_DISPATCH(pack_treelet_kernel)(layout, treelet, at, out);
}

bool treelet_boxes(const UpdateJob& job, uint32_t begin, std::span<Box> out) {
  return HWY_DYNAMIC_DISPATCH(treelet_boxes_kernel)(job, begin, out.data(), out.size());
}

}  // namespace sinew
#endif
