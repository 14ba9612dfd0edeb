// Lanes of rays against one drop: the walk of raytrace/drop_intersect.h, every lane on its own.
// Compiled once for each instruction set (Highway's foreach_target).
//
// No angle is ever computed. A lane stands at (c, s) = (cos psi, sin psi) and turns by the angle
// 2 atan(t), whose cosine and sine are rational in t: (1 - t^2) / (1 + t^2) and 2 t / (1 + t^2).
// With x half the step that provably contains no root, t = x + x^3 / 3 <= tan x makes a turn that
// is never longer than that step, and near a root equal to it up to x^5: still Newton's.
#if defined(PLUVIA_WIDE_DROP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUVIA_WIDE_DROP_INL
#undef PLUVIA_WIDE_DROP_INL
#else
#define PLUVIA_WIDE_DROP_INL
#endif

#include <array>
#include <cmath>
#include <stdexcept>

#include <hwy/highway.h>

#include "oscillation/drop_shape.h"
#include "raytrace/drop_intersect.h"

HWY_BEFORE_NAMESPACE();
namespace pluvia::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::ScalableTag<double>;
using Lanes = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;

HWY_INLINE Lanes all(double value) {
  return hn::Set(Tag(), value);
}

struct Lanes3 {
  Lanes x, y, z;
};

HWY_INLINE Lanes3 all(const Eigen::Vector3d& v) {
  return {all(v.x()), all(v.y()), all(v.z())};
}

HWY_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, a.z * b.z));
}

HWY_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {hn::MulSub(a.y, b.z, a.z * b.y), hn::MulSub(a.z, b.x, a.x * b.z),
          hn::MulSub(a.x, b.y, a.y * b.x)};
}

HWY_INLINE Lanes3 times(const Lanes3& a, Lanes k) {
  return {a.x * k, a.y * k, a.z * k};
}

// a k + b
HWY_INLINE Lanes3 mul_add(const Lanes3& a, Lanes k, const Lanes3& b) {
  return {hn::MulAdd(a.x, k, b.x), hn::MulAdd(a.y, k, b.y), hn::MulAdd(a.z, k, b.z)};
}

HWY_INLINE Lanes3 choose(LaneMask first, const Lanes3& a, const Lanes3& b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.y, b.y),
          hn::IfThenElse(first, a.z, b.z)};
}

HWY_INLINE Lanes3 normalised(const Lanes3& v) {
  return times(v, all(1.0) / hn::Sqrt(dot(v, v)));
}

// A unit vector across the unit vector d.
HWY_INLINE Lanes3 across(const Lanes3& d) {
  const LaneMask by_x = hn::Abs(d.x) > hn::Abs(d.z);
  const Lanes zero = hn::Zero(Tag());
  return normalised(choose(by_x, {zero - d.y, d.x, zero}, {zero, zero - d.z, d.y}));
}

constexpr std::size_t lane_count = hn::MaxLanes(Tag());

// One vector a lane, in and out of memory.
struct LaneVectors {
  double x[lane_count] = {}, y[lane_count] = {}, z[lane_count] = {};

  void put(std::size_t k, const Eigen::Vector3d& v) {
    x[k] = v.x();
    y[k] = v.y();
    z[k] = v.z();
  }
  Eigen::Vector3d at(std::size_t k) const { return {x[k], y[k], z[k]}; }
};

HWY_INLINE Lanes3 load(const LaneVectors& v) {
  return {hn::LoadU(Tag(), v.x), hn::LoadU(Tag(), v.y), hn::LoadU(Tag(), v.z)};
}

HWY_INLINE LaneVectors store(const Lanes3& v) {
  LaneVectors out;
  hn::StoreU(v.x, Tag(), out.x);
  hn::StoreU(v.y, Tag(), out.y);
  hn::StoreU(v.z, Tag(), out.z);
  return out;
}

// The drop's constants for rays from one side.
struct DropLanes {
  const HarmonicSurface<double>& surface;
  std::array<bool, max_harmonic_degree + 1> has_sine = {};  // by place in surface.orders
  double bound_h = 1;
  double outside_bend = 0, inside_bend = 0;  // how fast the walk's slope may fall

  explicit DropLanes(const DropInstant& drop) : surface(drop.surface), bound_h(drop.bound_h) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(surface.order_count); ++i) {
      const auto& order = surface.orders[i];
      for (const double b : order.b) has_sine[i] = has_sine[i] || (order.m > 0 && b != 0);
    }
    // A sphere's bound from outside is 0; any larger one is as safe.
    outside_bend = std::max(1e-6, walk_bend(drop, RaySide::outside));
    inside_bend = walk_bend(drop, RaySide::inside);
  }
};

