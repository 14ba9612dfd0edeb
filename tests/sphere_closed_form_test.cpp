#include "raytrace/sphere_closed_form.h"

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

using Row = std::map<std::string, std::string>;

// A table of data/tables: lines by the names of the head, comments left out.
std::vector<Row> read_table(const std::string& name) {
  std::ifstream in(PLUVIA_SOURCE_DIR "/data/tables/" + name);
  std::vector<std::string> head;
  std::vector<Row> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (head.empty()) {
      head = cells;
      continue;
    }
    Row row;
    for (std::size_t k = 0; k < head.size(); ++k) row[head[k]] = cells.at(k);
    rows.push_back(row);
  }
  EXPECT_FALSE(rows.empty()) << name;
  return rows;
}

double number(const Row& row, const std::string& key) {
  return std::stod(row.at(key));
}

TEST(SphereClosedForm, IntensityAtAnAngleIsTheLimitOfNarrowingCones) {
  // A cone of 0.5 degrees averages over I'' cone^2 / 8, below 1e-3 of I at these angles; the cone's
  // own quadrature of 1e5 points errs by up to 2e-3 for one so small.
  for (const double angle : {20.0, 60.0, 75.0, 110.0, 120.0, 150.0, 165.0}) {
    for (const int max_order : {0, 1, 3}) {
      EXPECT_NEAR(sphere_intensity(1.333, max_order, angle * degree) /
                      sphere_intensity_in_cone(1.333, max_order, angle * degree, 0.5 * degree),
                  1, 4e-3)
          << angle << ", order " << max_order;
    }
  }
}

TEST(SphereClosedForm, IntensityOfReflectionIsAQuarterOfFresnelsShare) {
  // A mirror sphere scatters 1 / (4 pi) of what it cuts out to every direction, here times R at
  // incidence (pi - angle) / 2.
  for (const double angle : {0.01, 0.7, 1.5, 3.1}) {
    const double reflectance = sphere_throughput(1.333, 0, std::cos(angle / 2));
    EXPECT_NEAR(sphere_intensity(1.333, 0, angle) / (reflectance / (4 * pi)), 1, 1e-9) << angle;
  }
}

TEST(SphereClosedForm, EnergiesAreThoseOfTheTable) {
  // The table has 12 decimals; a midpoint rule of 1e5 smooth points is better than 1e-9.
  int compared = 0;
  for (const Row& row : read_table("sphere_energy_fractions.csv")) {
    const double n = number(row, "n");
    const int p = std::stoi(row.at("p"));
    if (p > 6) continue;
    EXPECT_NEAR(sphere_energy(n, p), number(row, "unpol_exact"), 1e-9) << "n " << n << ", p " << p;
    ++compared;
  }
  EXPECT_GE(compared, 7);
}

TEST(SphereClosedForm, AllOrdersTogetherReturnAllLight) {
  double sum = 0;
  for (int p = 0; p <= 60; ++p) sum += sphere_energy(1.333, p);
  // The table's p = 9 still holds 6e-5, falling as p^-3.6 or so: beyond 60 about 1e-6 is left.
  EXPECT_NEAR(sum, 1, 3e-6);
  EXPECT_LT(sum, 1);
}

TEST(SphereClosedForm, RainbowsAreThoseOfTheTable) {
  for (const Row& row : read_table("sphere_rainbow_angles.csv")) {
    const int p = std::stoi(row.at("p"));
    const double n = number(row, "n"), b = number(row, "b_over_a");
    EXPECT_NEAR(sphere_rainbow_rad(n, p) / degree, number(row, "theta_deg"), 1e-7) << n << " " << p;
    EXPECT_NEAR(sphere_throughput(n, p, b), number(row, "eps_unpol"), 1e-8) << n << " " << p;
    // b is given to 8 digits, and the angle is stationary there.
    EXPECT_NEAR(sphere_scattering_angle_rad(n, p, b), sphere_rainbow_rad(n, p), 1e-9);
  }
}

TEST(SphereClosedForm, ThroughputStaysBetweenNothingAndAllUpToTheRim) {
  for (const double n : {1.1, 1.333, 2.0}) {
    for (int p = 0; p <= 6; ++p) {
      for (const double b : {0.0, 1e-12, 0.5, 1 - 1e-15, 1.0}) {
        const double share = sphere_throughput(n, p, b);
        EXPECT_TRUE(share >= 0 && share <= 1) << "n " << n << ", p " << p << ", b " << b;
      }
      // At the rim everything is reflected outside and nothing gets in.
      EXPECT_NEAR(sphere_throughput(n, p, 1), p == 0 ? 1 : 0, 1e-12);
    }
  }
}

// Mean of the table's 1-degree rings over a cone, each ring weighted with the solid angle that it
// shares with the cone: sub-rings of 0.01 degree, closed form for the share of a circle in a cap.
double cone_mean_of_rings(const std::vector<Row>& rings, double centre, double cone,
                          int max_order) {
  double sum = 0;
  for (const Row& ring : rings) {
    double value = 0;
    for (int p = 0; p <= max_order; ++p) value += number(ring, fmt::format("p{}", p));
    for (int k = 0; k < 100; ++k) {
      const double theta = (number(ring, "theta_lo_deg") + (k + 0.5) / 100) * degree;
      const double c = (std::cos(cone) - std::cos(theta) * std::cos(centre)) /
                       (std::sin(theta) * std::sin(centre));
      const double share = c >= 1 ? 0 : c <= -1 ? 1 : std::acos(c) / pi;
      sum += value * share * 2 * pi * std::sin(theta) * 0.01 * degree;
    }
  }
  return sum / (2 * pi * (1 - std::cos(cone)));
}

