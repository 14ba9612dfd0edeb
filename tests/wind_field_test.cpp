// Wind of primitives and its grid (raytrace/wind_field.h, raytrace/wind_grid.h).
#include "raytrace/wind_field.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/wind_grid.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
using Field = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

WindPrimitive tilted(WindKind kind) {
  return {.kind = kind,
          .position_m = {0.3, -0.2, -4},
          .axis = Eigen::Vector3d(0.2, -0.3, 1).normalized(),
          .strength = 9,
          .inflow = kind == WindKind::tornado ? 0.5 : 0,
          .core_radius_m = 0.7,
          .height_m = 8};
}

std::array<WindPrimitive, 4> one_of_each() {
  return {tilted(WindKind::uniform), tilted(WindKind::source), tilted(WindKind::vortex),
          tilted(WindKind::tornado)};
}

// Of the sixth order: (45 (f1 - f-1) - 9 (f2 - f-2) + f3 - f-3) / 60 d; its error is d^6 / 140 of
// the seventh derivative, its rounding about 2e-16 |V| / d.
double divergence_1_s(const Field& field, const Eigen::Vector3d& at_m, double d_m) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const auto between = [&](int k) {
      const Eigen::Vector3d step = k * d_m * Eigen::Vector3d::Unit(i);
      return field(at_m + step)[i] - field(at_m - step)[i];
    };
    sum += (45 * between(1) - 9 * between(2) + between(3)) / (60 * d_m);
  }
  return sum;
}

Eigen::Vector3d somewhere(std::mt19937& random, double reach_m) {
  std::uniform_real_distribution<double> in(-reach_m, reach_m);
  const double x = in(random), y = in(random);
  return {x, y, in(random)};
}

double from_axis_m(const WindPrimitive& primitive, const Eigen::Vector3d& at_m) {
  return (at_m - primitive.position_m).cross(primitive.axis).norm();
}

TEST(WindField, AirIsNeitherMadeNorLostButInTheCoreOfASource) {
  std::mt19937 random(1);
  for (const WindPrimitive& primitive : one_of_each()) {
    const Field field = [&](const Eigen::Vector3d& at) { return wind_of(primitive, at); };
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d at = somewhere(random, 40);
      const double rho = from_axis_m(primitive, at);
      // Differences across a tornado's foot and tip would see its third derivatives jump.
      const double z = (at - primitive.position_m).dot(primitive.axis);
      if (rho < 6 * primitive.core_radius_m) continue;
      if (primitive.kind == WindKind::tornado && std::min(std::abs(z), std::abs(z - 8)) < 0.4)
        continue;
      // Seventh derivatives of 1 / rho are below 5040 / rho^8, those of S' below 2e6 / h^7 = 1: at
      // rho >= 4.2 and d = 0.01 the error is 1e-12 / 140 of 1.4 of them, 1e-14. Rounding: 2e-16 of
      // 0.35 m/s in each of six differences over 0.01 m, 1e-13.
      EXPECT_NEAR(divergence_1_s(field, at, 0.01), 0, 1e-12) << at.transpose();
    }
  }
}

TEST(WindField, AVortexAndATornadoHaveNoDivergenceInTheirCores) {
  std::mt19937 random(2);
  for (const WindKind kind : {WindKind::uniform, WindKind::vortex, WindKind::tornado}) {
    const WindPrimitive primitive = tilted(kind);
    const Field field = [&](const Eigen::Vector3d& at) { return wind_of(primitive, at); };
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d at = somewhere(random, 2) + primitive.position_m + 4 * primitive.axis;
      // d^6 / 140 of derivatives of a Gauss bell of width c = 0.7: below 9 / (2 pi c) 1e3 / c^7
      // 1e-12 / 140 = 2e-10, and rounding 2e-16 9 / 0.01.
      EXPECT_NEAR(divergence_1_s(field, at, 0.01), 0, 1e-9) << at.transpose();
    }
  }
}

