#include "raytrace/optics.h"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"
#include "tests/table_file.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double water = 1.333;

// A unit normal that meets `direction` at the given angle of incidence, in a random plane.
Eigen::Vector3d normal_at(const Eigen::Vector3d& direction, double incidence_rad, Random& random) {
  const Eigen::Vector3d e1 = direction.unitOrthogonal(), e2 = direction.cross(e1);
  const double turn = uniform(random, 0, 2 * pi);
  const Eigen::Vector3d across = std::cos(turn) * e1 + std::sin(turn) * e2;
  return (std::sin(incidence_rad) * across - std::cos(incidence_rad) * direction).normalized();
}

// Any coherent pair of polarisations, not only the unpolarised one.
Beam random_beam(Random& random) {
  Beam beam = unpolarised_beam(random_direction(random));
  const Eigen::Vector3d e1 = beam.field.col(0), e2 = beam.field.col(2);
  for (int k = 0; k < 4; ++k) {
    beam.field.col(k) = uniform(random, -1, 1) * e1 + uniform(random, -1, 1) * e2;
  }
  return beam;
}

TEST(Optics, ReflectancesAreTheTables) {
  const auto rows = table_rows("fresnel_n1333.csv");
  ASSERT_EQ(rows.size(), 181u);
  for (const auto& row : rows) {
    const double cosine = std::max(0.0, std::cos(std::stod(row[0]) * pi / 180));
    const FresnelPower r = fresnel_reflectance(cosine, 1 / water);
    EXPECT_NEAR(r.s, std::stod(row[2]), 1e-9) << row[0];
    EXPECT_NEAR(r.p, std::stod(row[3]), 1e-9) << row[0];
  }
}

TEST(Optics, AtBrewstersAngleNothingPolarisedInThePlaneIsReflected) {
  const double brewster = std::atan(water);
  EXPECT_LT(fresnel_reflectance(std::cos(brewster), 1 / water).p, 1e-30);
  // From within the complement reflects nothing either.
  EXPECT_LT(fresnel_reflectance(std::sin(brewster), water).p, 1e-30);
  EXPECT_GT(fresnel_reflectance(std::cos(brewster), 1 / water).s, 0.07);
}

TEST(Optics, TotalReflectionBeginsAtTheCriticalAngle) {
  const double critical = std::asin(1 / water);
  Random random(1);
  for (const double offset : {-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3, 0.5}) {
    const Beam beam = unpolarised_beam(random_direction(random));
    const Eigen::Vector3d normal = normal_at(beam.direction, critical + offset, random);
    const Split split = split_at_interface(beam, normal, water);
    EXPECT_EQ(split.totally_reflected, offset > 0) << offset;
    EXPECT_NEAR(power(split.reflected) + power(split.refracted), 1, 1e-14) << offset;
    // The refracted ray runs along the surface, and tends to it from below.
    EXPECT_NEAR(split.refracted.direction.dot(normal), 0, offset > 0 ? 1e-15 : 0.06) << offset;
    // 1 - R ~ 4.6 sqrt(2 offset) below; exactly 1 above.
    const FresnelPower r = fresnel_reflectance(std::cos(critical + offset), water);
    EXPECT_EQ(r.s == 1 && r.p == 1, offset > 0) << offset;
  }
}

TEST(Optics, ReflectanceIsTheSameFromBothSides) {
  for (double i = 0; i < pi / 2; i += 0.01) {
    const double cos_inside = std::sqrt(1 - std::pow(std::sin(i) / water, 2));
    const FresnelPower in = fresnel_reflectance(std::cos(i), 1 / water);
    const FresnelPower out = fresnel_reflectance(cos_inside, water);
    // From inside the small outer cosine comes from a difference: error 1e-16 / cos i, times 4 n.
    EXPECT_NEAR(in.s, out.s, 2e-15 / std::cos(i)) << i;
    EXPECT_NEAR(in.p, out.p, 2e-15 / std::cos(i)) << i;
  }
}

TEST(Optics, PowerIsKeptPerPolarisationInAnyPlaneOfIncidence) {
  // 1e-14: some ten roundings. Incidence also within 1e-13 of normal, where the plane of incidence
  // is nearly undetermined, and within 1e-12 of grazing.
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Beam beam = random_beam(random);
    const double tiny = std::pow(10, uniform(random, -13, 0));
    const double incidence = i % 3 == 0   ? tiny
                             : i % 3 == 1 ? pi / 2 - tiny
                                          : uniform(random, 0, 1.5);
    const Eigen::Vector3d normal = normal_at(beam.direction, std::abs(incidence), random);
    if (normal.dot(beam.direction) > 0) continue;
    for (const double ratio : {1 / water, water, 1.0, 1 + 1e-9}) {
      const Split split = split_at_interface(beam, normal, ratio);
      for (int k = 0; k < 4; k += 2) {
        const double before = beam.field.middleCols<2>(k).squaredNorm();
        const double after = split.reflected.field.middleCols<2>(k).squaredNorm() +
                             split.refracted.field.middleCols<2>(k).squaredNorm();
        ASSERT_NEAR(after / before, 1, 1e-14) << "incidence " << incidence << ", ratio " << ratio;
      }
    }
  }
}

