#include "raytrace/glints.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "raytrace/light_integral.h"
#include "tests/drop_samples.h"
#include "tests/streak_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

// A lit point of the map that has the direction (f, g, 1), not of unit length, and the picture
// place (x, y).
ConeVertex lit(double f, double g, double x, double y, double throughput = 1) {
  return {f, g, 1, x, y, throughput, 1, 1};
}

std::vector<Glint> glints_of(const PatchMap& map, const Eigen::Vector3d& light) {
  std::vector<Glint> found;
  find_glints(map, {&light, 1}, [&](std::size_t, const Glint& glint) { found.push_back(glint); });
  return found;
}

Eigen::Vector3d toward(double f, double g) {
  return Eigen::Vector3d(f, g, 1).normalized();
}

TEST(Glints, LightOfAGlintIsThePictureAreaOverTheSolidAngle) {
  // Direction (0.3 u + 0.1 v, 0.2 v, 1): the plane at distance 1 has 1 / cos^3 of the solid angle.
  const PatchMap map = [](double u, double v) {
    return lit(0.3 * u + 0.1 * v, 0.2 * v, 5 * u, 7 * v, 0.5 + u);
  };
  for (const double u : {0.1, 0.5, 0.83}) {
    for (const double v : {0.2, 0.5, 0.77}) {
      const auto found = glints_of(map, toward(0.3 * u + 0.1 * v, 0.2 * v));
      ASSERT_EQ(found.size(), 1u) << u << ", " << v;
      EXPECT_NEAR(found[0].x, 5 * u, 1e-11);
      EXPECT_NEAR(found[0].y, 7 * v, 1e-11);
      const double cosine = toward(0.3 * u + 0.1 * v, 0.2 * v).z();
      const double expected = (0.5 + u) * 35 / 0.06 / std::pow(cosine, 3);
      EXPECT_NEAR(found[0].light / expected, 1, 1e-7) << u << ", " << v;
    }
  }
}

TEST(Glints, LightsOnEdgesAndCornersOfPatchesCountOnce) {
  // Four patches that tile one bent map, and lights at places that are edges, corners and middles
  // of their pieces.
  const auto whole = [](double x, double y) {
    return lit(0.3 * x + 0.02 * x * y * y, 0.2 * y + 0.03 * x * x, x, y);
  };
  for (const double x : {0.25, 0.5, 1.0, 1.25, 1.5, 1.75}) {
    for (const double y : {0.25, 0.75, 1.0, 1.5}) {
      const ConeVertex p = whole(x, y);
      std::size_t count = 0;
      for (const int i : {0, 1}) {
        for (const int j : {0, 1}) {
          count +=
              glints_of([&](double u, double v) { return whole(i + u, j + v); }, toward(p.dx, p.dy))
                  .size();
        }
      }
      EXPECT_EQ(count, 1u) << x << ", " << y;
    }
  }
}

TEST(Glints, AFoldHasTwoOnOneSideAndNoneOnTheOther) {
  // f = (u - 0.4)^2: at f = e two glints with df/du = 2 sqrt(e); their light grows without bound.
  const PatchMap map = [](double u, double v) { return lit((u - 0.4) * (u - 0.4), v - 0.5, u, v); };
  for (const double e : {1e-2, 1e-4, 1e-6}) {
    const auto found = glints_of(map, toward(e, 0.01));
    ASSERT_EQ(found.size(), 2u) << e;
    for (const Glint& glint : found) {
      EXPECT_NEAR(std::abs(glint.x - 0.4), std::sqrt(e), 1e-9) << e;
      EXPECT_NEAR(glint.light * 2 * std::sqrt(e), 1, 1e-3) << e;
    }
    EXPECT_TRUE(glints_of(map, toward(-e, 0.01)).empty()) << e;
  }
  // At the fold itself nothing or something finite.
  for (const Glint& glint : glints_of(map, toward(0, 0.01)))
    EXPECT_TRUE(std::isfinite(glint.light));
}

TEST(Glints, WhatIsHiddenDarkOrBehindIsNone) {
  const Eigen::Vector3d light = toward(0.15, 0.1);
  const auto map_with = [](double facing, double margin, double throughput, double sign) {
    return [=](double u, double v) {
      return ConeVertex{sign * 0.3 * u, sign * 0.2 * v, sign, u, v, throughput, facing, margin};
    };
  };
  EXPECT_EQ(glints_of(map_with(1, 1, 1, 1), light).size(), 1u);
  EXPECT_TRUE(glints_of(map_with(-1, 1, 1, 1), light).empty());
  EXPECT_TRUE(glints_of(map_with(1, -1, 1, 1), light).empty());
  EXPECT_TRUE(glints_of(map_with(1, 1, 0, 1), light).empty());
  EXPECT_TRUE(glints_of(map_with(1, 1, 1, -1), light).empty());
}

