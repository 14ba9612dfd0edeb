// Lanes of beams at an interface: the split of raytrace/optics.h. The two incoherent fields that a
// Beam carries enter its power only through their sums of products, so a lane carries those: four
// numbers in the frame (axis, direction x axis).
#if defined(PLUVIA_WIDE_OPTICS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUVIA_WIDE_OPTICS_INL
#undef PLUVIA_WIDE_OPTICS_INL
#else
#define PLUVIA_WIDE_OPTICS_INL
#endif

#include "raytrace/wide_drop-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pluvia::HWY_NAMESPACE {

// <E_s E_s*>, <E_p E_p*> and the complex <E_s E_p*>; the power is s + p.
struct LightLanes {
  Lanes s, p, re, im;
};

struct BeamLanes {
  Lanes3 direction, axis;  // unit, perpendicular
  LightLanes light;
};

HWY_INLINE Lanes power_lanes(const LightLanes& light) {
  return light.s + light.p;
}

HWY_INLINE BeamLanes unpolarised_lanes(const Lanes3& direction) {
  const Lanes zero = hn::Zero(Tag());
  return {direction, across(direction), {all(0.5), all(0.5), zero, zero}};
}

struct SplitLanes {
  Lanes power_s, power_p;  // of the incident beam
  BeamLanes reflected, refracted;
  LaneMask total;  // total reflection: the refracted direction is along the surface, its light 0
};

// Unit vector perpendicular to the plane of incidence, any one across at normal incidence.
HWY_INLINE Lanes3 s_axis_lanes(const Lanes3& d, const Lanes3& normal) {
  const Lanes zero = hn::Zero(Tag());
  const Lanes3 s = cross(d, normal);
  const Lanes3 flat = mul_add(d, zero - dot(s, d), s);
  const Lanes length2 = dot(flat, flat);
  const LaneMask along = length2 < all(1e-24);
  const Lanes length = hn::Sqrt(hn::IfThenElse(along, all(1.0), length2));
  return choose(along, across(d), times(flat, all(1.0) / length));
}

// The same light in the frame of another axis across the same direction.
HWY_INLINE LightLanes turned_light(const BeamLanes& beam, const Lanes3& axis) {
  const Lanes zero = hn::Zero(Tag());
  const LightLanes& old = beam.light;
  const Lanes c = dot(axis, beam.axis), s = dot(axis, cross(beam.direction, beam.axis));
  const Lanes cc = c * c, ss = s * s, cs = c * s;
  const Lanes mixed = (cs + cs) * old.re;
  LightLanes turned;
  // A power that rounding leaves below 0 is 0.
  turned.s = hn::Max(zero, hn::MulAdd(cc, old.s, hn::MulAdd(ss, old.p, mixed)));
  turned.p = hn::Max(zero, hn::MulAdd(ss, old.s, hn::MulSub(cc, old.p, mixed)));
  turned.re = hn::MulAdd(cc - ss, old.re, cs * (old.p - old.s));
  turned.im = old.im;
  return turned;
}

// Light times real amplitudes.
HWY_INLINE LightLanes scaled_light(const LightLanes& light, Lanes s, Lanes p) {
  return {light.s * (s * s), light.p * (p * p), light.re * (s * p), light.im * (s * p)};
}

// Light after total reflection: r = (a - i b) / (a + i b) with a, b = ratio ci, kappa for s and
// ci, ratio kappa for p; both of modulus 1, so only <E_s E_p*> turns, by r_s r_p*.
HWY_INLINE LightLanes totally_reflected_light(const LightLanes& light, Lanes ci, Lanes kappa,
                                              Lanes ratio) {
  const Lanes a_s = ratio * ci, b_s = kappa, a_p = ci, b_p = ratio * kappa;
  const Lanes one = all(1.0);
  const Lanes norm_s = one / hn::MulAdd(a_s, a_s, b_s * b_s);
  const Lanes norm_p = one / hn::MulAdd(a_p, a_p, b_p * b_p);
  const Lanes s_re = hn::MulSub(a_s, a_s, b_s * b_s) * norm_s,
              s_im = all(-2.0) * a_s * b_s * norm_s;
  const Lanes p_re = hn::MulSub(a_p, a_p, b_p * b_p) * norm_p,
              p_im = all(-2.0) * a_p * b_p * norm_p;
  const Lanes re = hn::MulAdd(s_re, p_re, s_im * p_im), im = hn::MulSub(s_im, p_re, s_re * p_im);
  return {light.s, light.p, hn::MulSub(light.re, re, light.im * im),
          hn::MulAdd(light.re, im, light.im * re)};
}

// `normal` points against the beam (past grazing: the continuation that optics.h tells of);
// index_ratio = n(beam's side) / n(far side).
HWY_INLINE SplitLanes split_lanes(const BeamLanes& beam, const Lanes3& normal, double index_ratio) {
  const Lanes zero = hn::Zero(Tag()), one = all(1.0), ratio = all(index_ratio);
  const Lanes3& d = beam.direction;
  const Lanes ci = zero - dot(d, normal);
  const Lanes3 axis = s_axis_lanes(d, normal);
  const LightLanes light = turned_light(beam, axis);
  const Lanes c = ratio * ci;
  const Lanes ct2 = hn::MulAdd(c, c, all((1 - index_ratio) * (1 + index_ratio)));
  SplitLanes out;
  out.power_s = light.s;
  out.power_p = light.p;
  out.reflected.direction = normalised(mul_add(normal, ci + ci, d));
  out.reflected.axis = out.refracted.axis = axis;
  if (index_ratio == 1) {  // past grazing the formulas below would divide by zero
    out.total = hn::FirstN(Tag(), 0);
    out.reflected.light = {zero, zero, zero, zero};
    out.refracted.light = light;
    out.refracted.direction = d;
    return out;
  }
  out.total = ct2 <= zero;
  const Lanes ct = hn::Sqrt(hn::Abs(ct2));
  const Lanes over_s = one / (c + ct), over_p = one / hn::MulAdd(ratio, ct, ci);
  const Lanes root = all(2.0) * hn::Sqrt(hn::Abs(c) * ct);
  const LightLanes partly =
      scaled_light(light, (c - ct) * over_s, hn::NegMulAdd(ratio, ct, ci) * over_p);
  const LightLanes wholly = totally_reflected_light(light, ci, ct, ratio);
  out.reflected.light = {hn::IfThenElse(out.total, wholly.s, partly.s),
                         hn::IfThenElse(out.total, wholly.p, partly.p),
                         hn::IfThenElse(out.total, wholly.re, partly.re),
                         hn::IfThenElse(out.total, wholly.im, partly.im)};
  out.refracted.light = scaled_light(light, root * over_s, root * over_p);
  out.refracted.direction = normalised(
      choose(out.total, mul_add(normal, ci, d), mul_add(normal, c - ct, times(d, ratio))));
  return out;
}

}  // namespace pluvia::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