struct SurfaceLanes {
  Lanes h;
  Lanes3 gradient;
};

struct HornerLanes {
  Lanes value, slope;
};

HWY_INLINE HornerLanes horner(const double* coefficients, int degree, Lanes z) {
  HornerLanes p = {all(coefficients[degree]), hn::Zero(Tag())};
  for (int k = degree - 1; k >= 0; --k) {
    p.slope = hn::MulAdd(p.slope, z, p.value);
    p.value = hn::MulAdd(p.value, z, all(coefficients[k]));
  }
  return p;
}

// evaluate() of oscillation/harmonic_surface.h.
HWY_INLINE SurfaceLanes evaluate_lanes(const DropLanes& drop, const Lanes3& u) {
  const Lanes zero = hn::Zero(Tag());
  SurfaceLanes sum = {zero, {zero, zero, zero}};
  Lanes re = all(1.0), im = zero, re_below = zero, im_below = zero;
  int power = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(drop.surface.order_count); ++i) {
    const auto& order = drop.surface.orders[i];
    for (; power < order.m; ++power) {
      re_below = re;
      im_below = im;
      re = hn::MulSub(re_below, u.x, im_below * u.y);
      im = hn::MulAdd(re_below, u.y, im_below * u.x);
    }
    const Lanes m = all(order.m);
    const HornerLanes a = horner(order.a.data(), order.degree, u.z);
    sum.h = hn::MulAdd(a.value, re, sum.h);
    sum.gradient.z = hn::MulAdd(a.slope, re, sum.gradient.z);
    sum.gradient.x = hn::MulAdd(m * a.value, re_below, sum.gradient.x);
    sum.gradient.y = hn::NegMulAdd(m * a.value, im_below, sum.gradient.y);
    if (!drop.has_sine[i]) continue;
    const HornerLanes b = horner(order.b.data(), order.degree, u.z);
    sum.h = hn::MulAdd(b.value, im, sum.h);
    sum.gradient.z = hn::MulAdd(b.slope, im, sum.gradient.z);
    sum.gradient.x = hn::MulAdd(m * b.value, im_below, sum.gradient.x);
    sum.gradient.y = hn::MulAdd(m * b.value, re_below, sum.gradient.y);
  }
  return sum;
}

// A ray in the plane through the star centre; lengths over the drop's scale.
struct RayLanes {
  Lanes3 e, d;
  Lanes b;
  Lanes c, s;  // of the origin's angle
};

HWY_INLINE RayLanes ray_lanes(const Lanes3& origin, const Lanes3& direction) {
  const Lanes one = all(1.0), zero = hn::Zero(Tag());
  RayLanes ray;
  const Lanes along = dot(origin, direction);
  const Lanes3 closest = mul_add(direction, zero - along, origin);
  ray.b = hn::Sqrt(dot(closest, closest));
  const LaneMask off_centre = ray.b > all(1e-14);
  ray.e = choose(off_centre, times(closest, one / hn::IfThenElse(off_centre, ray.b, one)),
                 across(direction));
  ray.d = direction;
  const Lanes length = hn::Sqrt(hn::MulAdd(along, along, ray.b * ray.b));
  const LaneMask at_centre = length == zero;
  const Lanes reciprocal = one / hn::IfThenElse(at_centre, one, length);
  ray.c = hn::IfThenElse(at_centre, one, ray.b * reciprocal);
  ray.s = along * reciprocal;
  return ray;
}

// Values at the lanes' angles.
struct PointLanes {
  Lanes3 u;
  SurfaceLanes surface;
  Lanes g, slope;  // G and G'
};

HWY_INLINE PointLanes point_lanes(const DropLanes& drop, const RayLanes& ray) {
  PointLanes p;
  p.u = mul_add(ray.e, ray.c, times(ray.d, ray.s));
  const Lanes3 ahead = mul_add(ray.d, ray.c, times(ray.e, hn::Zero(Tag()) - ray.s));
  p.surface = evaluate_lanes(drop, p.u);
  p.g = hn::MulSub(p.surface.h, ray.c, ray.b);
  p.slope = hn::MulSub(dot(p.surface.gradient, ahead), ray.c, p.surface.h * ray.s);
  return p;
}

