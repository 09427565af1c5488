// Blinn-Phong with Schlick's Fresnel term for many voxels at a time (see shade.h), their shadows
// (see voxel_shadows.h), and the environment.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/render/voxels/voxel_shade_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

#include <cmath>

#include "sinew/base/check.h"
#include "sinew/render/voxels/voxel_shade.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

constexpr float kPi = 3.14159265f;

HWY_INLINE V splat(float x) {
  return hn::Set(D(), x);
}
HWY_INLINE V zero() {
  return hn::Zero(D());
}
HWY_INLINE V saturate(V x) {
  return hn::Min(hn::Max(x, zero()), splat(1.0f));
}
HWY_INLINE V pow5(V x) {
  const V x2 = hn::Mul(x, x);
  return hn::Mul(hn::Mul(x2, x2), x);
}

struct V3 {
  V x, y, z;
};
HWY_INLINE V3 splat(vec3 v) {
  return {splat(v.x), splat(v.y), splat(v.z)};
}
HWY_INLINE V3 operator+(V3 a, V3 b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V3 operator-(V3 a, V3 b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 operator*(V3 a, V3 b) {
  return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
}
HWY_INLINE V3 operator*(V3 a, V s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
// a + b * s
HWY_INLINE V3 add_scaled(V3 a, V3 b, V s) {
  return {hn::MulAdd(b.x, s, a.x), hn::MulAdd(b.y, s, a.y), hn::MulAdd(b.z, s, a.z)};
}
HWY_INLINE V3 mix(V3 a, V3 b, V s) {
  return add_scaled(a, b - a, s);
}
HWY_INLINE V3 max(V3 a, V3 b) {
  return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}
HWY_INLINE V3 select(M mask, V3 yes, V3 no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}
HWY_INLINE V dot(V3 a, V3 b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V largest(V3 a) {
  return hn::Max(a.x, hn::Max(a.y, a.z));
}
// Of unit length, or `fallback` where the length is zero or not finite.
HWY_INLINE V3 unit_or(V3 a, V3 fallback) {
  const V length2 = dot(a, a);
  const M fine = hn::And(hn::Gt(length2, splat(1e-36f)), hn::Lt(length2, splat(1e36f)));
  return select(fine, a * hn::Div(splat(1.0f), hn::Sqrt(length2)), fallback);
}
HWY_INLINE V plane(const vec4& row, V3 p) {
  return hn::MulAdd(splat(row.x), p.x,
                    hn::MulAdd(splat(row.y), p.y, hn::MulAdd(splat(row.z), p.z, splat(row.w))));
}
HWY_INLINE V power(V base, V exponent) {
  const D d;
  return hn::Exp(d, hn::Mul(exponent, hn::Log(d, hn::Max(base, splat(1e-30f)))));
}

// ---- The environment, as environment_radiance() and environment_ambient().

HWY_INLINE V3 sky(const Environment& e, V y) {
  y = hn::Min(hn::Max(y, splat(-1.0f)), splat(1.0f));
  const V3 end = select(hn::Gt(y, zero()), splat(e.zenith), splat(e.nadir));
  return mix(splat(e.horizon), end, hn::Abs(y));
}

HWY_INLINE V3 sky_ambient(const Environment& e, V y) {
  const D d;
  y = hn::Min(hn::Max(y, splat(-1.0f)), splat(1.0f));
  const V angle = hn::Acos(d, y);
  const V sine = hn::Sqrt(hn::Max(zero(), hn::NegMulAdd(y, y, splat(1.0f))));
  const V scale = splat((2.0f / 3.0f) / kPi);
  const V up = hn::Mul(scale, hn::MulAdd(hn::Sub(splat(kPi), angle), y, sine));
  const V down = hn::Mul(scale, hn::NegMulAdd(angle, y, sine));
  const V3 horizon = splat(e.horizon);
  return add_scaled(add_scaled(horizon, splat(e.zenith) - horizon, up), splat(e.nadir) - horizon,
                    down);
}

// ---- Surfaces, as resolve_voxel().

struct Lanes {
  V3 position, normal, view;
  V diagonal;
  V3 albedo, specular, emission;
  V grazing, roughness, exponent, occlusion;
  M unlit;
};

struct MaterialLanes {
  V value[12];
};

// A row of the table a lane; most often all are the same.
HWY_INLINE MaterialLanes load_material(const VoxelMaterial* table, const uint32_t* index) {
  const D d;
  const DI di;
  const VI at = hn::Load(di, reinterpret_cast<const int32_t*>(index));
  const float* const floats = reinterpret_cast<const float*>(table);
  MaterialLanes out;
  if (hn::AllTrue(di, hn::Eq(at, hn::Set(di, static_cast<int32_t>(index[0]))))) {
    for (int k = 0; k < 12; ++k) out.value[k] = splat(floats[12 * size_t{index[0]} + k]);
    return out;
  }
  const VI row = hn::Mul(at, hn::Set(di, 12));
  for (int k = 0; k < 12; ++k) out.value[k] = hn::GatherIndex(d, floats + k, row);
  return out;
}

HWY_INLINE V phong_exponent(V roughness) {
  const V alpha = hn::Mul(roughness, roughness);
  const V alpha2 = hn::Max(hn::Mul(alpha, alpha), splat(1e-6f));
  return hn::Min(hn::Sub(hn::Div(splat(2.0f), alpha2), splat(2.0f)), splat(2048.0f));
}

HWY_INLINE V widen(V roughness, V spread) {
  const V one = splat(1.0f), two = splat(2.0f);
  const V exponent = phong_exponent(roughness);
  const V share = hn::Div(spread, hn::MulAdd(exponent, hn::Sub(one, spread), spread));
  const V wide = hn::Sqrt(hn::Sqrt(hn::Div(two, hn::MulAdd(share, exponent, two))));
  return hn::IfThenElse(hn::Ge(spread, one), roughness, wide);
}

// Turns and bends the normal to where it can be seen.
HWY_INLINE V3 face(V3 normal, V3 view) {
  const V least = splat(1e-3f);
  V cosine = dot(normal, view);
  const M behind = hn::Lt(cosine, splat(kFromBehind));
  normal = select(behind, normal * splat(-1.0f), normal);
  cosine = hn::IfThenElse(behind, hn::Neg(cosine), cosine);
  const V target = hn::Max(hn::Neg(cosine), splat(kProfile));
  const V3 bent = unit_or(add_scaled(normal, view, hn::Sub(target, cosine)), view);
  return select(hn::Lt(cosine, least), bent, normal);
}

HWY_INLINE void load_surface(const VoxelLighting& l, const VoxelBatch& batch, uint32_t i,
                             Lanes& out) {
  const D d;
  V spread;
  V3 direction;
  hn::LoadInterleaved4(d, batch.place[i], out.position.x, out.position.y, out.position.z,
                       out.diagonal);
  hn::LoadInterleaved4(d, batch.normal[i], direction.x, direction.y, direction.z, spread);
  const V3 to_eye = splat(l.camera.to_world[2]);
  out.view = to_eye;
  if (!l.camera.orthographic) {
    out.view = unit_or(splat(l.camera.to_world[3]) - out.position, to_eye);
  }
  out.normal = face(unit_or(direction, out.view), out.view);

  V unused;
  V3 base;
  hn::LoadInterleaved4(d, batch.color[i], base.x, base.y, base.z, unused);
  const MaterialLanes m = load_material(l.materials.data(), batch.material + i);
  const V one = splat(1.0f), metallic = m.value[7], dull = hn::Sub(one, metallic);
  out.unlit = hn::Gt(m.value[10], zero());
  out.albedo = base * dull;
  out.specular = mix({m.value[0], m.value[1], m.value[2]}, base, metallic);
  out.grazing = hn::NegMulAdd(hn::Sub(one, m.value[3]), dull, one);
  out.emission = select(out.unlit, base, {m.value[4], m.value[5], m.value[6]});
  out.roughness = widen(m.value[8], spread);
  out.exponent = phong_exponent(out.roughness);
  out.occlusion = m.value[9];
}

// ---- Lights, as illuminate(), scatter() and lit_share().

HWY_INLINE V filter(const DepthMap& map, V x, V y, V depth) {
  const D d;
  const DI di;
  const V one = splat(1.0f), left = hn::Floor(hn::Sub(x, splat(0.5f))),
          top = hn::Floor(hn::Sub(y, splat(0.5f)));
  const V fx = hn::Sub(hn::Sub(x, splat(0.5f)), left), fy = hn::Sub(hn::Sub(y, splat(0.5f)), top);
  const V weight_x[4] = {hn::Sub(one, fx), one, one, fx};
  const V weight_y[4] = {hn::Sub(one, fy), one, one, fy};
  const int32_t width = static_cast<int32_t>(map.width);
  const VI corner =
      hn::Add(hn::Mul(hn::ConvertTo(di, top), hn::Set(di, width)), hn::ConvertTo(di, left));
  V sum = zero();
  for (int j = 0; j < 4; ++j) {
    V row = zero();
    for (int i = 0; i < 4; ++i) {
      const VI at = hn::Add(corner, hn::Set(di, (j - 1) * width + i - 1));
      const V stored = hn::GatherIndex(d, map.depth.data(), at);
      row = hn::Add(row, hn::IfThenElseZero(hn::Le(depth, stored), weight_x[i]));
    }
    sum = hn::MulAdd(row, weight_y[j], sum);
  }
  return hn::Mul(sum, splat(1.0f / 9.0f));
}

// Lanes outside of `wanted` may have any share.
HWY_INLINE V lit_lanes(const VoxelShadowMap& shadow, const Lanes& s, V cosine, M wanted) {
  const D d;
  const V reach = splat(kFilterReach);
  const V sine = hn::Sqrt(hn::Max(zero(), hn::NegMulAdd(cosine, cosine, splat(1.0f))));
  V lit = splat(1.0f);
  for (uint32_t i = 0; i < shadow.views; ++i) {
    const RasterView& view = shadow.view[i];
    const V texel = hn::Mul(splat(shadow.texel), hn::Max(plane(view.w, s.position), zero()));
    const V caster = hn::Max(s.diagonal, hn::Mul(splat(kCoarsestCaster), texel));
    const V slope = hn::MulAdd(reach, texel, hn::Mul(splat(0.5f), caster));
    const V lift = hn::MulAdd(splat(kVoxelHeight), caster, hn::Mul(sine, slope));
    const V3 p = add_scaled(s.position, s.normal, lift);
    const V scale = hn::Div(splat(1.0f), plane(view.w, p)), depth = plane(view.depth, p);
    const V x = hn::Mul(plane(view.x, p), scale), y = hn::Mul(plane(view.y, p), scale);
    const V right = splat(static_cast<float>(view.width) - kFilterReach);
    const V bottom = splat(static_cast<float>(view.height) - kFilterReach);
    M inside = hn::And(wanted, hn::Gt(depth, splat(view.near)));
    inside = hn::And(inside, hn::And(hn::Ge(x, reach), hn::Ge(y, reach)));
    inside = hn::And(inside, hn::And(hn::Lt(x, right), hn::Lt(y, bottom)));
    if (hn::AllFalse(d, inside)) continue;
    const V safe_x = hn::IfThenElse(inside, x, reach), safe_y = hn::IfThenElse(inside, y, reach);
    lit = hn::IfThenElse(inside, filter(shadow.map[i], safe_x, safe_y, depth), lit);
    wanted = hn::AndNot(inside, wanted);
    if (hn::AllFalse(d, wanted)) break;
  }
  return lit;
}

struct Arriving {
  V3 direction;
  V scale;  // of the light's intensity
};

HWY_INLINE Arriving illuminate(const ShadingLight& light, V3 position) {
  const V one = splat(1.0f);
  if (light.type == LightType::directional) return {splat(-light.direction), one};
  const V3 to_light = splat(light.position) - position;
  const V d2 = dot(to_light, to_light), d = hn::Sqrt(d2);
  const V3 direction = to_light * hn::Div(one, hn::Max(d, splat(1e-30f)));
  V scale = light.falloff ? hn::Div(one, hn::Max(d2, splat(1e-4f))) : one;
  if (light.range > 0.0f) {
    const V q = hn::Mul(d, splat(1.0f / light.range)), q2 = hn::Mul(q, q);
    scale = hn::Mul(scale, saturate(hn::NegMulAdd(q2, q2, one)));
  }
  if (light.type == LightType::spot) {
    const V cosine = hn::Neg(dot(splat(light.direction), direction));
    const V cone = saturate(hn::MulAdd(cosine, splat(light.cone_scale), splat(light.cone_offset)));
    scale = hn::Mul(scale, hn::Mul(cone, cone));
  }
  return {direction, hn::IfThenElseZero(hn::Gt(d, zero()), scale)};
}

HWY_INLINE V3 add_light(const ShadingLight& light, const VoxelShadowMap& shadow, const Lanes& s,
                        V3 sum) {
  const D d;
  const V one = splat(1.0f);
  const Arriving arriving = illuminate(light, s.position);
  const V cosine = dot(s.normal, arriving.direction);
  const M wanted =
      hn::AndNot(s.unlit, hn::And(hn::Gt(cosine, zero()), hn::Gt(arriving.scale, zero())));
  if (hn::AllFalse(d, wanted)) return sum;
  V scale = hn::IfThenElseZero(wanted, hn::Mul(arriving.scale, cosine));
  if (shadow.views > 0) {
    scale = hn::Mul(scale, lit_lanes(shadow, s, hn::Min(cosine, one), wanted));
    if (hn::AllTrue(d, hn::Eq(scale, zero()))) return sum;
  }
  const V3 half = unit_or(s.view + arriving.direction, s.normal);
  const V fresnel_share = pow5(hn::Sub(one, saturate(dot(s.view, half))));
  const V3 grazing = {s.grazing, s.grazing, s.grazing};
  const V3 fresnel = add_scaled(s.specular, grazing - s.specular, fresnel_share);
  const V peak = light.falloff ? hn::MulAdd(s.exponent, splat(0.125f), one) : one;
  const V lobe =
      hn::Mul(hn::Mul(peak, splat(1.0f / kPi)), power(saturate(dot(s.normal, half)), s.exponent));
  const V3 diffuse = s.albedo * splat(1.0f / kPi);
  const V3 ones = {one, one, one};
  const V3 reflected = diffuse * (ones - fresnel) + fresnel * lobe;
  return add_scaled(sum, reflected * splat(light.intensity), scale);
}

// ---- As scatter_environment(), and what a mirror ray would bring.

HWY_INLINE V3 add_environment(const VoxelLighting& l, const Lanes& s, V3 sum) {
  const Environment& e = l.environment;
  const V one = splat(1.0f);
  const V cosine = saturate(dot(s.normal, s.view));
  const V mirror_most = hn::Mul(hn::Sub(one, s.roughness), s.grazing);
  const V3 ceiling = max({mirror_most, mirror_most, mirror_most}, s.specular);
  const V3 reflectance = add_scaled(s.specular, ceiling - s.specular, pow5(hn::Sub(one, cosine)));
  const V3 ambient = e.ambient ? splat(*e.ambient) : sky_ambient(e, s.normal.y);
  const V3 ones = {one, one, one};
  V3 out = s.albedo * (ones - reflectance) * ambient * s.occlusion;

  const V mirror_y =
      hn::Sub(hn::Mul(hn::Mul(splat(2.0f), dot(s.normal, s.view)), s.normal.y), s.view.y);
  V traced = zero();
  const V3 sharp = sky(e, mirror_y);
  if (l.mirrors) {
    const V x = saturate(hn::Mul(hn::Sub(splat(0.35f), s.roughness), splat(1.0f / 0.15f)));
    const V share = hn::Mul(hn::Mul(x, x), hn::NegMulAdd(splat(2.0f), x, splat(3.0f)));
    const M worth = hn::Ge(hn::Mul(share, largest(reflectance)), splat(0.01f));
    traced = hn::IfThenElseZero(worth, share);
    out = add_scaled(out, reflectance * sharp, traced);
  }
  const V3 blurred = mix(sharp, sky_ambient(e, mirror_y), s.roughness);
  return sum + out + reflectance * blurred * hn::Mul(hn::Sub(one, traced), s.occlusion);
}

void shade_kernel(const VoxelLighting& l, const VoxelBatch& batch, Radiance& out) {
  const D d;
  const V3 dark = {zero(), zero(), zero()};
  for (uint32_t i = 0; i < batch.count; i += static_cast<uint32_t>(hn::Lanes(d))) {
    Lanes s;
    load_surface(l, batch, i, s);
    V3 sum = add_environment(l, s, dark);
    for (size_t light = 0; light < l.lights.size(); ++light) {
      sum = add_light(l.lights[light], l.shadows[light], s, sum);
    }
    sum = s.emission + select(s.unlit, dark, sum);
    hn::StoreInterleaved4(sum.x, sum.y, sum.z, splat(1.0f), d, out[i]);
  }
}

void background_kernel(const Environment& e, const CameraView& camera, const BackgroundRow& row,
                       vec4* out) {
  const D d;
  constexpr uint32_t kMost = 16;
  const uint32_t lanes = static_cast<uint32_t>(hn::Lanes(d));
  const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
  const float pixel = 2.0f * half_height / static_cast<float>(row.height);
  const Affine& to_world = camera.to_world;
  const float up = (0.5f * static_cast<float>(row.height) - row.y) * pixel;
  for (uint32_t i = 0; i < row.count; i += lanes) {
    const V index = hn::Add(hn::Iota(d, 0.0f), splat(static_cast<float>(i)));
    const V x = hn::MulAdd(index, splat(row.step_x), splat(row.first_x));
    const V right = hn::Mul(hn::Sub(x, splat(0.5f * static_cast<float>(row.width))), splat(pixel));
    V y = splat(-to_world[2].y);
    if (!camera.orthographic) {
      const V length2 = hn::MulAdd(right, right, splat(up * up + 1.0f));
      const V unscaled =
          hn::MulAdd(right, splat(to_world[0].y), splat(up * to_world[1].y - to_world[2].y));
      y = hn::Div(unscaled, hn::Sqrt(length2));
    }
    const V3 color = sky(e, y);
    if (i + lanes <= row.count) {
      hn::StoreInterleaved4(color.x, color.y, color.z, splat(1.0f), d, &out[i].x);
      continue;
    }
    alignas(64) float last[kMost][4];
    hn::StoreInterleaved4(color.x, color.y, color.z, splat(1.0f), d, last[0]);
    for (uint32_t k = 0; i + k < row.count; ++k) {
      out[i + k] = vec4(last[k][0], last[k][1], last[k][2], last[k][3]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(shade_kernel);
HWY_EXPORT(background_kernel);

void shade_voxels(const VoxelLighting& lighting, const VoxelBatch& batch, Radiance& out) {
  SINEW_CHECK(lighting.shadows.size() == lighting.lights.size());
  HWY_DYNAMIC_DISPATCH(shade_kernel)(lighting, batch, out);
}

void shade_background(const Environment& environment, const CameraView& camera,
                      const BackgroundRow& row, vec4* out) {
  HWY_DYNAMIC_DISPATCH(background_kernel)(environment, camera, row, out);
}

}  // namespace sinew
#endif
