#include "sinew/svo/make/lattice_source.h"

#include <algorithm>
#include <bit>

namespace sinew {
namespace {

// Barycentrics (v, w) of the point of triangle (0, ab, ac) that is nearest to p.
// Based on: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
vec2 nearest_barycentrics(vec3 p, vec3 ab, vec3 ac) {
  const float d1 = dot(ab, p), d2 = dot(ac, p);
  if (d1 <= 0.0f && d2 <= 0.0f) return {0.0f, 0.0f};
  const vec3 bp = p - ab;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0f && d4 <= d3) return {1.0f, 0.0f};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return {d1 / (d1 - d3), 0.0f};
  const vec3 cp = p - ac;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0f && d5 <= d6) return {0.0f, 1.0f};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return {0.0f, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4, along = d4 - d3, back = d5 - d6;
  if (va <= 0.0f && along >= 0.0f && back >= 0.0f) {
    const float w = along / (along + back);
    return {1.0f - w, w};
  }
  const float scale = 1.0f / (va + vb + vc);
  return {vb * scale, vc * scale};
}

struct Influence {
  uint32_t joint = 0;
  float weight = 0.0f;
};

// Weights in the order that quantising takes them: heaviest first.
void quantize(std::span<const Influence> heaviest, PartCorner& out) {
  float sum = 0.0f;
  for (const Influence& i : heaviest) sum += i.weight;
  uint32_t left = 65535;
  for (size_t k = heaviest.size(); k-- > 0;) {
    const float share = 65535.0f * (heaviest[k].weight / sum);
    const uint32_t units = k == 0 ? left : std::min(left, static_cast<uint32_t>(share + 0.5f));
    out.joints[k] = static_cast<uint16_t>(units > 0 ? heaviest[k].joint : 0);
    out.weights[k] = static_cast<uint16_t>(units);
    left -= units;
  }
}

}  // namespace

LatticeSource lattice_source(const VoxelGrid& grid, const SvoSource& source) {
  LatticeSource out;
  out.grid = grid;
  out.triangles = source.triangles;
  out.materials = source.materials;
  if (const auto* rigid = std::get_if<RigidMotion>(&source.motion)) out.rest = rigid->rest;
  if (const auto* keys = std::get_if<KeyframeMotion>(&source.motion)) {
    out.rest = keys->keys.first(keys->vertex_count);
  }
  if (const auto* skin = std::get_if<SkinMotion>(&source.motion)) {
    out.rest = skin->rest;
    out.skin = *skin;
  }
  if (const auto* morph = std::get_if<MorphMotion>(&source.motion)) {
    out.rest = morph->rest;
    out.skin = morph->skin;
    out.deltas = morph->deltas;
    if (!morph->rest.empty()) {
      out.targets = static_cast<uint32_t>(morph->deltas.size() / morph->rest.size());
    }
  }
  return out;
}

SheetPoint nearest_point(const LatticeSource& source, uint32_t triangle, vec3 to) {
  const uvec3 t = source.triangles[triangle];
  const vec3 a = source.rest[t.x], ab = source.rest[t.y] - a, ac = source.rest[t.z] - a;
  const vec3 p = to - a;
  const vec2 vw = nearest_barycentrics(p, ab, ac);
  const vec3 d = p - vw.x * ab - vw.y * ac;
  return {dot(d, d), triangle, vw.x, vw.y};
}

SheetPoint seen_from(const LatticeSource& source, const SheetPoint& point, vec3 to) {
  const uvec3 t = source.triangles[point.triangle];
  const vec3 a = source.rest[t.x], ab = source.rest[t.y] - a, ac = source.rest[t.z] - a;
  const vec3 d = to - a - point.v * ab - point.w * ac;
  return {dot(d, d), point.triangle, point.v, point.w};
}

void skin_corner(const LatticeSource& source, const SheetPoint& point, PartCorner& out) {
  out.joints = {};
  out.weights = {65535, 0, 0, 0};
  if (point.triangle == kInside) return;
  const SkinMotion& skin = source.skin;
  const uvec3 t = source.triangles[point.triangle];
  const float share[3] = {1.0f - point.v - point.w, point.v, point.w};
  // What weighs less than all that are kept so far can still grow, so all are added up first.
  constexpr size_t kMost = 96;
  Influence all[kMost];
  size_t count = 0;
  for (int corner = 0; corner < 3; ++corner) {
    const size_t first = size_t{t[corner]} * skin.influences;
    for (size_t i = first; i < first + skin.influences; ++i) {
      const float weight = share[corner] * skin.weights[i];
      if (!(weight > 0.0f)) continue;
      const auto end = all + count;
      auto* const found =
          std::find_if(all, end, [&](const Influence& a) { return a.joint == skin.joints[i]; });
      if (found != end) {
        found->weight += weight;
      } else if (count < kMost) {
        all[count++] = {skin.joints[i], weight};
      }
    }
  }
  if (count == 0) return;
  const size_t kept = std::min<size_t>(count, kSvoInfluences);
  std::partial_sort(all, all + kept, all + count, [](const Influence& a, const Influence& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  quantize({all, kept}, out);
}

vec3 target_delta(const LatticeSource& source, const SheetPoint& point, uint32_t target) {
  if (point.triangle == kInside) return vec3(0.0f);
  const vec3* const deltas = source.deltas.data() + target * source.rest.size();
  const uvec3 t = source.triangles[point.triangle];
  return (1.0f - point.v - point.w) * deltas[t.x] + point.v * deltas[t.y] + point.w * deltas[t.z];
}

uint64_t vertex_key(const LatticeSource& source, uint32_t vertex) {
  if (source.rest.empty()) return vertex;
  const vec3 p = source.rest[vertex] + 0.0f;  // -0 is 0
  const uint64_t xy = uint64_t{std::bit_cast<uint32_t>(p.x)} << 32 | std::bit_cast<uint32_t>(p.y);
  uint64_t key = xy * 0xbf58476d1ce4e5b9ull;
  key = (key ^ key >> 29 ^ std::bit_cast<uint32_t>(p.z)) * 0x94d049bb133111ebull;
  return key ^ key >> 32;
}

}  // namespace sinew
