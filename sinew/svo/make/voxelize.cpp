#include "sinew/svo/make/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>
#include <mutex>
#include <numeric>

#include "sinew/base/buffer.h"
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/make/nearest_kernels.h"
#include "sinew/svo/make/solid_fill.h"
#include "sinew/svo/make/voxelize_triangle.h"

namespace sinew {
namespace {

using glm::dvec3;

constexpr uint32_t kSide = kBlockSide;
constexpr uint32_t kPlaceBits = 3 * kBlockLevel;  // of a voxel within its block
constexpr uint32_t kBlockVoxels = 1u << kPlaceBits;
constexpr size_t kTrianglesAtOnce = 8192;

// (0, 0, x) of a Morton code of 6 bits an axis.
constexpr std::array<uint32_t, kSide> kSpread = [] {
  std::array<uint32_t, kSide> table{};
  for (uint32_t i = 0; i < kSide; ++i) {
    for (uint32_t bit = 0; bit < kBlockLevel; ++bit) table[i] |= (i >> bit & 1) << (3 * bit);
  }
  return table;
}();

uint32_t morton_of_place(BlockPlace place) {
  return kSpread[place & 63] | kSpread[place >> 6 & 63] << 1 | kSpread[place >> 12] << 2;
}

struct BlockTriangle {
  uint32_t block = 0;  // Morton code, in blocks
  uint32_t triangle = 0;
};

// The triangles [first, end) of the sorted list lie in the block.
struct BlockRange {
  uint32_t block = 0;
  size_t first = 0, end = 0;
};

bool is_finite(vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Buffers of one block's work, for what a triangle has there and for all that the block has.
struct Scratch {
  Buffer<BlockPlace> places{kMostPlaces};
  Buffer<float> u{kMostPlaces}, v{kMostPlaces};
  Buffer<uint16_t> normals{kMostPlaces}, colors{kMostPlaces};
  Buffer<uint8_t> present{kMostPlaces};
  std::vector<VoxelFragment> fragments, sorted;  // never made shorter, so that nothing is cleared
  size_t count = 0;                              // of fragments

  // The next `more` fragments, to be written.
  VoxelFragment* room_for(size_t more) {
    if (fragments.size() < count + more) fragments.resize(2 * (count + more));
    if (sorted.size() < fragments.size()) sorted.resize(fragments.size());
    return fragments.data() + count;
  }
};

// By 9 bits of the voxel's place, keeping the order of equals.
void sort_by_bits(std::span<const VoxelFragment> from, VoxelFragment* to, uint32_t shift) {
  uint32_t next[512] = {};
  for (const VoxelFragment& f : from) ++next[f.voxel >> shift & 511];
  uint32_t sum = 0;
  for (uint32_t& n : next) sum += std::exchange(n, sum);
  for (const VoxelFragment& f : from) to[next[f.voxel >> shift & 511]++] = f;
}

class Voxelizer {
 public:
  Voxelizer(std::span<const vec3> positions, std::span<const uvec3> triangles,
            const VoxelGrid& grid, LookFunction look, const VoxelizeOptions& options)
      : positions_(positions), triangles_(triangles), grid_(grid), look_(look), options_(options) {
    blocks_.count = (grid.resolution + kSide - 1u) / kSide;
    sort_triangles();
  }

  std::span<const uint32_t> blocks() const { return codes_; }

  std::vector<uint64_t> most_fragments() {
    std::vector<uint64_t> counts(all_.size(), 0);
    parallel_for(counts.size(), 1, [&](size_t begin, size_t end) {
      std::unique_ptr<Scratch> scratch = take_scratch();
      for (size_t i = begin; i < end; ++i) {
        for_each_marked(all_[i], scratch->places,
                        [&](uint32_t, const GridTriangle&, size_t count) { counts[i] += count; });
      }
      const std::lock_guard lock(mutex_);
      idle_.push_back(std::move(scratch));
    });
    idle_.clear();
    return counts;
  }

  // `which`: into blocks().
  Result<VoxelSurface> run(std::span<const uint32_t> which) {
    ranges_.clear();
    for (const uint32_t i : which) ranges_.push_back(all_[i]);
    outputs_.clear();
    memory_ = 0;
    mark_blocks();
    if (options_.solid && !out_of_memory_) fill();
    if (out_of_memory_) return no_memory();
    return join();
  }

 private:
  // A block's part of the result.
  struct BlockOutput {
    std::vector<VoxelFragment> fragments;
    int32_t slot = kNoShell;  // in inside_, of solids
    uint64_t count = 0;       // fragments, those of the filling included
    uint64_t voxels = 0;
  };

  dvec3 in_voxels(vec3 p) const {
    return (dvec3(p) - dvec3(grid_.origin)) / static_cast<double>(grid_.voxel);
  }

  // In voxels from the grid's origin. False if the triangle is none.
  bool load(uint32_t triangle, GridTriangle& out) const {
    for (int k = 0; k < 3; ++k) {
      const vec3 p = positions_[triangles_[triangle][k]];
      if (!is_finite(p)) return false;
      out.vertex[k] = in_voxels(p);
    }
    return cross(out.vertex[1] - out.vertex[0], out.vertex[2] - out.vertex[0]) != dvec3(0.0);
  }

  void list_blocks(uint32_t triangle, Buffer<BlockPlace>& places,
                   std::vector<BlockTriangle>& out) const {
    GridTriangle t;
    if (!load(triangle, t)) return;
    // A grid of blocks is no larger than a block of voxels.
    for (dvec3& v : t.vertex) v /= static_cast<double>(kSide);
    const dvec3 low = floor(min(t.vertex[0], min(t.vertex[1], t.vertex[2])));
    const dvec3 high = floor(max(t.vertex[0], max(t.vertex[1], t.vertex[2])));
    const bool in_one =
        low == high && all(greaterThan(min(t.vertex[0], min(t.vertex[1], t.vertex[2])), low));
    if (in_one) {
      if (any(lessThan(low, dvec3(0.0))) || any(greaterThanEqual(low, dvec3(blocks_.count))))
        return;
      const uvec3 block(low);
      const BlockPlace place = block.x + kSide * (block.y + kSide * block.z);
      out.push_back({morton_of_place(place), triangle});
    } else {
      const size_t count = mark_triangle(t, Shell::conservative, blocks_.count - 1u, places.data());
      for (size_t i = 0; i < count; ++i) out.push_back({morton_of_place(places[i]), triangle});
    }
  }

  // Fills all_, codes_ and sorted_: by block, then triangle.
  void sort_triangles() {
    std::vector<std::vector<BlockTriangle>> lists((triangles_.size() + kTrianglesAtOnce - 1) /
                                                  kTrianglesAtOnce);
    parallel_for(triangles_.size(), kTrianglesAtOnce, [&](size_t begin, size_t end) {
      Buffer<BlockPlace> places(kMostPlaces);
      std::vector<BlockTriangle>& list = lists[begin / kTrianglesAtOnce];
      list.reserve(2 * (end - begin));
      for (size_t i = begin; i < end; ++i) list_blocks(static_cast<uint32_t>(i), places, list);
    });
    const uint32_t last = std::max({blocks_.count.x, blocks_.count.y, blocks_.count.z}) - 1;
    const uint32_t code_side = std::bit_ceil(last + 1);
    std::vector<size_t> next(size_t{code_side} * code_side * code_side + 1, 0);
    for (const auto& list : lists) {
      for (const BlockTriangle& pair : list) ++next[pair.block + 1];
    }
    for (uint32_t block = 0; block + 1 < next.size(); ++block) {
      next[block + 1] += next[block];
      if (next[block + 1] > next[block]) all_.push_back({block, next[block], next[block + 1]});
    }
    sorted_.resize(next.back());
    for (const auto& list : lists) {
      for (const BlockTriangle& pair : list) sorted_[next[pair.block]++] = pair.triangle;
    }
    for (const BlockRange& range : all_) codes_.push_back(range.block);
  }

  void mark_blocks() {
    outputs_.resize(ranges_.size());
    parallel_for(ranges_.size(), 1, [&](size_t begin, size_t end) {
      std::unique_ptr<Scratch> scratch = take_scratch();
      for (size_t i = begin; i < end && !out_of_memory_; ++i) mark_block(i, *scratch);
      const std::lock_guard lock(mutex_);
      idle_.push_back(std::move(scratch));
    });
    idle_.clear();
  }

  std::unique_ptr<Scratch> take_scratch() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<Scratch>();
    std::unique_ptr<Scratch> scratch = std::move(idle_.back());
    idle_.pop_back();
    return scratch;
  }

  Shell shell_of(uint32_t triangle) const {
    const bool rim = !options_.rims.empty() && options_.rims[triangle] != 0;
    return rim ? Shell::conservative : options_.shell;
  }

  // Calls take(triangle, its vertices in the block, count of places) for each that has any.
  template <class Take>
  void for_each_marked(const BlockRange& range, Buffer<BlockPlace>& places,
                       const Take& take) const {
    const uvec3 base = kSide * voxel_of(range.block);
    const uvec3 last = min(grid_.resolution - base, uvec3(kSide)) - 1u;
    for (size_t i = range.first; i < range.end; ++i) {
      GridTriangle triangle;
      load(sorted_[i], triangle);
      for (dvec3& v : triangle.vertex) v -= dvec3(base);
      const size_t count = mark_triangle(triangle, shell_of(sorted_[i]), last, places.data());
      if (count > 0) take(sorted_[i], triangle, count);
    }
  }

  void mark_block(size_t index, Scratch& scratch) {
    const BlockRange& range = ranges_[index];
    scratch.count = 0;
    for_each_marked(range, scratch.places,
                    [&](uint32_t triangle, const GridTriangle& vertices, size_t count) {
                      look_at(triangle, vertices, range.block, count, scratch);
                    });
    if (scratch.count == 0) return;
    sort_by_bits({scratch.fragments.data(), scratch.count}, scratch.sorted.data(), 0);
    sort_by_bits({scratch.sorted.data(), scratch.count}, scratch.fragments.data(), 9);
    BlockOutput& out = outputs_[index];
    out.fragments.assign(scratch.fragments.data(), scratch.fragments.data() + scratch.count);
    out.count = out.fragments.size();
    for (size_t i = 0; i < out.fragments.size(); ++i) {
      out.voxels += i == 0 || out.fragments[i].voxel != out.fragments[i - 1].voxel;
    }
    take_memory(2 * sizeof(VoxelFragment) * out.count);
  }

  void look_at(uint32_t index, const GridTriangle& triangle, uint32_t block, size_t count,
               Scratch& scratch) {
    std::fill_n(scratch.present.data(), count, uint8_t{1});
    nearest_points(make_nearest_setup(triangle), scratch.places.data(), count, scratch.u.data(),
                   scratch.v.data());
    look_({index,
           grid_.voxel,
           {scratch.u.data(), count},
           {scratch.v.data(), count},
           {scratch.normals.data(), count},
           {scratch.colors.data(), count},
           {scratch.present.data(), count}});
    VoxelFragment* const first = scratch.room_for(count);
    VoxelFragment* to = first;
    const VoxelMorton base = VoxelMorton{block} << kPlaceBits;
    for (size_t i = 0; i < count; ++i) {
      *to = {base | morton_of_place(scratch.places[i]), index, scratch.normals[i],
             scratch.colors[i]};
      to += scratch.present[i];
    }
    scratch.count += static_cast<size_t>(to - first);
  }

  void take_memory(uint64_t bytes) {
    if (memory_.fetch_add(bytes) + bytes > options_.memory_limit) out_of_memory_ = true;
  }

  // Finds what the shell encloses, and makes outputs for blocks that have nothing else.
  void fill() {
    std::vector<int32_t> slot(blocks_.size(), kNoShell);
    take_memory(3 * sizeof(BlockBits) * outputs_.size());
    if (out_of_memory_) return;
    std::vector<BlockBits> shell(outputs_.size());
    for (size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i].slot = static_cast<int32_t>(i);
      slot[blocks_.index(voxel_of(ranges_[i].block))] = static_cast<int32_t>(i);
    }
    parallel_for(outputs_.size(), 16, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        shell[i].fill(0);
        for (const VoxelFragment& f : outputs_[i].fragments) {
          const uvec3 v = voxel_of(f.voxel & (kBlockVoxels - 1));
          shell[i][v.y + kSide * v.z] |= uint64_t{1} << v.x;
        }
      }
    });
    const Outside outside = flood_from_outside(blocks_, slot, shell);
    for (size_t i = 0; i < outputs_.size(); ++i) {
      uint64_t inside = 0;
      for (size_t row = 0; row < shell[i].size(); ++row) {
        shell[i][row] = ~(shell[i][row] | outside.parts[i][row]);
        inside += static_cast<uint64_t>(std::popcount(shell[i][row]));
      }
      outputs_[i].count += inside;
      outputs_[i].voxels += inside;
      take_memory(sizeof(VoxelFragment) * inside);
    }
    inside_ = std::move(shell);
    add_whole_blocks(slot, outside);
  }

  void add_whole_blocks(std::span<const int32_t> slot, const Outside& outside) {
    std::vector<BlockRange> ranges;
    std::vector<BlockOutput> outputs;
    for (uint32_t z = 0, i = 0; z < blocks_.count.z; ++z) {
      for (uint32_t y = 0; y < blocks_.count.y; ++y) {
        for (uint32_t x = 0; x < blocks_.count.x; ++x, ++i) {
          if (slot[i] != kNoShell || outside.whole[i] != 0) continue;
          ranges_.push_back({static_cast<uint32_t>(morton_of({x, y, z})), 0, 0});
          outputs_.push_back({{}, kNoShell, kBlockVoxels, kBlockVoxels});
          take_memory(sizeof(VoxelFragment) * kBlockVoxels);
        }
      }
    }
    if (out_of_memory_) return;
    std::vector<uint32_t> order(ranges_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return ranges_[a].block < ranges_[b].block; });
    for (const uint32_t i : order) {
      ranges.push_back(ranges_[i]);
      outputs.push_back(std::move(outputs_[i]));
    }
    ranges_ = std::move(ranges);
    outputs_ = std::move(outputs);
  }

  VoxelSurface join() {
    VoxelSurface surface;
    surface.grid = grid_;
    std::vector<uint64_t> first(outputs_.size() + 1, 0);
    for (size_t i = 0; i < outputs_.size(); ++i) {
      first[i + 1] = first[i] + outputs_[i].count;
      surface.voxels += outputs_[i].voxels;
    }
    surface.fragments.resize(first.back());
    parallel_for(outputs_.size(), 8, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        BlockOutput& from = outputs_[i];
        VoxelFragment* const to = surface.fragments.data() + first[i];
        if (from.count == from.fragments.size()) {
          std::copy(from.fragments.begin(), from.fragments.end(), to);
        } else {
          write_filled(from, ranges_[i].block, to);
        }
        from.fragments = {};
      }
    });
    return surface;
  }

  // Surface and filling, merged.
  void write_filled(const BlockOutput& from, uint32_t block, VoxelFragment* to) const {
    const VoxelMorton base = VoxelMorton{block} << kPlaceBits;
    const BlockBits* const bits =
        from.slot == kNoShell ? nullptr : &inside_[static_cast<size_t>(from.slot)];
    const uint16_t normal = pack_normal(vec3(0.0f, 0.0f, 1.0f));
    auto next = from.fragments.begin();
    for (uint32_t place = 0; place < kBlockVoxels; ++place) {
      while (next != from.fragments.end() && next->voxel == (base | place)) *to++ = *next++;
      const uvec3 v = voxel_of(place);
      if (bits != nullptr && ((*bits)[v.y + kSide * v.z] >> v.x & 1) == 0) continue;
      *to++ = {base | place, kInside, normal, options_.inside_color};
    }
  }

  Result<VoxelSurface> no_memory() const {
    return fail({ErrorKind::runtime, "", "",
                 fmt::format("more memory than {} MiB is needed for so many voxels",
                             options_.memory_limit >> 20),
                 options_.solid ? "allow more with --memory-limit, make voxels larger, or leave "
                                  "--solid out: solids are filled as a whole"
                                : "allow more, or make voxels larger"});
  }

  std::span<const vec3> positions_;
  std::span<const uvec3> triangles_;
  VoxelGrid grid_;
  LookFunction look_;
  VoxelizeOptions options_;
  BlockGrid blocks_;
  std::vector<BlockRange> all_;       // that triangles meet, in Morton order
  std::vector<uint32_t> codes_;       // of these
  std::vector<BlockRange> ranges_;    // that are voxelised now, in Morton order
  std::vector<uint32_t> sorted_;      // triangles
  std::vector<BlockOutput> outputs_;  // one a range
  std::vector<BlockBits> inside_;
  std::mutex mutex_;  // of idle_
  std::vector<std::unique_ptr<Scratch>> idle_;
  std::atomic<uint64_t> memory_{0};
  std::atomic<bool> out_of_memory_{false};
};

}  // namespace