TEST(WindField, ASourceGivesItsStrengthThroughEveryCylinder) {
  const WindPrimitive source = tilted(WindKind::source);
  const Eigen::Vector3d x = source.axis.unitOrthogonal(), y = source.axis.cross(x);
  for (const double rho : {4.5, 20.0}) {  // exp(-41) is left outside
    double outward = 0;
    for (int i = 0; i < 100; ++i) {
      const double turn = 2 * pi * i / 100;
      const Eigen::Vector3d away = std::cos(turn) * x + std::sin(turn) * y;
      outward += wind_of(source, source.position_m + rho * away + 3 * source.axis).dot(away);
    }
    EXPECT_NEAR(outward / 100 * 2 * pi * rho, 9, 1e-12 * 9);
  }
  const Field field = [&](const Eigen::Vector3d& at) { return wind_of(source, at); };
  EXPECT_NEAR(divergence_1_s(field, source.position_m, 0.01), 9 / (pi * 0.49), 1e-8);
}

TEST(WindField, AVortexCirculatesWithItsStrengthCounterClockwise) {
  const WindPrimitive vortex = {.kind = WindKind::vortex, .strength = 5, .core_radius_m = 0.1};
  const Eigen::Vector3d wind = wind_of(vortex, {2, 0, 7});
  EXPECT_NEAR(wind.y() * 2 * pi * 2, 5, 1e-14);
  EXPECT_EQ(wind.x(), 0);
  EXPECT_EQ(wind_of(vortex, {0, 0, 3}).norm(), 0) << "on the axis";
}

TEST(WindField, ATornadoDrawsAirInBelowAndLetsItOutAbove) {
  const WindPrimitive tornado = {.kind = WindKind::tornado, .strength = 30, .inflow = 0.5};
  EXPECT_LT(wind_of(tornado, {2, 0, 2}).x(), 0);
  EXPECT_GT(wind_of(tornado, {2, 0, 8}).x(), 0);
  EXPECT_GT(wind_of(tornado, {0.1, 0, 5}).z(), 1);
  EXPECT_EQ(wind_of(tornado, {0.1, 0, 0}).z(), 0);
  EXPECT_EQ(wind_of(tornado, {0.1, 0, 11}).z(), 0);
  WindPrimitive other_way = tornado;
  other_way.strength = -30;
  EXPECT_EQ(wind_of(other_way, {2, 0, 5}).y(), -wind_of(tornado, {2, 0, 5}).y());
  EXPECT_EQ(wind_of(other_way, {0.1, 0, 5}).z(), wind_of(tornado, {0.1, 0, 5}).z());
}

// A smooth way through the keys would overshoot: 127 m/s after the second.
TEST(WindField, StrengthStaysBetweenThatOfItsKeys) {
  WindPrimitive wind = {.kind = WindKind::uniform};
  wind.path = {{.time_s = 0, .strength = -100},
               {.time_s = 1, .strength = 100},
               {.time_s = 10, .strength = 100}};
  EXPECT_EQ(primitive_at(wind, 0.5).strength, 0);
  for (double time_s = 1; time_s < 11; time_s += 0.5)
    EXPECT_EQ(primitive_at(wind, time_s).strength, 100);
}

TEST(WindField, NoPlaceIsFasterThanThePrimitiveSays) {
  std::mt19937 random(3);
  for (const WindPrimitive& primitive : one_of_each()) {
    double fastest = 0;
    for (int i = 0; i < 20000; ++i)
      fastest = std::max(fastest, wind_of(primitive, primitive.position_m + 4 * primitive.axis +
                                                         somewhere(random, 1.5))
                                      .norm());
    EXPECT_LE(fastest, most_speed_m_s(primitive) * (1 + 1e-8));
    EXPECT_GE(fastest, 0.6 * most_speed_m_s(primitive));
  }
}

TEST(WindField, KeysMoveTurnAndStrengthenAPrimitive) {
  WindPrimitive vortex = tilted(WindKind::vortex);
  vortex.path = {{.time_s = 1, .position_m = {0, 0, 0}, .axis = {0, 0, 1}, .strength = 2},
                 {.time_s = 3, .position_m = {4, 0, 0}, .axis = {1, 0, 0}, .strength = 6}};
  EXPECT_EQ(primitive_at(vortex, 0).position_m, Eigen::Vector3d(0, 0, 0));
  const WindPrimitive half = primitive_at(vortex, 2);
  EXPECT_EQ(half.position_m, Eigen::Vector3d(2, 0, 0));
  EXPECT_NEAR((half.axis - Eigen::Vector3d(1, 0, 1) / std::sqrt(2.0)).norm(), 0, 1e-15);
  EXPECT_EQ(half.strength, 4);
  EXPECT_EQ(primitive_at(vortex, 9).strength, 6);
}

