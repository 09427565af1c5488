#include "sinew/svo/make/make_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "sinew/base/memory_use.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/make/block_ranges.h"
#include "sinew/svo/make/lattice.h"
#include "sinew/svo/make/node_rows.h"

namespace sinew {
namespace {

// Memory that a fragment takes at the worst moment, in bytes, by measurement with a margin: of a
// run's own blocks from fragments to packed pages that are read again; of those around, fragments
// and sheets.
constexpr uint64_t kOwnBytes = 64, kBorderBytes = 44;
// What morph targets add, a fragment: two corners a cell of 64 voxels, each thrice.
constexpr double kTargetBytes = 0.5;
constexpr uint64_t kBlockBytes = 32 << 10;   // of a block beside
constexpr uint64_t kThreadBytes = 16 << 20;  // of a thread: what it marks and packs
constexpr uint64_t kInsideBytes = 48;        // of a voxel of solid filling

// Blocks [begin, end) of SurfaceVoxelizer::blocks().
struct Run {
  uint32_t begin = 0, end = 0;
};

class PartsMaker {
 public:
  PartsMaker(SurfaceVoxelizer& surface, const SvoSource& source, const SvoPartsOptions& options)
      : surface_(surface),
        codes_(surface.blocks()),
        source_(source),
        options_(options),
        budget_(options.memory - std::min(options.memory, options.standing)),
        lattice_(lattice_source(surface.grid(), source)) {}

  Result<SvoPartsMade> run() {
    SINEW_CHECKED(check_grid(surface_.grid()));
    SINEW_CHECKED(check_source(source_));
    if (surface_.solid()) return make_whole();
    units_ = delta_units(lattice_);
    SINEW_CHECKED(list_runs());
    for (const Run& run : runs_) {
      if (!go_on(run.begin)) return ended();
      SINEW_CHECKED(make_part(run));
      return_free_memory();
    }
    if (made_.outline.blocks.empty()) return bad_voxels("there are no voxels");
    return finish();
  }

 private:
  bool go_on(size_t done) const {
    return !options_.on_part || options_.on_part(done, codes_.size());
  }
  static tl::unexpected<Error> ended() {
    return fail({ErrorKind::runtime, "", "", "voxelising was ended", ""});
  }

  tl::unexpected<Error> no_memory(uint64_t needed, const char* what) const {
    const uint64_t least = (needed + options_.standing + (2 << 20) - 1) >> 20;
    return fail({ErrorKind::runtime, "", "",
                 fmt::format("more memory than {} MiB is needed for {}: {} MiB at least",
                             options_.memory >> 20, what, least),
                 fmt::format("give --memory-limit {}M or more, or make voxels larger", least)});
  }

  // Calls take(i) for the blocks that touch blocks()[block], over faces, edges or corners.
  template <class Take>
  void for_each_around(uint32_t block, const Take& take) const {
    const glm::ivec3 place(voxel_of(codes_[block]));
    for (int i = 0; i < 27; ++i) {
      const glm::ivec3 at = place + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (i == 13 || glm::any(glm::lessThan(at, glm::ivec3(0)))) continue;
      const auto code = static_cast<uint32_t>(morton_of(uvec3(at)));
      const auto found = std::ranges::lower_bound(codes_, code);
      if (found != codes_.end() && *found == code) {
        take(static_cast<uint32_t>(found - codes_.begin()));
      }
    }
  }

  uint64_t own_cost(uint32_t block) const {
    const auto deltas = static_cast<uint64_t>(kTargetBytes * lattice_.targets);
    return (kOwnBytes + deltas) * counts_[block] + kBlockBytes;
  }
  uint64_t border_cost(uint32_t block) const { return kBorderBytes * counts_[block] + kBlockBytes; }

  // As few runs as the memory allows, from the front.
  Result<void> list_runs() {
    counts_ = surface_.most_fragments();
    made_.fragments = std::accumulate(counts_.begin(), counts_.end(), uint64_t{0});
    const uint64_t fixed = kThreadBytes * static_cast<uint64_t>(thread_count());
    std::vector<uint32_t> run_of(counts_.size(), 0);  // 1 + the last run that counts the block
    uint64_t cost = fixed, least = 0;
    for (uint32_t b = 0; b < counts_.size(); ++b) {
      uint64_t alone = fixed + own_cost(b);
      for_each_around(b, [&](uint32_t i) { alone += border_cost(i); });
      least = std::max(least, alone);
      const auto number = [&] { return static_cast<uint32_t>(runs_.size()); };
      if (!runs_.empty()) {
        uint64_t next = cost + own_cost(b) - (run_of[b] == number() ? border_cost(b) : 0);
        for_each_around(b, [&](uint32_t i) {
          if (run_of[i] != number()) next += border_cost(i);
        });
        if (next <= budget_) {
          cost = next;
          runs_.back().end = b + 1;
        }
      }
      if (runs_.empty() || runs_.back().end != b + 1) {
        runs_.push_back({b, b + 1});
        cost = alone;
      }
      run_of[b] = number();
      for_each_around(b, [&](uint32_t i) { run_of[i] = number(); });
    }
    if (least > budget_) return no_memory(least, "one block of voxels and those around");
    return {};
  }

  std::vector<uint32_t> with_border(const Run& run) const {
    std::vector<uint32_t> blocks;
    for (uint32_t b = run.begin; b < run.end; ++b) {
      blocks.push_back(b);
      for_each_around(b, [&](uint32_t i) { blocks.push_back(i); });
    }
    std::ranges::sort(blocks);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    return blocks;
  }

