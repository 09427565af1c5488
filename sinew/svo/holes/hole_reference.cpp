#include "sinew/svo/holes/hole_reference.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/thesis/thesis_voxels.h"

namespace sinew {
namespace {

constexpr size_t kGrain = 256;  // triangles
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr uint32_t kMostSteps = 4096;

std::span<const vec3> rest_positions(const Motion& motion) {
  if (const auto* const rigid = std::get_if<RigidMotion>(&motion)) return rigid->rest;
  if (const auto* const skin = std::get_if<SkinMotion>(&motion)) return skin->rest;
  if (const auto* const morph = std::get_if<MorphMotion>(&motion)) return morph->rest;
  return {};
}

uint64_t points_of(uint32_t steps) {
  return uint64_t{steps + 1} * (steps + 2) / 2;
}

// Point j of row i of a triangle cut into `steps`.
vec3 barycentric_of(uint32_t i, uint32_t j, uint32_t steps) {
  const float u = static_cast<float>(i - j) / static_cast<float>(steps);
  const float v = static_cast<float>(j) / static_cast<float>(steps);
  return {1.0f - u - v, u, v};
}

// A moved point: in pixels, its depth, and how long a deformed voxel is there. Not seen: depth 0.
struct Projected {
  float x = 0.0f, y = 0.0f, depth = 0.0f, size = 0.0f;
};

Projected project(const RasterView& view, vec3 world, float size) {
  const vec4 p(world, 1.0f);
  const float w = dot(view.w, p);
  const Projected out{dot(view.x, p) / w, dot(view.y, p) / w, dot(view.depth, p), size};
  return out.depth > view.near && std::isfinite(out.x + out.y + out.depth) ? out : Projected{};
}

// Depth in the upper half, so that the least of two is the nearer one.
uint64_t pack(float depth, float size) {
  return uint64_t{std::bit_cast<uint32_t>(depth)} << 32 | std::bit_cast<uint32_t>(size);
}

class Canvas {
 public:
  Canvas(uint32_t width, uint32_t height)
      : width_(width),
        height_(height),
        nearest_(size_t{width} * height, pack(kInfinity, 0.0f)),
        touched_(size_t{width} * height, 0) {}

  void touch(const Projected& p) {
    if (!(p.x >= 0.0f && p.y >= 0.0f && p.x < float(width_) && p.y < float(height_))) return;
    const auto x = static_cast<uint32_t>(4.0f * p.x), y = static_cast<uint32_t>(4.0f * p.y);
    const auto bit = static_cast<uint16_t>(1u << ((x & 3) + 4 * (y & 3)));
    std::atomic_ref<uint16_t> mask(touched_[size_t{y >> 2} * width_ + (x >> 2)]);
    if (!(mask.load(std::memory_order_relaxed) & bit)) mask.fetch_or(bit);
  }

  // Every pixel whose centre lies in the triangle or on its edge.
  void fill(const Projected& a, const Projected& b, const Projected& c) {
    if (a.depth == 0.0f || b.depth == 0.0f || c.depth == 0.0f) return;
    const auto first = [](float least) { return std::ceil(std::max(least - 0.5f, 0.0f)); };
    const auto last = [](float most, uint32_t size) {
      return std::floor(std::min(most - 0.5f, float(size) - 1.0f));
    };
    const float x0 = first(std::min({a.x, b.x, c.x})), x1 = last(std::max({a.x, b.x, c.x}), width_);
    const float y0 = first(std::min({a.y, b.y, c.y}));
    const float y1 = last(std::max({a.y, b.y, c.y}), height_);
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0.0f) return;
    const float size = std::max({a.size, b.size, c.size});
    for (float y = y0; y <= y1; ++y) {
      for (float x = x0; x <= x1; ++x) {
        const auto share = [&](const Projected& p, const Projected& q) {
          return ((q.x - p.x) * (y + 0.5f - p.y) - (q.y - p.y) * (x + 0.5f - p.x)) / area;
        };
        const float wc = share(a, b), wa = share(b, c), wb = share(c, a);
        if (!(wa >= 0.0f && wb >= 0.0f && wc >= 0.0f)) continue;
        put(static_cast<size_t>(y) * width_ + static_cast<size_t>(x),
            pack(wa * a.depth + wb * b.depth + wc * c.depth, size));
      }
    }
  }

  void finish(SurfacePicture& out) {
    out.width = width_;
    out.height = height_;
    out.depth.resize(nearest_.size());
    out.size.resize(nearest_.size());
    for (size_t i = 0; i < nearest_.size(); ++i) {
      out.depth[i] = std::bit_cast<float>(static_cast<uint32_t>(nearest_[i] >> 32));
      out.size[i] = std::bit_cast<float>(static_cast<uint32_t>(nearest_[i]));
    }
    out.touched = std::move(touched_);
  }