// The greatest divergence by central differences of the grid's nodes, where the field has none.
double grid_divergence_1_s(const WindGrid& grid, int margin) {
  double most = 0;
  for (int z = margin; z < grid.nodes - margin; ++z)
    for (int y = margin; y < grid.nodes - margin; ++y)
      for (int x = margin; x < grid.nodes - margin; ++x) {
        const auto& w = grid.wind_m_s;
        const Eigen::Vector3d& h = grid.step_m;
        const double sum =
            (w[node_index(grid, x + 1, y, z)] - w[node_index(grid, x - 1, y, z)]).x() /
                (2 * h.x()) +
            (w[node_index(grid, x, y + 1, z)] - w[node_index(grid, x, y - 1, z)]).y() /
                (2 * h.y()) +
            (w[node_index(grid, x, y, z + 1)] - w[node_index(grid, x, y, z - 1)]).z() / (2 * h.z());
        most = std::max(most, std::abs(sum));
      }
  return most;
}

TEST(WindGrid, ItsDivergenceFallsWithTheSquareOfItsStep) {
  Wind wind;
  wind.primitives = {tilted(WindKind::vortex), tilted(WindKind::tornado)};
  for (WindPrimitive& primitive : wind.primitives) primitive.core_radius_m = 2;
  const Eigen::Vector3d low(-4, -4, -4), high(4, 4, 4);
  // Half the step, the same region inside.
  const double coarse = grid_divergence_1_s(make_wind_grid(wind, low, high, {}, 33), 1);
  const double fine = grid_divergence_1_s(make_wind_grid(wind, low, high, {}, 65), 2);
  EXPECT_GT(coarse, 1e-4);
  const double order = std::log2(coarse / fine);
  EXPECT_NEAR(order, 2, 0.1) << coarse << ", " << fine;
}

TEST(WindGrid, BetweenNodesItIsWithinTheSecondDerivativesAndExactForALinearWind) {
  Wind wind = {.even_m_s = {1, 2, -3}};
  const WindGrid even = make_wind_grid(wind, {0, 0, 0}, {3, 5, 7}, {}, 8);
  EXPECT_NEAR((velocity_m_s(even, {1.234, 4.9, 0.1}) - wind.even_m_s).norm(), 0, 1e-14);
  EXPECT_EQ(velocity_m_s(even, {-1e3, 1e6, 99}), wind.even_m_s) << "outside: the border's";
  wind.primitives = {tilted(WindKind::vortex)};
  wind.primitives[0].core_radius_m = 3;
  const WindGrid grid = make_wind_grid(wind, {-3, -3, -3}, {3, 3, 3}, {}, 49);
  std::mt19937 random(4);
  // h^2 / 8 of the second derivatives along three axes, each below 1.2 b / (2 pi c^3).
  const double bound = 3 * (0.125 * 0.125 / 8) * 1.2 * 9 / (2 * pi * 27) * 2;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d at = somewhere(random, 3);
    EXPECT_LT((velocity_m_s(grid, at) - velocity_m_s(wind, at)).norm(), bound) << at.transpose();
  }
}

TEST(WindGrid, InsideObjectsTheAirStands) {
  TopHeight top = {.min_x_m = -1, .min_y_m = -1, .texel_m = 1, .width = 2, .height = 2};
  top.texels.assign(4, {.z_m = 2});
  const WindGrid grid = make_wind_grid({.even_m_s = {5, 0, 0}}, {-4, -4, 0}, {4, 4, 8}, top, 33);
  EXPECT_EQ(velocity_m_s(grid, {0.1, 0.2, 1.3}).norm(), 0);
  EXPECT_NEAR(velocity_m_s(grid, {0.1, 0.2, 2.3}).x(), 5, 1e-14);
  EXPECT_NEAR(velocity_m_s(grid, {1.3, 0.2, 1.3}).x(), 5, 1e-14) << "beside it";
}

}  // namespace
}  // namespace pluvia