  Result<void> make_part(const Run& run) {
    const auto is_own = [&](uint64_t morton) {
      return morton >= codes_[run.begin] && morton <= codes_[run.end - 1];
    };
    std::vector<BlockPart> parts;
    std::vector<BlockSheets> sheets;
    std::vector<size_t> own;  // into sheets
    {
      SINEW_TRY(const VoxelSurface surface, surface_.some(with_border(run)));
      const std::span<const VoxelFragment> fragments = surface.fragments;
      const std::vector<size_t> first = first_of_blocks(fragments);
      sheets.resize(first.size() - 1);
      for (size_t b = 0; b < sheets.size(); ++b) {
        if (is_own(fragments[first[b]].voxel >> (3 * kBlockLevel))) own.push_back(b);
      }
      parts.resize(own.size());
      parallel_for(sheets.size(), 1, [&](size_t begin, size_t end) {
        for (size_t b = begin; b < end; ++b) {
          const auto block = fragments.subspan(first[b], first[b + 1] - first[b]);
          const auto place = std::ranges::lower_bound(own, b);
          BlockPart unused;
          const bool is_part = place != own.end() && *place == b;
          make_sheets(lattice_, block, false, sheets[b],
                      is_part ? parts[static_cast<size_t>(place - own.begin())] : unused);
        }
      });
    }
    if (own.empty()) return {};
    parallel_for(own.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        make_corners(lattice_, sheets, own[i], units_, parts[i]);
      }
    });
    sheets = {};
    rows_.add(parts);
    SINEW_TRY(const Svo part, join_parts(frame_of(lattice_, units_), parts));
    parts = {};
    return_free_memory();
    SINEW_CHECKED(add_to_outline(part));
    return options_.take(part);
  }

  // Blocks, behind those that are there; and what of the memory is not in the outline.
  Result<void> add_to_outline(const Svo& part) {
    std::vector<SvoBlock>& blocks = made_.outline.blocks;
    SvoBlock at = blocks.empty() ? SvoBlock{} : blocks.back();
    if (!blocks.empty()) blocks.pop_back();
    const SvoBlock& end = part.blocks.back();
    deltas_ += part.deltas.size();
    for (const uint64_t sum :
         {uint64_t{at.first_cell} + end.first_cell, uint64_t{at.first_corner} + end.first_corner,
          uint64_t{at.first_brick} + end.first_brick, uint64_t{at.first_voxel} + end.first_voxel,
          uint64_t{at.first_joint} + end.first_joint, uint64_t{at.first_target} + end.first_target,
          deltas_}) {
      if (sum > 0xffffffffu) return too_large("voxels", "choose a lower resolution");
    }
    for (SvoBlock block : part.blocks) {
      block.first_cell += at.first_cell;
      block.first_corner += at.first_corner;
      block.first_brick += at.first_brick;
      block.first_voxel += at.first_voxel;
      block.first_joint += at.first_joint;
      block.first_target += at.first_target;
      blocks.push_back(block);
    }
    Svo frame;  // what every part has anew
    frame.nodes = part.nodes;
    frame.node_level = part.node_level;
    frame.blocks = part.blocks;
    frame.morph_weights = part.morph_weights;
    made_.bytes += part.bytes() - frame.bytes();
    ++made_.parts;
    Svo& outline = made_.outline;
    outline.grid = part.grid;
    outline.joints = part.joints;
    outline.morph_targets = part.morph_targets;
    outline.morph_weights = part.morph_weights;
    outline.root_level = part.root_level;
    return {};
  }

  Result<SvoPartsMade> finish() {
    rows_.finish(made_.outline);
    const Svo& outline = made_.outline;
    if (outline.nodes.size() + outline.blocks.back().first_cell > kMostUnits) {
      return too_large("cells", "choose a lower resolution");
    }
    made_.bytes += outline.bytes();
    return std::move(made_);
  }

  Result<SvoPartsMade> make_whole() {
    if (!go_on(0)) return ended();
    SINEW_TRY(VoxelSurface surface, surface_.all());
    const uint64_t needed = kInsideBytes * surface.fragments.size();
    if (needed > budget_) return no_memory(needed, "a solid, which is made as a whole");
    SINEW_TRY(Svo whole, make_svo(surface, source_));
    made_.fragments = surface.fragments.size();
    made_.parts = 1;
    made_.bytes = whole.bytes();
    surface = {};
    SINEW_CHECKED(options_.take(whole));
    Svo& outline = made_.outline;
    outline.grid = whole.grid;
    outline.joints = whole.joints;
    outline.morph_targets = whole.morph_targets;
    outline.morph_weights = std::move(whole.morph_weights);
    outline.root_level = whole.root_level;
    outline.nodes = std::move(whole.nodes);
    outline.node_level = std::move(whole.node_level);
    outline.blocks = std::move(whole.blocks);
    return std::move(made_);
  }

  SurfaceVoxelizer& surface_;
  std::span<const uint32_t> codes_;
  const SvoSource& source_;
  const SvoPartsOptions& options_;
  uint64_t budget_;
  LatticeSource lattice_;
  std::vector<float> units_;
  std::vector<uint64_t> counts_;  // fragments, one a block
  std::vector<Run> runs_;
  NodeRows rows_;
  uint64_t deltas_ = 0;
  SvoPartsMade made_;
};

}  // namespace

Result<SvoPartsMade> make_svo_by_parts(SurfaceVoxelizer& surface, const SvoSource& source,
                                       const SvoPartsOptions& options) {
  return PartsMaker(surface, source, options).run();
}

}  // namespace sinew
