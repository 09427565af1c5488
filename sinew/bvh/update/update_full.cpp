// Updates of all treelets at once (`full`), and of their boxes only (`hybrid` and what `lazy`
// begins with), each followed by the upper tree.
#include <algorithm>
#include <atomic>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/update/update.h"
#include "sinew/bvh/update/update_kernels.h"
#include "sinew/bvh/update/visit.h"

namespace sinew {
namespace {

constexpr uint32_t kTreeletsPerTask = 64;
constexpr const char* kModeNames[] = {"auto", "full", "hybrid", "lazy"};

bool fits(const Bvh8Layout& layout, const Bvh8& bvh) {
  return bvh.nodes.size() == layout.children.size() && bvh.links.size() == layout.treelets.size();
}

// Sizes the buffers and writes the child words of the upper tree, which hang treelets either by
// links or by the words of their roots.
void prepare(const Bvh8Layout& layout, bool by_links, Bvh8& out) {
  const bool is_new = !fits(layout, out);
  if (is_new) {
    out.nodes = Buffer<Node8>(layout.children.size());
    out.packets = {};
    out.vertices = {};
    out.links.assign(layout.treelets.size(), kUnmade);
  }
  out.box = Box();
  if (by_links && out.vertices.size() == 0) {
    out.vertices = Buffer<vec3>(layout.vertices.size() + layout.treelets.size());
  }
  if (!by_links && out.packets.size() == 0) {
    out.packets = Buffer<TrianglePacket>(layout.packet_corners.size());
  }
  if (!is_new && out.by_links == by_links) return;
  out.by_links = by_links;
  const auto word_of = [&](uint32_t word) {
    if (by_links || word == kNoChild || !is_treelet_word(word)) return word;
    return made_word(layout.treelets[treelet_of(word)]);
  };
  for (uint32_t n = 0; n < layout.upper_nodes; ++n) {
    out.nodes[n] = empty_node();
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      out.nodes[n].child[lane] = word_of(layout.children[n][lane]);
    }
  }
  out.root = kNoChild;
  if (layout.upper_nodes > 0) out.root = inner_word(0);
  if (layout.upper_nodes == 0 && !layout.treelets.empty()) out.root = word_of(treelet_word(0));
}

// The boxes of upper nodes below upper nodes; those of treelets are there already.
void refit_upper(const Bvh8Layout& layout, Bvh8& out) {
  for (uint32_t n = layout.upper_nodes; n-- > 0;) {
    Node8& node = out.nodes[n];
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = layout.children[n][lane];
      if (is_inner_word(word)) set_lane_box(node, lane, node_box(out.nodes[word]));
    }
  }
  if (layout.upper_nodes > 0) out.box = node_box(out.nodes[0]);
}

class Timed {
 public:
  explicit Timed(WorkTime* work) {
    if (work != nullptr) part_.emplace(*work);
  }

 private:
  std::optional<WorkTime::Part> part_;
};

UpdateJob job_of(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out) {
  return {&layout, positions.data(), out.nodes.data(), out.packets.data()};
}

}  // namespace

const char* name_of(UpdateMode mode) {
  return kModeNames[static_cast<int>(mode)];
}

std::optional<UpdateMode> update_mode_named(std::string_view name) {
  for (int mode = 0; mode < 4; ++mode) {
    if (name == kModeNames[mode]) return static_cast<UpdateMode>(mode);
  }
  return std::nullopt;
}

void reserve(const Bvh8Layout& layout, Bvh8& out) {
  prepare(layout, true, out);
}

bool update_full(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out,
                 WorkTime* work) {
  SINEW_CHECK(positions.size() == layout.vertex_count);
  prepare(layout, false, out);
  const UpdateJob job = job_of(layout, positions, out);
  std::atomic<bool> finite = true;
  parallel_for(layout.treelets.size(), kTreeletsPerTask, [&](size_t begin, size_t end) {
    const Timed timed(work);
    if (!make_treelets(job, static_cast<uint32_t>(begin), static_cast<uint32_t>(end), out.box)) {
      finite.store(false, std::memory_order_relaxed);
    }
  });
  refit_upper(layout, out);
  return finite;
}

bool update_hybrid(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out,
                   WorkTime* work) {
  SINEW_CHECK(positions.size() == layout.vertex_count);
  reserve(layout, out);
  const UpdateJob job = job_of(layout, positions, out);
  std::atomic<bool> finite = true;
  const auto exact = [&](uint32_t first, std::span<Box> boxes) {
    const Timed timed(work);
    if (!treelet_boxes(job, first, boxes)) finite.store(false, std::memory_order_relaxed);
  };
  update_upper(layout, exact, Threads::all, out);
  return finite;
}

void update_upper(const Bvh8Layout& layout, TreeletBoxes box_of, Threads threads, Bvh8& out) {
  reserve(layout, out);
  std::fill(out.links.begin(), out.links.end(), kUnmade);
  const auto update = [&](size_t begin, size_t end) {
    Box boxes[kTreeletsPerTask];
    const std::span<Box> some(boxes, end - begin);
    box_of(static_cast<uint32_t>(begin), some);
    for (size_t i = 0; i < some.size(); ++i) {
      set_treelet_box(layout, static_cast<uint32_t>(begin + i), some[i], out);
    }
  };
  const size_t count = layout.treelets.size();
  if (threads == Threads::all) {
    parallel_for(count, kTreeletsPerTask, update);
  } else {
    for (size_t i = 0; i < count; i += kTreeletsPerTask) {
      update(i, std::min<size_t>(i + kTreeletsPerTask, count));
    }
  }
  refit_upper(layout, out);
}

}  // namespace sinew