 private:
  void put(size_t pixel, uint64_t value) {
    std::atomic_ref<uint64_t> nearest(nearest_[pixel]);
    uint64_t seen = nearest.load(std::memory_order_relaxed);
    while (value < seen && !nearest.compare_exchange_weak(seen, value)) {
    }
  }

  uint32_t width_, height_;
  std::vector<uint64_t> nearest_;
  std::vector<uint16_t> touched_;
};

// The longest edge of a cell in its pose, a voxel's share of it.
float deformed_voxel(const SvoCell& cell, const PosedBlock& block) {
  float longest = 0.0f;
  for (uint32_t a = 0; a < 8; ++a) {
    for (uint32_t axis = 1; axis < 8; axis *= 2) {
      if (a & axis) continue;
      const vec3 edge = block.positions[cell.corner[a | axis]] - block.positions[cell.corner[a]];
      longest = std::max(longest, dot(edge, edge));
    }
  }
  return std::sqrt(longest) / static_cast<float>(kCellSide);
}

float scale_of(const Affine& placement) {
  return std::cbrt(std::abs(glm::determinant(linear_part(placement))));
}

void make_all_blocks(PosedSvo& posed) {
  parallel_for(posed.svo().block_count(), 4, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) posed.make_block(static_cast<uint32_t>(b));
  });
}

}  // namespace

HoleReference::HoleReference(const SvoSource& source, const Svo& svo, float step,
                             const VoxelSurface* surface)
    : source_(source), svo_(&svo), rest_(rest_positions(source.motion)) {
  SINEW_CHECK(step > 0.0f && !rest_.empty());
  index_cells();
  if (surface != nullptr) sheets_.emplace(*surface, source_, rest_, svo);
  const float longest = step * svo.grid.voxel;
  first_point_.push_back(0);
  for (const uvec3 t : source.triangles) {
    float edge = 0.0f;
    for (int k = 0; k < 3; ++k) {
      edge = std::max(edge, glm::distance(rest_[t[k]], rest_[t[(k + 1) % 3]]));
    }
    const float steps = std::isfinite(edge) ? std::ceil(edge / longest) : 1.0f;
    steps_.push_back(static_cast<uint16_t>(std::clamp(steps, 1.0f, float(kMostSteps))));
    first_point_.push_back(first_point_.back() + points_of(steps_.back()));
  }
  cells_.resize(first_point_.back(), kLost);
  std::atomic<uint64_t> lost = 0, strays = 0;
  parallel_for(steps_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      uint64_t point = first_point_[t];
      for (uint32_t i = 0; i <= steps_[t]; ++i) {
        for (uint32_t j = 0; j <= i; ++j, ++point) {
          const vec3 at = barycentric_of(i, j, steps_[t]);
          const auto triangle = static_cast<uint32_t>(t);
          const vec3 p = rest_of(triangle, at);
          if (sheets_) cells_[point] = locate(p, triangle, at, true);
          if (cells_[point] != kLost) continue;
          cells_[point] = locate(p, triangle, at, false);
          ++(cells_[point] == kLost ? lost : strays);
        }
      }
    }
  });
  lost_ = lost;
  strays_ = sheets_ ? strays.load() : 0;
}

void HoleReference::index_cells() {
  const Svo& svo = *svo_;
  block_places_ = (svo.grid.resolution + (kBlockSide - 1)) / kBlockSide;
  block_at_.assign(size_t{block_places_.x} * block_places_.y * block_places_.z, kLost);
  copies_.resize(size_t{svo.block_count()} * 512);
  block_of_.resize(svo.cells.size());
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    block_at_[(size_t{block.z} * block_places_.y + block.y) * block_places_.x + block.x] = b;
    for (uint32_t c = block.first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      Copies& copies = copies_[size_t{b} * 512 + svo.cells[c].place];
      if (copies.end == 0) copies.first = c;
      copies.end = c + 1;
      block_of_[c] = b;
    }
  }
}

vec3 HoleReference::rest_of(uint32_t triangle, vec3 w) const {
  const uvec3 t = source_.triangles[triangle];
  return w.x * rest_[t.x] + w.y * rest_[t.y] + w.z * rest_[t.z];
}

vec3 HoleReference::local_of(uint32_t cell, vec3 p) const {
  const SvoBlock& block = svo_->blocks[block_of_[cell]];
  const uint32_t place = svo_->cells[cell].place;
  const uvec3 at =
      8u * uvec3(block.x, block.y, block.z) + uvec3(place & 7, place >> 3 & 7, place >> 6);
  return (p - svo_->grid.origin) / (svo_->grid.voxel * static_cast<float>(kCellSide)) - vec3(at);
}