TEST(Optics, FieldsStayAcrossTheBeamAndDirectionsObeySnellsLaw) {
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    const Beam beam = random_beam(random);
    const double incidence = std::pow(10, uniform(random, -12, 0.19));
    const Eigen::Vector3d normal = normal_at(beam.direction, incidence, random);
    for (const double ratio : {1 / water, water}) {
      const Split split = split_at_interface(beam, normal, ratio);
      EXPECT_LT((split.reflected.field.transpose() * split.reflected.direction).norm(), 1e-14);
      EXPECT_LT((split.refracted.field.transpose() * split.refracted.direction).norm(), 1e-14);
      EXPECT_NEAR(split.reflected.direction.norm(), 1, 1e-15);
      const Eigen::Vector3d mirrored = beam.direction - 2 * beam.direction.dot(normal) * normal;
      EXPECT_LT((split.reflected.direction - mirrored).norm(), 1e-14);
      if (split.totally_reflected) continue;
      // n1 d1 x normal = n2 d2 x normal, as vectors.
      const Eigen::Vector3d before = ratio * beam.direction.cross(normal);
      EXPECT_LT((split.refracted.direction.cross(normal) - before).norm(), 1e-14) << incidence;
    }
  }
}

TEST(Optics, WithoutAStepOfIndexThereIsNoInterface) {
  // Also at grazing incidence, where 1 - cos^2 rounds to 1.
  Random random(4);
  for (const double cosine : {1.0, 0.7, 1e-3, 1e-8, 1e-12}) {
    const Beam beam = random_beam(random);
    const Eigen::Vector3d normal = normal_at(beam.direction, std::acos(cosine), random);
    if (normal.dot(beam.direction) >= 0) continue;  // acos of 1e-12 may round beyond grazing
    const Split split = split_at_interface(beam, normal, 1);
    EXPECT_FALSE(split.totally_reflected) << cosine;
    EXPECT_LT(power(split.reflected), 1e-30) << cosine;
    EXPECT_LT((split.refracted.direction - beam.direction).norm(), 1e-15) << cosine;
    EXPECT_LT((split.refracted.field - beam.field).norm(), 1e-14) << cosine;
  }
  for (const double cosine : {1e-12, 0.0, -1e-12, -0.3}) {
    EXPECT_EQ(fresnel_reflectance(cosine, 1).s, 0);
    EXPECT_EQ(fresnel_reflectance(cosine, 1).p, 0);
  }
}

TEST(Optics, WithoutAStepOfIndexABeamGoesOnBeyondGrazingToo) {
  // The general formulas would be 0 / 0 there.
  for (const double cosine : {0.0, -1e-12, -1e-3, -0.3}) {
    const Beam beam = unpolarised_beam({1, 0, 0});
    const Eigen::Vector3d normal = {-cosine, std::sqrt(1 - cosine * cosine), 0};
    const Split split = split_at_interface(beam, normal, 1);
    EXPECT_EQ(power(split.reflected), 0) << cosine;
    EXPECT_EQ(split.refracted.direction, beam.direction) << cosine;
    EXPECT_EQ(split.refracted.field, beam.field) << cosine;
    EXPECT_EQ(refracted_direction(beam.direction, normal, 1), beam.direction) << cosine;
    EXPECT_TRUE(split.reflected.direction.allFinite()) << cosine;
  }
}

TEST(Optics, ATinyStepOfIndexReflectsHalfItsSizeSquared) {
  // At normal incidence R = ((n - 1) / (n + 1))^2 = 2.5e-19 for n = 1 + 1e-9; the step itself is
  // known to 1e-16 / 1e-9 in double precision.
  EXPECT_NEAR(fresnel_reflectance(1, 1 + 1e-9).s / 2.5e-19, 1, 1e-6);
  // At cos = 1e-3 entering the denser side (ratio 1 - 1e-9): s reflects ((n - 1) / (2 cos^2))^2 =
  // (5e-4)^2, to first order in 1e-9 / cos^2 = 1e-3.
  EXPECT_NEAR(fresnel_reflectance(1e-3, 1 / (1 + 1e-9)).s / 2.5e-7, 1, 3e-3);
}