Box surface_box(std::span<const vec3> positions, std::span<const uvec3> triangles) {
  Box box;
  for (const uvec3& t : triangles) {
    const vec3 a = positions[t.x], b = positions[t.y], c = positions[t.z];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    if (cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)) == dvec3(0.0)) continue;
    box.extend(a);
    box.extend(b);
    box.extend(c);
  }
  return box;
}

Result<VoxelSurface> voxelize(std::span<const vec3> positions, std::span<const uvec3> triangles,
                              const VoxelGrid& grid, LookFunction look,
                              const VoxelizeOptions& options) {
  return SurfaceVoxelizer(positions, triangles, grid, look, options).all();
}

struct SurfaceVoxelizer::Work : Voxelizer {
  using Voxelizer::Voxelizer;
};

SurfaceVoxelizer::SurfaceVoxelizer(std::span<const vec3> positions,
                                   std::span<const uvec3> triangles, const VoxelGrid& grid,
                                   LookFunction look, const VoxelizeOptions& options)
    : grid_(grid),
      solid_(options.solid),
      work_(std::make_unique<Work>(positions, triangles, grid, look, options)) {}
SurfaceVoxelizer::~SurfaceVoxelizer() = default;

std::span<const uint32_t> SurfaceVoxelizer::blocks() const {
  return work_->blocks();
}
std::vector<uint64_t> SurfaceVoxelizer::most_fragments() {
  return work_->most_fragments();
}

Result<VoxelSurface> SurfaceVoxelizer::all() {
  std::vector<uint32_t> which(blocks().size());
  std::iota(which.begin(), which.end(), 0u);
  return work_->run(which);
}

Result<VoxelSurface> SurfaceVoxelizer::some(std::span<const uint32_t> which) {
  SINEW_CHECK(!solid_);
  return work_->run(which);
}

}  // namespace sinew