// `own`: only among copies of the triangle's own sheet.
uint32_t HoleReference::locate(vec3 p, uint32_t triangle, vec3 barycentric, bool own) const {
  if (!std::isfinite(p.x + p.y + p.z)) return kLost;
  const VoxelGrid& grid = svo_->grid;
  const glm::ivec3 at(glm::floor((p - grid.origin) / grid.voxel));
  Found best;
  // The surface may leave thin shells by less than a voxel: then the nearest voxel carries it.
  for (int reach = 0; reach <= 1 && best.cell == kLost; ++reach) {
    for (int i = 0; i < 27; ++i) {
      const glm::ivec3 offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if ((reach == 0) != (offset == glm::ivec3(0))) continue;
      const glm::ivec3 voxel = at + offset;
      if (glm::any(glm::lessThan(voxel, glm::ivec3(0)))) continue;
      if (glm::any(glm::greaterThanEqual(voxel, glm::ivec3(grid.resolution)))) continue;
      look_in(uvec3(voxel), p, triangle, barycentric, own, best);
    }
  }
  return best.cell;
}

void HoleReference::look_in(uvec3 voxel, vec3 p, uint32_t triangle, vec3 barycentric, bool own,
                            Found& best) const {
  const uvec3 at = voxel / kBlockSide, cell = voxel / kCellSide % 8u, in = voxel % kCellSide;
  const uint32_t b = block_at_[(size_t{at.z} * block_places_.y + at.y) * block_places_.x + at.x];
  if (b == kLost) return;
  const Copies copies = copies_[size_t{b} * 512 + cell.x + 8 * cell.y + 64 * cell.z];
  const uint32_t brick = in.x / 4 + 2 * (in.y / 4) + 4 * (in.z / 4);
  const uint32_t bit = in.x % 4 + 4 * (in.y % 4) + 16 * (in.z % 4);
  const vec3 low = svo_->grid.origin + svo_->grid.voxel * vec3(voxel);
  const vec3 away = p - glm::clamp(p, low, low + svo_->grid.voxel);
  const float distance = length(away) / svo_->grid.voxel;
  for (uint32_t c = copies.first; c < copies.end; ++c) {
    const SvoCell& copy = svo_->cells[c];
    if (!(copy.bricks >> brick & 1)) continue;
    const auto before = static_cast<uint32_t>(std::popcount(copy.bricks & ((1u << brick) - 1)));
    const uint32_t mask = svo_->blocks[b].first_brick + copy.first_brick + before;
    if (!(svo_->bricks[mask] >> bit & 1)) continue;
    if (own && !sheets_->owns(c, triangle)) continue;
    const float unlike = unlikeness(c, p, triangle, barycentric);
    if (best.cell != kLost && distance > best.distance + 0.1f) continue;
    if (best.cell != kLost && distance > best.distance - 0.1f && unlike >= best.unlike) continue;
    best = {c, distance, unlike};
  }
}

// Half the sum of the differences of all joints' weights, and 2 for another material.
float HoleReference::unlikeness(uint32_t cell, vec3 p, uint32_t triangle, vec3 barycentric) const {
  const SvoCell& copy = svo_->cells[cell];
  const bool same = source_.materials.empty() || source_.materials[triangle] == copy.material;
  const auto* const skin = std::get_if<SkinMotion>(&source_.motion);
  if (skin == nullptr || svo_->joints == 0) return same ? 0.0f : 2.0f;
  std::array<std::pair<uint32_t, float>, 64> shares;
  size_t count = 0;
  const auto add = [&](uint32_t joint, float weight) {
    if (weight == 0.0f) return;
    for (size_t i = 0; i < count; ++i) {
      if (shares[i].first == joint) return void(shares[i].second += weight);
    }
    if (count < shares.size()) shares[count++] = {joint, weight};
  };
  const vec3 local = glm::clamp(local_of(cell, p), vec3(0.0f), vec3(1.0f));
  const SvoBlock& block = svo_->blocks[block_of_[cell]];
  for (uint32_t k = 0; k < 8; ++k) {
    const float share = (k & 1 ? local.x : 1.0f - local.x) * (k & 2 ? local.y : 1.0f - local.y) *
                        (k & 4 ? local.z : 1.0f - local.z) / 65535.0f;
    const size_t corner = block.first_corner + copy.corner[k];
    for (uint32_t i = 0; i < kSvoInfluences; ++i) {
      add(svo_->joint_palette[block.first_joint + svo_->corner_joints[corner][i]],
          share * static_cast<float>(svo_->corner_weights[corner][i]));
    }
  }
  for (int k = 0; k < 3; ++k) {
    const size_t begin = size_t{source_.triangles[triangle][k]} * skin->influences;
    for (size_t i = begin; i < begin + skin->influences; ++i) {
      add(skin->joints[i], -barycentric[k] * skin->weights[i]);
    }
  }
  float sum = same ? 0.0f : 2.0f;
  for (size_t i = 0; i < count; ++i) sum += 0.5f * std::abs(shares[i].second);
  return sum;
}