// Largest step h >= 0 with f + f' t - m t^2 / 2 >= 0 on [0, h]; f >= 0, m > 0.
HWY_INLINE Lanes safe_step_lanes(Lanes f, Lanes slope, double m) {
  const Lanes root = hn::Sqrt(hn::MulAdd(slope, slope, all(2 * m) * f));
  const LaneMask falls = slope < hn::Zero(Tag());
  return hn::IfThenElse(falls, f + f, slope + root) / hn::IfThenElse(falls, root - slope, all(m));
}

// Turns (c, s) by at most `step`, and keeps it on the unit circle.
HWY_INLINE void turn_lanes(RayLanes& ray, Lanes step, LaneMask active) {
  const Lanes one = all(1.0);
  // 1.5 < pi / 2: one turn is at most 2 atan(2.625) = 2.41 < pi, so no turn passes the far side.
  const Lanes x = hn::Min(all(0.5) * step, all(1.5));
  const Lanes t = hn::MulAdd(x * x, x * all(1.0 / 3), x);
  const Lanes t2 = t * t;
  const Lanes reciprocal = one / (one + t2);
  const Lanes turn_c = (one - t2) * reciprocal, turn_s = (t + t) * reciprocal;
  const Lanes c = hn::MulSub(ray.c, turn_c, ray.s * turn_s);
  const Lanes s = hn::MulAdd(ray.s, turn_c, ray.c * turn_s);
  const Lanes unit = hn::NegMulAdd(all(0.5), hn::MulAdd(c, c, s * s), all(1.5));
  ray.c = hn::IfThenElse(active, c * unit, ray.c);
  ray.s = hn::IfThenElse(active, s * unit, ray.s);
}

struct RootLanes {
  LaneMask found;
  PointLanes point;  // of the lanes that found
};

// The first root of G ahead of the rays' origins, for the lanes of `active`.
template <RaySide side>
HWY_INLINE RootLanes first_root_lanes(const DropLanes& drop, RayLanes ray, LaneMask active) {
  constexpr bool outside = side == RaySide::outside;
  const Lanes zero = hn::Zero(Tag());
  const Lanes bound = all(drop.bound_h);
  const double bend = outside ? drop.outside_bend : drop.inside_bend;
  LaneMask found = zero < zero;
  if (outside) active = hn::And(active, ray.b < bound);
  for (int step = 0; step < walk_step_limit; ++step) {
    // A lane that has finished stands still: its point stays what it was.
    const PointLanes p = point_lanes(drop, ray);
    if (outside) {
      const LaneMask passed = hn::And(ray.s > zero, ray.c * bound < ray.b);
      active = hn::AndNot(passed, active);
    }
    const Lanes f = hn::Max(zero, outside ? zero - p.g : p.g);
    const Lanes slope = outside ? zero - p.slope : p.slope;
    const LaneMask ends = hn::And(f <= all(walk_root_tolerance), slope <= zero);
    const Lanes h = safe_step_lanes(f, slope, bend);
    LaneMask root = ends;
    if (step == 0) {  // at its own start a ray leaves, or grazes and is lost
      root = outside ? hn::And(ends, slope < zero) : found;
    } else {  // below the spacing of doubles the ray stands on the root
      root = hn::Or(ends, h <= all(1e-15));
    }
    found = hn::Or(found, hn::And(active, root));
    active = hn::AndNot(hn::Or(ends, root), active);
    if (hn::AllFalse(Tag(), active)) return {found, p};
    turn_lanes(ray, h, active);
    const LaneMask over = hn::And(active, ray.c <= zero);
    if (outside) {
      active = hn::AndNot(over, active);
    } else {
      ray.c = hn::IfThenElse(over, zero, ray.c);
      ray.s = hn::IfThenElse(over, all(1.0), ray.s);
    }
  }
  throw std::logic_error("drop intersection: no root within 10000 certified steps");
}

// Position (over the scale, from the star centre) and outward unit normal.
struct MeetingLanes {
  Lanes3 position, normal;
};

HWY_INLINE MeetingLanes meeting_lanes(const PointLanes& p) {
  const Lanes along = dot(p.surface.gradient, p.u);
  const Lanes3 tangential = mul_add(p.u, hn::Zero(Tag()) - along, p.surface.gradient);
  const Lanes3 normal = normalised(mul_add(tangential, all(-1.0) / p.surface.h, p.u));
  return {times(p.u, p.surface.h), normal};
}

}  // namespace pluvia::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