// Flux that leaves a sphere of index n with order 2 in one polarisation, traced along a plane.
double traced_order_two(double n, bool s_polarised) {
  double sum = 0;
  const int rays = 4000;
  for (int k = 0; k < rays; ++k) {
    const double i = pi / 2 * (k + 0.5) / rays;
    Beam beam;
    beam.direction = {1, 0, 0};
    // The sphere's points lie in the plane z = 0: s is along z.
    beam.field.col(0) = s_polarised ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, 1, 0);
    Eigen::Vector3d point = {-std::cos(i), std::sin(i), 0};
    beam = split_at_interface(beam, point, 1 / n).refracted;
    for (int segment = 0; segment < 2; ++segment) {
      point -= 2 * point.dot(beam.direction) * beam.direction;  // the chord's other end
      const Split split = split_at_interface(beam, -point, n);
      beam = segment == 0 ? split.reflected : split.refracted;
    }
    sum += beam.field.squaredNorm() * std::sin(2 * i) * pi / 2 / rays;
  }
  return sum;
}

TEST(Optics, TheChainThroughASphereKeepsItsPolarisationsApart) {
  // Against the table's quadrature of (1 - R)^2 R, s and p apart; midpoints in the angle: 1e-6.
  int compared = 0;
  for (const auto& row : table_rows("sphere_energy_fractions.csv")) {
    if (row[1] != "2") continue;
    const double n = std::stod(row[0]);
    EXPECT_NEAR(traced_order_two(n, true), std::stod(row[3]), 1e-6) << n;
    EXPECT_NEAR(traced_order_two(n, false), std::stod(row[4]), 1e-6) << n;
    ++compared;
  }
  EXPECT_EQ(compared, 4);
}

// Stokes vector in the basis (s, d x s): the second road to the power of a beam.
struct Stokes {
  double i = 1, q = 0;
  std::complex<double> u_iv = 0;  // U + i V = 2 Es conj(Ep)
  Eigen::Vector3d s = {0, 0, 1};
};

Stokes turned_to(const Stokes& light, const Eigen::Vector3d& direction, const Eigen::Vector3d& s) {
  const double angle = std::atan2(s.dot(direction.cross(light.s)), s.dot(light.s));
  const double c = std::cos(2 * angle), si = std::sin(2 * angle);
  return {light.i,
          light.q * c + light.u_iv.real() * si,
          {-light.q * si + light.u_iv.real() * c, light.u_iv.imag()},
          s};
}

Stokes scaled(const Stokes& light, std::complex<double> s, std::complex<double> p) {
  const double ss = std::norm(s), pp = std::norm(p);
  return {0.5 * (ss + pp) * light.i + 0.5 * (ss - pp) * light.q,
          0.5 * (ss - pp) * light.i + 0.5 * (ss + pp) * light.q, s * std::conj(p) * light.u_iv,
          light.s};
}

// Complex Fresnel amplitudes with indices n1, n2; p's sign for axes d x s on both sides.
struct Amplitudes {
  std::complex<double> rs, rp, ts, tp;
};

Amplitudes amplitudes(double n1, double n2, double cos_incidence) {
  const std::complex<double> ci = cos_incidence;
  const std::complex<double> ct = std::sqrt(1.0 - std::pow(n1 / n2, 2) * (1.0 - ci * ci));
  const std::complex<double> root = 2.0 * std::sqrt(n1 * n2 * ci * ct);
  return {(n1 * ci - n2 * ct) / (n1 * ci + n2 * ct), (n2 * ci - n1 * ct) / (n2 * ci + n1 * ct),
          root / (n1 * ci + n2 * ct), root / (n2 * ci + n1 * ct)};
}

TEST(Optics, ChainsThroughTurnedPlanesOfIncidenceMatchMuellerCalculus) {
  // In, three reflections inside (some total, which turn linear into elliptic light), out: every
  // plane of incidence at random. Power by fields against power by Stokes vectors.
  Random random(5);
  int total_reflections = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Beam beam = unpolarised_beam(random_direction(random));
    Stokes light;
    light.s = beam.direction.unitOrthogonal();
    for (int step = 0; step < 5; ++step) {
      const double n1 = step == 0 ? 1 : water, n2 = step == 0 ? water : 1;
      const bool transmit = step == 0 || step == 4;
      const double incidence = uniform(random, 0.05, step == 4 ? 0.8 : 1.5);
      const Eigen::Vector3d normal = normal_at(beam.direction, incidence, random);
      light = turned_to(light, beam.direction, beam.direction.cross(normal).normalized());
      const Amplitudes a = amplitudes(n1, n2, -beam.direction.dot(normal));
      const Split split = split_at_interface(beam, normal, n1 / n2);
      light = transmit ? scaled(light, a.ts, a.tp) : scaled(light, a.rs, a.rp);
      total_reflections += split.totally_reflected ? 1 : 0;
      beam = transmit ? split.refracted : split.reflected;
      ASSERT_NEAR(power(beam), light.i, 1e-13) << "trial " << trial << ", step " << step;
    }
  }
  EXPECT_GT(total_reflections, 1000);
}

}  // namespace
}  // namespace pluvia
