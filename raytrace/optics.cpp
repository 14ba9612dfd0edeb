#include "raytrace/optics.h"

#include <cassert>
#include <cmath>

#include <Eigen/Geometry>

namespace pluvia {

namespace {

using FieldRow = Eigen::Matrix<double, 1, 4>;

// Multiplies the complex numbers of a row by (re + i im).
FieldRow times(const FieldRow& row, double re, double im) {
  return {row[0] * re - row[1] * im, row[0] * im + row[1] * re, row[2] * re - row[3] * im,
          row[2] * im + row[3] * re};
}

// Unit vector perpendicular to the plane of incidence; any one across the beam at normal incidence,
// where s and p are alike.
Eigen::Vector3d s_axis(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal) {
  Eigen::Vector3d s = direction.cross(normal);
  // A short product is partly rounding, also along the beam: that part would cost power.
  s -= s.dot(direction) * direction;
  const double length2 = s.squaredNorm();
  if (length2 < 1e-24) return direction.unitOrthogonal();
  return s / std::sqrt(length2);
}

}  // namespace

Beam unpolarised_beam(const Eigen::Vector3d& direction) {
  Beam beam;
  beam.direction = direction;
  beam.field.col(0) = direction.unitOrthogonal();
  beam.field.col(2) = direction.cross(beam.field.col(0));
  return beam;
}

double power(const Beam& beam) {
  return 0.5 * beam.field.squaredNorm();
}

// Written so that nothing cancels for a ratio near 1, where 1 - ratio^2 sin^2 loses a small cosine.
double squared_cosine_refracted(double cos_incidence, double index_ratio) {
  const double c = index_ratio * cos_incidence;
  return (1 - index_ratio) * (1 + index_ratio) + c * c;
}

Eigen::Vector3d refracted_direction(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                    double index_ratio) {
  if (index_ratio == 1) return direction.normalized();
  const double ci = -direction.dot(normal);
  const double ct2 = squared_cosine_refracted(ci, index_ratio);
  const double ct = ct2 > 0 ? std::sqrt(ct2) : 0;
  return (index_ratio * direction + (index_ratio * ci - ct) * normal).normalized();
}

Split split_at_interface(const Beam& beam, const Eigen::Vector3d& normal, double index_ratio) {
  const Eigen::Vector3d& d = beam.direction;
  const double ci = -d.dot(normal);
  assert(index_ratio > 0);
  const Eigen::Vector3d s = s_axis(d, normal);
  const FieldRow fs = s.transpose() * beam.field;
  const FieldRow fp = d.cross(s).transpose() * beam.field;

  Split out;
  out.power_s = 0.5 * fs.squaredNorm();
  out.power_p = 0.5 * fp.squaredNorm();
  out.refracted.direction = refracted_direction(d, normal, index_ratio);
  out.reflected.direction = (d + 2 * ci * normal).normalized();
  const Eigen::Vector3d p_reflected = out.reflected.direction.cross(s);
  if (index_ratio == 1) {  // past grazing the formulas below would divide by zero
    out.refracted = beam;
    return out;
  }
  const double ct2 = squared_cosine_refracted(ci, index_ratio);
  if (ct2 <= 0) {
    // Total reflection: r = (a - i b)/(a + i b) has modulus 1 and a phase that differs for s and p.
    out.totally_reflected = true;
    const double kappa = std::sqrt(-ct2);
    const auto phase = [](double a, double b) {
      const double norm = a * a + b * b;
      return Eigen::Vector2d((a * a - b * b) / norm, -2 * a * b / norm);
    };
    const Eigen::Vector2d rs = phase(index_ratio * ci, kappa);
    const Eigen::Vector2d rp = phase(ci, index_ratio * kappa);
    out.reflected.field = s * times(fs, rs[0], rs[1]) + p_reflected * times(fp, rp[0], rp[1]);
    return out;
  }
  const double ct = std::sqrt(ct2);
  const double rs = (index_ratio * ci - ct) / (index_ratio * ci + ct);
  const double rp = (ci - index_ratio * ct) / (ci + index_ratio * ct);
  const double root = 2 * std::sqrt(index_ratio * std::abs(ci) * ct);  // sqrt(4 n1 n2 ci ct) / n2
  const double ts = root / (index_ratio * ci + ct);
  const double tp = root / (ci + index_ratio * ct);
  out.reflected.field = s * (rs * fs) + p_reflected * (rp * fp);
  out.refracted.field = s * (ts * fs) + out.refracted.direction.cross(s) * (tp * fp);
  return out;
}

FresnelPower fresnel_reflectance(double cos_incidence, double index_ratio) {
  if (index_ratio == 1) return {0, 0};
  const double ct2 = squared_cosine_refracted(cos_incidence, index_ratio);
  if (ct2 <= 0) return {1, 1};
  const double ct = std::sqrt(ct2);
  const double rs = (index_ratio * cos_incidence - ct) / (index_ratio * cos_incidence + ct);
  const double rp = (cos_incidence - index_ratio * ct) / (cos_incidence + index_ratio * ct);
  return {rs * rs, rp * rp};
}

}  // namespace pluvia