TEST(SphereClosedForm, LightOfACircularSourceIsTheMeanOfTheTablesRings) {
  // The closed form divides by pi sin^2(cone), the light's irradiance; the rings by solid angle:
  // the ratio of both normalisations is (1 + cos cone) / 2 away. Rings are flat within a degree,
  // which at 10 degrees of cone costs up to the change over half a ring at its rim: 0.3 % where the
  // caustics are inside, and up to 1.5 % where the rim cuts the bright side of a bow.
  const std::vector<Row> rings = read_table("sphere_go_binned_1deg.csv");
  const double cone = 10 * degree;
  for (const double angle : {12.0, 30.0, 60.0, 83.0, 100.0, 129.0, 138.0, 150.0, 168.0}) {
    const double ours = sphere_intensity_in_cone(1.333, 3, angle * degree, cone);
    const double theirs =
        cone_mean_of_rings(rings, angle * degree, cone, 3) * 2 / (1 + std::cos(cone));
    EXPECT_NEAR(ours / theirs, 1, angle > 110 && angle < 160 ? 0.015 : 0.003)
        << angle << " degrees";
  }
}

TEST(SphereClosedForm, NarrowLightAwayFromCausticsIsTheTablesPointValue) {
  // 0.5 degrees of cone: second derivatives of the curve change the mean by cone^2 / 8 f'' / f,
  // below 5e-4 at these angles; the quadrature is good for 1e-3 at that cone (some hundred points
  // in it).
  for (const Row& row : read_table("sphere_geometric_optics.csv")) {
    const double angle = number(row, "theta_deg");
    for (const double wanted : {20.0, 40.0, 60.0, 100.0, 115.0, 160.0}) {
      if (std::abs(angle - wanted) > 1e-9) continue;
      const double ours = sphere_intensity_in_cone(1.333, 3, angle * degree, 0.5 * degree);
      double theirs = 0;
      for (int p = 0; p <= 3; ++p) theirs += number(row, fmt::format("p{}", p));
      EXPECT_NEAR(ours / theirs, 1, 2e-3) << angle << " degrees";
    }
  }
}

TEST(SphereClosedForm, IntensityIsFiniteStraightOnStraightBackAndOnTheBows) {
  for (const double cone : {0.2 * degree, 1 * degree, 30 * degree}) {
    for (const double angle :
         {0.0, pi, sphere_rainbow_rad(1.333, 2), sphere_rainbow_rad(1.333, 3)}) {
      const double value = sphere_intensity_in_cone(1.333, 3, angle, cone);
      EXPECT_TRUE(std::isfinite(value) && value > 0) << "angle " << angle << ", cone " << cone;
    }
  }
  // Straight on, the glory's p = 3 aside: p = 1 is 1.2236 and p = 0 0.0785 in the table's first
  // row.
  EXPECT_NEAR(sphere_intensity_in_cone(1.333, 1, 0, degree), 1.2236 + 0.0765, 0.01);
}

TEST(SphereClosedForm, WholeSphereOfLightsReturnsTheEnergyOfTheOrders) {
  // Integral over directions of the cone means times their common normalisation: every ray is in
  // cones of solid angle 2 pi (1 - cos cone) in total, whatever its direction.
  const double cone = 8 * degree;
  double sum = 0;
  const int rings = 90;
  for (int k = 0; k < rings; ++k) {
    const double angle = (k + 0.5) * pi / rings;
    sum += sphere_intensity_in_cone(1.333, 3, angle, cone) * 2 * pi * std::sin(angle) * pi / rings;
  }
  double energy = 0;
  for (int p = 0; p <= 3; ++p) energy += sphere_energy(1.333, p);
  const double normalisation = 2 * pi * (1 - std::cos(cone)) / (pi * std::pow(std::sin(cone), 2));
  EXPECT_NEAR(sum / normalisation, energy, 2e-3);
}

TEST(SphereClosedForm, LightIsSeenWhereItsRaysLeave) {
  for (const double angle : {0.3, 1.0, 2.0, 3.0}) {
    // A mirror shows the lamp at incidence (pi - angle) / 2, on the lamp's side.
    EXPECT_NEAR(sphere_light_position(1.333, 0, angle), std::cos(angle / 2), 1e-12) << angle;
  }
  // A lens shows it upside down: small angles are 2 (b - b / n), and reflection is 2 % of that.
  const double angle = 0.02, b = angle / 2 / (1 - 1 / 1.333);
  const double reflected = sphere_intensity(1.333, 0, angle) / sphere_intensity(1.333, 1, angle);
  EXPECT_NEAR(sphere_light_position(1.333, 1, angle),
              reflected * std::cos(angle / 2) - (1 - reflected) * b, 1e-4);
}

}  // namespace
}  // namespace pluvia