// `move(triangle, barycentric, cell)` gives a Projected.
template <class Move>
void HoleReference::draw(const Move& move, const RasterView& view, SurfacePicture& out) const {
  Canvas canvas(view.width, view.height);
  parallel_for(steps_.size(), kGrain, [&](size_t begin, size_t end) {
    std::vector<Projected> above, row;
    for (size_t t = begin; t < end; ++t) {
      uint64_t point = first_point_[t];
      for (uint32_t i = 0; i <= steps_[t]; ++i) {
        std::swap(above, row);
        row.clear();
        for (uint32_t j = 0; j <= i; ++j, ++point) {
          const uint32_t cell = cells_[point];
          row.push_back(cell == kLost ? Projected{}
                                      : move(static_cast<uint32_t>(t),
                                             barycentric_of(i, j, steps_[t]), cell));
          if (row.back().depth > 0.0f) canvas.touch(row.back());
        }
        for (uint32_t j = 0; j < i; ++j) {
          canvas.fill(above[j], row[j], row[j + 1]);
          if (j + 1 < i) canvas.fill(above[j], row[j + 1], above[j + 1]);
        }
      }
    }
  });
  canvas.finish(out);
}

void HoleReference::draw_lattice(PosedSvo& posed, const Affine& placement, const RasterView& view,
                                 SurfacePicture& out) const {
  make_all_blocks(posed);
  std::vector<float> sizes(svo_->cells.size());
  const float scale = scale_of(placement);
  parallel_for(sizes.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      sizes[c] = scale * deformed_voxel(svo_->cells[c], posed.block(block_of_[c]));
    }
  });
  draw(
      [&](uint32_t triangle, vec3 barycentric, uint32_t cell) {
        const vec3 local = local_of(cell, rest_of(triangle, barycentric));
        const vec3 moved = map_point(svo_->cells[cell], posed.block(block_of_[cell]), local);
        return project(view, transform_point(placement, moved), sizes[cell]);
      },
      view, out);
}

void HoleReference::draw_true(const Pose& pose, const Affine& placement, const RasterView& view,
                              SurfacePicture& out) const {
  std::vector<vec3> moved(rest_.size());
  positions(source_.motion, pose, 0, moved);
  const float voxel = svo_->grid.voxel * scale_of(placement);
  draw(
      [&](uint32_t triangle, vec3 w, uint32_t) {
        const uvec3 t = source_.triangles[triangle];
        float stretch = 1.0f;
        for (int k = 0; k < 3; ++k) {
          const uint32_t a = t[k], b = t[(k + 1) % 3];
          const float rest = glm::distance(rest_[a], rest_[b]);
          if (rest > 0.0f) stretch = std::max(stretch, glm::distance(moved[a], moved[b]) / rest);
        }
        const vec3 p = w.x * moved[t.x] + w.y * moved[t.y] + w.z * moved[t.z];
        return project(view, transform_point(placement, p), stretch * voxel);
      },
      view, out);
}

DistanceSummary HoleReference::distance(PosedSvo& posed) const {
  make_all_blocks(posed);
  std::vector<vec3> moved(rest_.size());
  positions(source_.motion, posed.pose(), 0, moved);
  constexpr uint64_t kStride = 7;
  std::vector<float> all;
  for (size_t t = 0; t < steps_.size(); ++t) {
    uint64_t point = first_point_[t];
    const uvec3 corner = source_.triangles[t];
    for (uint32_t i = 0; i <= steps_[t]; ++i) {
      for (uint32_t j = 0; j <= i; ++j, ++point) {
        const uint32_t cell = cells_[point];
        if (point % kStride != 0 || cell == kLost) continue;
        const vec3 w = barycentric_of(i, j, steps_[t]);
        const vec3 local = local_of(cell, rest_of(static_cast<uint32_t>(t), w));
        const vec3 here = map_point(svo_->cells[cell], posed.block(block_of_[cell]), local);
        const vec3 there = w.x * moved[corner.x] + w.y * moved[corner.y] + w.z * moved[corner.z];
        all.push_back(glm::distance(here, there) / svo_->grid.voxel);
      }
    }
  }
  DistanceSummary out{.points = all.size()};
  if (all.empty()) return out;
  const auto at = [&](double share) {
    const auto nth = all.begin() + static_cast<ptrdiff_t>(share * double(all.size() - 1));
    std::nth_element(all.begin(), nth, all.end());
    return double(*nth);
  };
  out.median = at(0.5);
  out.most_of_100 = at(0.99);
  out.largest = at(1.0);
  return out;
}

}  // namespace sinew