TEST(Glints, TrianglesThatTileCountALightOnceWhereverItIs) {
  // A fan about a vertex that is the light itself, and triangles on both sides of an edge through
  // it.
  const Eigen::Vector3d light = {0, 0, 1};
  std::vector<ConeVertex> rim;
  for (int k = 0; k < 7; ++k) rim.push_back(lit(std::cos(0.9 * k), std::sin(0.9 * k), 0, 0));
  for (auto& p : rim) p.x = p.dx, p.y = p.dy;
  const std::vector<ConeVertex> middles = {lit(0, 0, 0, 0), lit(0.1, 0, 0.1, 0),
                                           lit(0, -0.1, 0, -0.1), lit(-0.05, -0.05, -0.05, -0.05)};
  for (const ConeVertex& middle : middles) {
    int count = 0;
    double sum = 0;
    for (std::size_t k = 0; k < rim.size(); ++k) {
      const auto glint = glint_in_triangle(light, middle, rim[k], rim[(k + 1) % rim.size()]);
      if (!glint) continue;
      ++count;
      sum += glint->light;
    }
    EXPECT_EQ(count, 1) << middle.dx << ", " << middle.dy;
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  // No area in direction: no glint, not a division by zero.
  EXPECT_FALSE(glint_in_triangle(light, middles[0], middles[0], middles[0]));
  EXPECT_FALSE(glint_in_triangle(light, lit(-1, 0, 0, 0), lit(0, 0, 1, 0), lit(1, 0, 0, 1)));
}

// Light of a resting drop of r0 = 1 mm, over r0^2: the mean over differently turned grids.
std::vector<double> dithered_fluxes(const DropInstant& drop, const ConeLights& lights,
                                    double bend_tolerance) {
  const StreakFrame frame = {.width_px = 160,
                             .height_px = 160,
                             .pixel_m = 0.025e-3,
                             .centre_column = 80,
                             .path_top_row = 80};
  const int count = static_cast<int>(lights.directions.size());
  constexpr int grids = 4;
  std::vector<double> mean(lights.directions.size(), 0.0);
  for (int grid = 0; grid < grids; ++grid) {
    StreakWindow window = make_window(frame, count + 2, 1.6e-3, 80, 80);
    FieldOptions options;
    options.rotation_rad = 2 * pi * grid / grids + 0.1;
    options.shift = (grid + 0.5) / grids - 0.5;
    options.bend_tolerance = bend_tolerance;
    options.space_depth = 4;
    const ConeLights looking = {.directions = lights.directions, .half_angle_rad = 1 * degree};
    const SpanSlices moment = {.travel = {80, 80}};
    integrate_lights(trace_exit_field(drop, view_from_elevation(0), looking, options), lights,
                     frame, moment, window);
    for (int k = 0; k < count; ++k) {
      const double* first = window.row(k, 0);
      for (int i = 0; i < window.rows * window.width_px; ++i) {
        EXPECT_TRUE(std::isfinite(first[i]) && first[i] >= 0);
        mean[static_cast<std::size_t>(k)] += first[i] / 1600 / grids;
      }
    }
  }
  return mean;
}

TEST(Glints, ASpheresAreTheClosedFormsIntensity) {
  const std::vector<double> angles = {20, 40, 60, 75, 95, 110, 120, 145, 150, 165, 175};
  ConeLights lights;
  for (const double angle : angles) lights.directions.push_back(light_direction(0, 180 - angle));
  const auto flux = dithered_fluxes(frozen_drop({}), lights, 0.05);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double expected = pi * sphere_intensity(1.333, 3, angles[k] * degree);
    EXPECT_NEAR(flux[k] / expected, 1, 1e-3) << angles[k] << " degrees";
  }
}

TEST(Glints, AnOscillatingDropsAreTheLimitOfItsNarrowingCones) {
  // Cones of 0.05 degrees, in the same spans and grids (same seed). Lights far from folds differ by
  // the flatness of the cone's pieces (2.7 % of a grid at worst, of independent signs over dozens
  // of grids and lights: 1 %); near a fold, by what the replicates of both say: four times that.
  StreakRequest request =
      few_rows(1.6e-3, published_modes(0.11, 0.1), {{10, 150}, {-10, 140}, {10, 170}, {50, 100}});
  request.spans_per_period = 6;
  request.slices = 24;
  StreakRequest narrow = request;
  request.cone_half_angle_rad = 0;
  narrow.cone_half_angle_rad = 0.05 * degree;
  const TracedStreak points = trace_streak(request), cones = trace_streak(narrow);
  expect_sound(request, points);
  for (std::size_t k = 0; k < request.lights.size(); ++k) {
    const double ours = sum(points.light[k].mean), theirs = sum(cones.light[k].mean);
    const double noise = std::sqrt(sum(points.light[k].variance) + sum(cones.light[k].variance));
    EXPECT_NEAR(ours, theirs, 4 * noise + 0.01 * theirs) << k;
    EXPECT_LT(noise, 0.1 * theirs) << k << ": too blunt";
  }
  // Where the drop is and what it returns of an environment does not depend on the lights' size,
  // but for the cells that the two refine.
  EXPECT_NEAR(sum(points.env.mean) / sum(cones.env.mean), 1, 2e-3);
  EXPECT_NEAR(sum(points.coverage.mean) / sum(cones.coverage.mean), 1, 2e-3);
}

TEST(Glints, OtherConesAreRefusedWithTheRange) {
  StreakRequest request = few_rows(1.6e-3, {}, {{10, 150}});
  for (const double cone : {-0.1, 1e-5, 1.0, std::nan("")}) {
    request.cone_half_angle_rad = cone;
    EXPECT_THROW(trace_streak(request), std::invalid_argument) << cone;
  }
  request.cone_half_angle_rad = 0;
  EXPECT_NO_THROW(trace_streak(request));
  EXPECT_THROW(brute_force_streak(request, {}), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
