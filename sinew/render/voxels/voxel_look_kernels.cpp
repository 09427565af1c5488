// As gbuffer.cpp for base colours and normals, but many points at a time, and with one level of a
// texture for all points of a triangle.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/render/voxels/voxel_look_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/render/voxels/voxel_look_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using I = hn::Rebind<int32_t, D>;
using V = hn::Vec<D>;
using VI = hn::Vec<I>;

V set(float x) {
  return hn::Set(D(), x);
}

struct Vector3 {
  V x, y, z;
};
struct Vector4 {
  V x, y, z, w;
};
struct Weights {
  V u, v;
};

V at(const Weights& w, float first, float second, float third) {
  return hn::MulAdd(w.u, set(second), hn::MulAdd(w.v, set(third), set(first)));
}
Vector3 at(const Weights& w, const Linear<vec3>& value) {
  const auto part = [&](int k) {
    return at(w, value.first[k], value.to_second[k], value.to_third[k]);
  };
  return {part(0), part(1), part(2)};
}
Vector4 at(const Weights& w, const Linear<vec4>& value) {
  const auto part = [&](int k) {
    return at(w, value.first[k], value.to_second[k], value.to_third[k]);
  };
  return {part(0), part(1), part(2), part(3)};
}

Vector3 set(vec3 v) {
  return {set(v.x), set(v.y), set(v.z)};
}
Vector3 scaled(const Vector3& a, V s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
// a + s b
Vector3 plus_scaled(const Vector3& a, V s, const Vector3& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
V dot_of(const Vector3& a, const Vector3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
Vector3 cross_of(const Vector3& a, const Vector3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class M>
Vector3 choose(M mask, const Vector3& yes, const Vector3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}
// Of unit length; `otherwise` where it is shorter than `least`.
Vector3 unit(const Vector3& a, float least, const Vector3& otherwise) {
  const V length2 = dot_of(a, a);
  const V inverse = hn::Div(set(1.0f), hn::Sqrt(length2));
  return choose(hn::Gt(length2, set(least * least)), scaled(a, inverse), otherwise);
}
HWY_INLINE V saturate(V x) {
  return hn::Min(hn::Max(x, hn::Zero(D())), set(1.0f));
}

// Into one period, see texture.cpp.
V reduce(V u, Wrap wrap) {
  if (wrap == Wrap::repeat) return hn::Sub(u, hn::Floor(u));
  if (wrap == Wrap::mirror) {
    return hn::NegMulAdd(set(2.0f), hn::Floor(hn::Mul(set(0.5f), u)), u);
  }
  return saturate(u);
}

VI wrap_index(VI i, int32_t size, Wrap wrap) {
  const I di;
  const VI zero = hn::Zero(di), count = hn::Set(di, size), last = hn::Set(di, size - 1);
  if (wrap == Wrap::repeat) {
    i = hn::IfThenElse(hn::Lt(i, zero), hn::Add(i, count), i);
    i = hn::IfThenElse(hn::Gt(i, last), hn::Sub(i, count), i);
  } else if (wrap == Wrap::mirror) {
    const VI back = hn::Sub(hn::Set(di, 2 * size - 1), i);  // -1 where i is 2 * size
    i = hn::IfThenElse(hn::Gt(i, last), back, i);
  }
  // What is not finite stays within the image too.
  return hn::Min(hn::Max(i, zero), last);
}

// An 8-bit code's value.
V decode_data(VI code) {
  return hn::Mul(hn::ConvertTo(D(), code), set(1.0f / 255.0f));
}

// The sRGB transfer function but for 0.0015 of the square root, in which colours are packed with
// steps of 0.016 at least. (Tables would take longer than all the rest.)
V decode_srgb(VI code) {
  const V x = decode_data(code);
  V sum = set(0.70445246f);
  for (const float c : {-1.70036382f, 1.7361553f, 0.19563638f, 0.06715825f}) {
    sum = hn::MulAdd(sum, x, set(c));
  }
  return hn::Mul(sum, x);
}

// The values of four texels each, mixed.
struct Footprint {
  VI texel[4];
  V fx, fy;
  bool single = false;  // the first alone

  template <int kShift, class Decode>
  V channel(const Decode& decode) const {
    const auto value = [&](int i) {
      return decode(hn::And(hn::ShiftRight<kShift>(texel[i]), hn::Set(I(), 255)));
    };
    const V first = value(0);
    if (single) return first;
    const auto mix = [](V a, V b, V t) { return hn::MulAdd(t, hn::Sub(b, a), a); };
    return mix(mix(first, value(1), fx), mix(value(2), value(3), fx), fy);
  }
};

Footprint footprint_of(const LookTexture& texture, const Weights& w) {
  const I di;
  const auto width = static_cast<int32_t>(texture.image->width);
  const auto height = static_cast<int32_t>(texture.image->height);
  const auto* const texels = reinterpret_cast<const int32_t*>(texture.image->pixels.data());
  const auto coordinate = [&](int k, Wrap wrap, int32_t size) {
    const V u = at(w, texture.uv.first[k], texture.uv.to_second[k], texture.uv.to_third[k]);
    return hn::Mul(reduce(u, wrap), set(static_cast<float>(size)));
  };
  const V x = coordinate(0, texture.wrap_s, width), y = coordinate(1, texture.wrap_t, height);
  const auto fetch = [&](VI i, VI j) {
    return hn::GatherIndex(di, texels, hn::Add(hn::Mul(j, hn::Set(di, width)), i));
  };
  Footprint out;
  out.single = texture.nearest;
  if (texture.nearest) {
    out.texel[0] = fetch(wrap_index(hn::ConvertTo(di, x), width, texture.wrap_s),
                         wrap_index(hn::ConvertTo(di, y), height, texture.wrap_t));
    return out;
  }
  const V left = hn::Sub(x, set(0.5f)), top = hn::Sub(y, set(0.5f));
  const V floor_x = hn::Floor(left), floor_y = hn::Floor(top);
  out.fx = hn::Sub(left, floor_x);
  out.fy = hn::Sub(top, floor_y);
  const VI i = hn::ConvertTo(di, floor_x), j = hn::ConvertTo(di, floor_y), one = hn::Set(di, 1);
  const VI x0 = wrap_index(i, width, texture.wrap_s), y0 = wrap_index(j, height, texture.wrap_t);
  const VI x1 = wrap_index(hn::Add(i, one), width, texture.wrap_s);
  const VI y1 = wrap_index(hn::Add(j, one), height, texture.wrap_t);
  out.texel[0] = fetch(x0, y0);
  out.texel[1] = fetch(x1, y0);
  out.texel[2] = fetch(x0, y1);
  out.texel[3] = fetch(x1, y1);
  return out;
}

// The base colour.
Vector4 color_at(const LookTriangle& t, const Weights& w, bool wants_alpha) {
  Vector4 base = at(w, t.base);
  if (t.base_texture.image == nullptr) return base;
  const Footprint texels = footprint_of(t.base_texture, w);
  base.x = hn::Mul(base.x, texels.channel<0>(decode_srgb));
  base.y = hn::Mul(base.y, texels.channel<8>(decode_srgb));
  base.z = hn::Mul(base.z, texels.channel<16>(decode_srgb));
  if (wants_alpha) base.w = hn::Mul(base.w, texels.channel<24>(decode_data));
  return base;
}

// The normal map's normal; `normal` is of unit length.
Vector3 map_normal(const LookTriangle& t, const Weights& w, const Vector3& normal) {
  const Footprint texels = footprint_of(t.normal_texture, w);
  const auto component = [](V x) { return hn::MulSub(set(2.0f), x, set(1.0f)); };
  const V nx = hn::Mul(component(texels.channel<0>(decode_data)), set(t.normal_scale));
  const V ny = hn::Mul(component(texels.channel<8>(decode_data)), set(t.normal_scale));
  const V nz = component(texels.channel<16>(decode_data));

  Vector3 along = set(t.side_u);
  if (t.has_tangents) {
    const Vector4 tangent = at(w, t.tangent);
    along = {tangent.x, tangent.y, tangent.z};
  }
  along = plus_scaled(along, hn::Neg(dot_of(normal, along)), normal);
  const auto is_known = hn::Gt(dot_of(along, along), hn::Zero(D()));
  const Vector3 x = unit(along, 0.0f, normal);
  const Vector3 y = cross_of(normal, x);
  const V side = t.has_tangents ? at(w, t.tangent).w : dot_of(y, set(t.side_v));
  const V up = hn::IfThenElse(hn::Lt(side, hn::Zero(D())), hn::Neg(ny), ny);
  const Vector3 mapped = plus_scaled(plus_scaled(scaled(normal, nz), nx, x), up, y);
  return choose(is_known, unit(mapped, 0.0f, normal), normal);
}

Vector3 normal_at(const LookTriangle& t, const Weights& w) {
  const Vector3 face = set(t.face);
  Vector3 normal = face;
  if (t.smooth) {
    normal = unit(at(w, t.normal), 1e-3f, face);
    // Files whose vertex normals contradict their winding mean the normal, not the side.
    const auto agrees = hn::Ge(dot_of(normal, face), hn::Zero(D()));
    normal = choose(agrees, normal, scaled(normal, set(-1.0f)));
  }
  if (t.normal_texture.image != nullptr) normal = map_normal(t, w, normal);
  // Not to the other side of the triangle.
  constexpr float kLeastCosine = 1e-3f;
  const V cosine = dot_of(normal, face);
  const V missing = hn::Max(hn::Sub(set(kLeastCosine), cosine), hn::Zero(D()));
  return plus_scaled(normal, missing, face);
}

VI quantize(V x, float steps) {
  return hn::ConvertTo(I(), hn::MulAdd(saturate(x), set(steps), set(0.5f)));
}

// As pack_normal().
VI packed_normal(const Vector3& n) {
  const D d;
  const V zero = hn::Zero(d), one = set(1.0f), half = set(0.5f);
  const V sum = hn::Add(hn::Add(hn::Abs(n.x), hn::Abs(n.y)), hn::Abs(n.z));
  const auto is_some = hn::Gt(sum, zero);
  const V inverse = hn::IfThenElseZero(is_some, hn::Div(one, sum));
  const V x = hn::Mul(n.x, inverse), y = hn::Mul(n.y, inverse);
  const auto folded = [&](V a, V b) {
    const V size = hn::Sub(one, hn::Abs(b));
    return hn::IfThenElse(hn::Lt(a, zero), hn::Neg(size), size);
  };
  const auto below = hn::Lt(n.z, zero);
  const V px = hn::IfThenElse(below, folded(x, y), x), py = hn::IfThenElse(below, folded(y, x), y);
  const VI low = quantize(hn::MulAdd(half, px, half), 254.0f);
  return hn::Or(low, hn::ShiftLeft<8>(quantize(hn::MulAdd(half, py, half), 254.0f)));
}

// As pack_color().
VI packed_color(const Vector4& color) {
  const auto part = [](V x, float steps) {
    return quantize(hn::Sqrt(hn::Max(x, hn::Zero(D()))), steps);
  };
  const VI red = hn::ShiftLeft<11>(part(color.x, 31.0f));
  return hn::Or(red, hn::Or(hn::ShiftLeft<5>(part(color.y, 63.0f)), part(color.z, 31.0f)));
}

}  // namespace

void look_at_points_kernel(const LookTriangle& t, const LookPoints& points) {
  const D d;
  const hn::Rebind<uint16_t, D> d16;
  const size_t lanes = hn::Lanes(d);
  constexpr size_t kMostLanes = HWY_MAX_BYTES / sizeof(float);
  HWY_ALIGN float u[kMostLanes] = {}, v[kMostLanes] = {}, alpha[kMostLanes];
  HWY_ALIGN uint16_t normals[kMostLanes], colors[kMostLanes];
  const bool cuts = t.least_alpha > 0.0f;
  for (size_t i = 0; i < points.count; i += lanes) {
    const size_t count = HWY_MIN(lanes, points.count - i);
    const bool whole = count == lanes;
    for (size_t k = 0; !whole && k < count; ++k) {
      u[k] = points.u[i + k];
      v[k] = points.v[i + k];
    }
    const Weights w{hn::LoadU(d, whole ? points.u + i : u), hn::LoadU(d, whole ? points.v + i : v)};
    const Vector4 color = color_at(t, w, cuts);
    hn::StoreU(hn::DemoteTo(d16, packed_color(color)), d16, whole ? points.colors + i : colors);
    hn::StoreU(hn::DemoteTo(d16, packed_normal(normal_at(t, w))), d16,
               whole ? points.normals + i : normals);
    if (cuts) hn::StoreU(color.w, d, alpha);
    for (size_t k = 0; cuts && k < count; ++k) points.present[i + k] = alpha[k] >= t.least_alpha;
    for (size_t k = 0; !whole && k < count; ++k) {
      points.colors[i + k] = colors[k];
      points.normals[i + k] = normals[k];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(look_at_points_kernel);

void look_at_points(const LookTriangle& triangle, const LookPoints& points) {
  HWY_DYNAMIC_DISPATCH(look_at_points_kernel)(triangle, points);
}

}  // namespace sinew
#endif  // HWY_ONCE
