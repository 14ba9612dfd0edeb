#include "raytrace/refraction_mask.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "oscillation/equilibrium.h"
#include "raytrace/drop_silhouette.h"
#include "raytrace/sphere_closed_form.h"
#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double radius_m = 1e-3;

MaskGrid grid_of(int size_px, double half_width = 1.05) {
  return {size_px, half_width * radius_m};
}

TEST(RefractionMask, EveryOrderOfASphereObeysSnell) {
  // Of a sphere order p is turned by 2 i - 2 p r + (p - 1) pi in the plane of the line of sight and
  // the centre; positive turns are toward the axis. Both roads are double: 1e-6 is the promise, a
  // few 1e-12 what conditioning at the rim (i within 0.045 of 90 degrees) leaves.
  const DropInstant sphere = frozen_drop({});
  const View view = view_from_elevation(37);
  const MaskGrid grid = grid_of(31);
  const RefractionMask mask = trace_refraction_mask(sphere, view, grid, {.max_order = 6});
  for (int row = 0; row < 31; ++row) {
    for (int column = 0; column < 31; ++column) {
      const Eigen::Vector2d place = mask_place_m(sphere, view, grid, column, row) / radius_m;
      const double impact = place.norm();
      const Eigen::Vector2d outward =
          impact > 0 ? Eigen::Vector2d(place / impact) : Eigen::Vector2d(1, 0);
      for (int order = 0; order <= 6; ++order) {
        const double turn = sphere_deviation_rad(1.333, order, std::asin(impact));
        // Reflection turns outward.
        const double sine = (order == 0 ? 1 : -1) * std::sin(turn);
        const Eigen::Vector3d expected(sine * outward.x(), sine * outward.y(), std::cos(turn));
        const MaskExit& exit = mask.exit(order, column, row);
        const double weight = sphere_throughput(1.333, order, impact);
        EXPECT_NEAR(exit.weight, weight, 1e-7 + 1e-9) << order << " at " << place.transpose();
        if (weight < 1e-6) continue;  // given up: min_power
        EXPECT_LT((exit.direction - expected).norm(), 1e-6) << order << " at " << place.transpose();
      }
    }
  }
}

TEST(RefractionMask, ARoundMapOfASphereGoesByTheAngleOfIncidence) {
  // As above, the angle of incidence being the distance from the middle: 90 degrees at 1.
  const RefractionMask mask =
      trace_round_mask(frozen_drop({}), view_from_elevation(-20), 21, {.max_order = 2});
  for (int column = 0; column < 20; ++column) {  // the rim itself is a little within: its own test
    const double q = column / 10.0 - 1, incidence = std::abs(q) * pi / 2;
    for (int order = 0; order <= 2 && column > 0; ++order) {
      const double turn = sphere_deviation_rad(1.333, order, incidence);
      const MaskExit& exit = mask.exit(order, column, 10);
      const double sine = (order == 0 ? 1 : -1) * std::sin(turn) * (q < 0 ? -1 : 1);
      EXPECT_NEAR(exit.direction.x(), sine, 1e-6) << order << " at " << q;
      EXPECT_NEAR(exit.direction.z(), std::cos(turn), 1e-6) << order << " at " << q;
      EXPECT_NEAR(exit.weight, sphere_throughput(1.333, order, std::sin(incidence)), 1e-6);
    }
  }
  // At the outline and beyond it: of the order of sqrt(2e-5) from grazing.
  for (const int column : {0, 20}) EXPECT_NEAR(mask.exit(0, column, 10).direction.z(), 1, 1e-4);
  for (const MaskExit& exit : mask.exits) EXPECT_NEAR(exit.direction.norm(), 1, 1e-12);
}

TEST(RefractionMask, WeightsAndTailAreAllTheLight) {
  Random random(4);
  for (const DropInstant& drop : hard_drops()) {
    const View view = view_from_elevation(uniform(random, -80, 80));
    const RefractionMask mask =
        trace_refraction_mask(drop, view, grid_of(24, 1.5), {.max_order = 4});
    for (int row = 0; row < 24; ++row) {
      for (int column = 0; column < 24; ++column) {
        double sum = 0;
        for (int order = 0; order <= 4; ++order) {
          const MaskExit& exit = mask.exit(order, column, row);
          EXPECT_NEAR(exit.direction.norm(), 1, 1e-12);
          EXPECT_GE(exit.weight, 0);
          sum += exit.weight;
        }
        // The tail is what the tracer did not let out, never less than none: to rounding.
        const double tail = mask.tail[static_cast<std::size_t>(row * 24 + column)];
        EXPECT_GE(tail, -1e-12);
        EXPECT_NEAR(sum + tail, 1, 1e-12);
      }
    }
  }
}

TEST(RefractionMask, CoverageIsTheAreaWithinTheOutline) {
  // The pixels' sum is the area of the polygon, and the polygon's is widened to the circle's.
  for (const int size : {1, 2, 7, 48}) {
    const MaskGrid grid = grid_of(size);
    const RefractionMask mask =
        trace_refraction_mask(frozen_drop({}), view_from_elevation(0), grid, {});
    double sum = 0;
    for (const double share : mask.coverage) {
      EXPECT_GE(share, 0);
      EXPECT_LE(share, 1);
      sum += share;
    }
    const double pixel_m = 2 * grid.half_width_m / size;
    EXPECT_NEAR(sum * pixel_m * pixel_m / (pi * radius_m * radius_m), 1, 1e-9) << size;
  }
  const RefractionMask wide =
      trace_refraction_mask(frozen_drop({}), view_from_elevation(0), grid_of(9, 3), {});
  EXPECT_EQ(wide.coverage.front(), 0);  // a corner far outside
  EXPECT_EQ(wide.coverage[40], 1);      // the middle
}

TEST(RefractionMask, AConcaveOutlineIsCoveredOnlyInside) {
  // Against a count of points at 400 x 400, off by the rim's share of half a cell: 0.005.
  const DropInstant drop = concave_drop();
  const View view = view_from_elevation(0);
  const MaskGrid grid = grid_of(12, 1.6);
  const RefractionMask mask = trace_refraction_mask(drop, view, grid, {});
  const auto outline = outline_from_origin_m(drop, view, 720);
  double counted = 0, sum = 0;
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      const double right = (x - 199.5) / 200 * grid.half_width_m;
      const double up = (y - 199.5) / 200 * grid.half_width_m;
      const double turn = std::atan2(up, right) / (2 * pi) + 1;
      const auto angle = static_cast<std::size_t>(std::lround(720 * turn)) % 720;
      if (std::hypot(right, up) < outline[angle]) counted += 1.0 / (400 * 400);
    }
  }
  for (const double share : mask.coverage) sum += share / (12 * 12);
  EXPECT_NEAR(sum, counted, 0.005);
}

TEST(RefractionMask, ADropOfAirChangesNothing) {
  const RefractionMask mask =
      trace_refraction_mask(concave_drop(), view_from_elevation(-20), grid_of(15, 1.6),
                            {.refractive_index = 1, .max_order = 2});
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 15; ++column) {
      EXPECT_EQ(mask.exit(0, column, row).weight, 0);
      EXPECT_TRUE(mask.exit(0, column, row).direction.allFinite());
      EXPECT_NEAR(mask.exit(1, column, row).weight, 1, 1e-12);
      EXPECT_NEAR(mask.exit(1, column, row).direction.z(), 1, 1e-12);
    }
  }
}

TEST(RefractionMask, NearlyAirTurnsAsThePrismFormulaSays) {
  // With e = n - 1 and t = tan i a sphere turns by 2 (i - asin(sin i / n)) = 2 e t - e^2 (2 t +
  // t^3)
  // + .., the third order 1e-5 t^2 of that.
  const double excess = 1e-5;
  const DropInstant sphere = frozen_drop({});
  const View view = view_from_elevation(0);
  const RefractionMask mask = trace_refraction_mask(
      sphere, view, grid_of(9), {.refractive_index = 1 + excess, .max_order = 1});
  for (int column = 0; column < 9; ++column) {
    const double impact = mask_place_m(sphere, view, grid_of(9), column, 4).norm() / radius_m;
    const double slope = impact / std::sqrt(1 - impact * impact);
    const Eigen::Vector3d& direction = mask.exit(1, column, 4).direction;
    EXPECT_NEAR(std::hypot(direction.x(), direction.y()), 2 * excess * slope,
                1.02 * excess * excess * (2 * slope + std::pow(slope, 3)) + 1e-15);
  }
}

TEST(RefractionMask, TotalReflectionHasNoLightAndADirection) {
  // A drop at rest of 8 mm is so flat that p = 1 is reflected totally near its upper rim.
  const EquilibriumTable table =
      read_equilibrium_table(PLUVIA_SOURCE_DIR "/data/tables/chuang_beard_1990_cn.csv");
  DropShape shape = {.mean_radius_m = radius_m};
  shape.equilibrium_cos = equilibrium_cos(table, 8e-3);
  const RefractionMask mask = trace_refraction_mask(drop_at(shape, 0), view_from_elevation(0),
                                                    grid_of(41, 1.4), {.max_order = 2});
  int dark = 0;
  for (int row = 0; row < 41; ++row) {
    for (int column = 0; column < 41; ++column) {
      const MaskExit& exit = mask.exit(1, column, row);
      EXPECT_NEAR(exit.direction.norm(), 1, 1e-12);
      dark += exit.weight == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(dark, 0);
}

TEST(RefractionMask, ASphereIsTheSameFromEverySide) {
  // Views along the axis of the fall have no azimuth of their own, and need none.
  const RefractionMask level =
      trace_refraction_mask(frozen_drop({}), view_from_elevation(0), grid_of(8), {});
  for (const double elevation : {90.0, -90.0, 45.0}) {
    const RefractionMask other =
        trace_refraction_mask(frozen_drop({}), view_from_elevation(elevation), grid_of(8), {});
    for (std::size_t i = 0; i < level.exits.size(); ++i) {
      EXPECT_NEAR(level.exits[i].weight, other.exits[i].weight, 1e-7);
      if (level.exits[i].weight < 1e-6) continue;
      EXPECT_LT((level.exits[i].direction - other.exits[i].direction).norm(), 1e-6);
    }
  }
}

TEST(RefractionMask, GridsThatAreNoneAreRefused) {
  const DropInstant sphere = frozen_drop({});
  const View view = view_from_elevation(0);
  for (const MaskGrid& grid : {MaskGrid{0, 1e-3}, MaskGrid{4, 0}, MaskGrid{4, -1},
                               MaskGrid{4, std::nan("")}, MaskGrid{5000, 1e-3}})
    EXPECT_THROW(trace_refraction_mask(sphere, view, grid, {}), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
