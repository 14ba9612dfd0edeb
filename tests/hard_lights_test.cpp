// Hard cases of light: directions where the map is symmetric or breaks, grazing and critical rays,
// an index of 1, and the bows' caustics. Each answer is finite, without negative light, and within
// a stated bound of an independent one.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/light_integral.h"
#include "raytrace/optics.h"
#include "raytrace/wide_intersect.h"
#include "raytrace/wide_paths.h"
#include "tests/drop_samples.h"
#include "tests/streak_samples.h"
#include "tests/table_file.h"
#include "tests/wide_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

// Sums over all pixels of the planes (lights, environment, coverage) of a resting drop of r0 = 1
// mm, over r0^2. The centre stands at (column, row) of a square of 4 mm.
std::vector<double> fluxes(const DropInstant& drop, const ConeLights& lights,
                           const FieldOptions& options, double column, double row, int width_px) {
  const double per_mm = width_px / 4.0;
  const StreakFrame frame = {.width_px = width_px,
                             .height_px = width_px,
                             .pixel_m = 1e-3 / per_mm,
                             .centre_column = column,
                             .path_top_row = row};
  const int planes = static_cast<int>(lights.directions.size()) + 2;
  StreakWindow window = make_window(frame, planes, 1.6e-3, row, row);
  const SpanSlices moment = {.travel = {row, row}};
  integrate_lights(trace_exit_field(drop, view_from_elevation(0), lights, options), lights, frame,
                   moment, window);
  std::vector<double> sums;
  for (int plane = 0; plane < planes; ++plane) {
    const double* first = window.row(plane, 0);
    const double* last = first + window.rows * window.width_px;
    EXPECT_TRUE(std::all_of(first, last, [](double v) { return std::isfinite(v) && v >= 0; }));
    sums.push_back(std::accumulate(first, last, 0.0) / (per_mm * per_mm));
  }
  return sums;
}

// In pixels of r0 / 40: what counts as flat in the picture (0.05 px) is small against the part of
// the drop that a cone lights.
std::vector<double> fluxes(const DropInstant& drop, const ConeLights& lights,
                           const FieldOptions& options) {
  return fluxes(drop, lights, options, 80, 80, 160);
}

// A piece is flat when it bends by less than 2 % of the cone. The sides of what a cone lights then
// bulge by 2 / 3 of that on the mean, and if all did so to the same side its area would be off by
// twice that.
constexpr double grid_error = 2 * 0.02 * 2 / 3;

// Mean over eight differently turned and shifted grids, whose errors are independent: grid_error /
// sqrt(8) = 1 %.
constexpr double dithered_error = grid_error / 2.8;
std::vector<double> dithered_fluxes(const DropInstant& drop, const ConeLights& lights,
                                    FieldOptions options = {}) {
  std::vector<double> mean(lights.directions.size() + 2, 0.0);
  for (int grid = 0; grid < 8; ++grid) {
    options.rotation_rad = 2 * pi * grid / 8 + 0.1;
    options.shift = (grid + 0.5) / 8 - 0.5;
    const auto flux = fluxes(drop, lights, options);
    for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += flux[k] / 8;
  }
  return mean;
}

// Of a cone about a direction, on a sphere of r0 = 1 mm, over r0^2.
double closed_form(const Eigen::Vector3d& direction, double cone_rad, double index = 1.333,
                   int max_order = 3) {
  const double angle = std::acos(std::clamp(-direction.x(), -1.0, 1.0));
  return pi * sphere_intensity_in_cone(index, max_order, angle, cone_rad);
}

TEST(HardLights, ExactlyForwardAndExactlyBackwardAreTheClosedForm) {
  // The camera is at +x. A light there is reflected by the nearest point and returned by a whole
  // ring (p = 2, 3: the glory of ray optics has no bound, its cone average has one). Forward, the
  // outline reflects: a ring thinner than what is flat in the picture, which may be off by as much
  // as it has, 6 % of the light.
  for (const double cone : {1 * degree, 5 * degree}) {
    const ConeLights lights = {.directions = {{-1, 0, 0}, {1, 0, 0}}, .half_angle_rad = cone};
    const auto flux = dithered_fluxes(frozen_drop({}), lights);
    const double forward = closed_form(lights.directions[0], cone);
    const double ring = closed_form(lights.directions[0], cone, 1.333, 0) / forward;
    EXPECT_LT(ring, 0.065);
    EXPECT_NEAR(flux[0] / forward, 1, dithered_error + ring) << cone;
    EXPECT_NEAR(flux[1] / closed_form(lights.directions[1], cone), 1, dithered_error) << cone;
  }
}

// Lights exactly where a node's paths leave, and others for which a side of the cone passes
// through that vertex.
std::vector<Eigen::Vector3d> lights_on_vertices(double cone_rad) {
  const ExitField field =
      trace_exit_field(frozen_drop({}), view_from_elevation(0), {.half_angle_rad = cone_rad}, {});
  std::vector<Eigen::Vector3d> lights;
  for (std::size_t k = 5; k < field.exits.size() && lights.size() < 12; k += 61) {
    if (field.exits[k].throughput < 0.02 || field.exits[k].throughput > 1) continue;
    const Eigen::Vector3d vertex = field.exits[k].direction;
    lights.push_back(vertex);
    const Eigen::Vector3d in = make_cone(vertex, cone_rad).inward[0];
    const double tilt = std::asin(in.dot(vertex) / in.norm());
    lights.push_back(Eigen::AngleAxisd(tilt, in.cross(vertex).normalized()) * vertex);
  }
  return lights;
}

TEST(HardLights, OnAGridVertexAreTheClosedFormAndWhatIsBeside) {
  const double cone = 5 * degree;
  const ConeLights on = {.directions = lights_on_vertices(cone), .half_angle_rad = cone};
  ASSERT_EQ(on.directions.size(), 12u);
  ConeLights beside = on;
  for (Eigen::Vector3d& d : beside.directions) d = (d + 1e-9 * d.unitOrthogonal()).normalized();
  const auto flux = fluxes(frozen_drop({}), on, {}), next = fluxes(frozen_drop({}), beside, {});
  for (std::size_t k = 0; k < on.directions.size(); ++k) {
    const double expected = closed_form(on.directions[k], cone);
    EXPECT_NEAR(flux[k] / expected, 1, grid_error) << on.directions[k].transpose();
    // 1e-9 of the cone's 0.087 moves each side's area by 4e-8 at most; 100 for a steep edge.
    EXPECT_NEAR(next[k] / flux[k], 1, 4e-6) << on.directions[k].transpose();
  }
}

TEST(HardLights, AGlintOnAPixelsEdgeIsCountedOnce) {
  // Shifts put the glint of reflection, at the half-way normal, on the middle of a pixel, on an
  // edge and on a corner, and one rounding beside it. The sum over the picture stays, up to the
  // sum's rounding and those of a narrow sliver's area.
  const double cone = 0.5 * degree;
  const ConeLights lights = {.directions = {light_direction(30, 60)}, .half_angle_rad = cone};
  const Eigen::Vector3d half = (lights.directions[0] + Eigen::Vector3d(1, 0, 0)).normalized();
  const double column = 8 - 4 * half.y(), row = 8 + 4 * half.z();
  const auto flux = [&](double x, double y) {
    return fluxes(frozen_drop({}), lights, {}, column + x, row + y, 16)[0];
  };
  const double whole = flux(0.5, 0.5);
  ASSERT_GT(whole, 0);
  for (const double x : {0.0, -1e-15, 1e-15, 0.25}) {
    for (const double y : {0.0, 1e-15}) {
      EXPECT_NEAR(flux(x, y) / whole, 1, 1e-12) << x << ", " << y;
    }
  }
}

// Exits of one hit of a sphere of radius 1 mm at a given impact, on every instruction set.
template <typename Check>
void for_exits_at_impact(double impact, double cos_incidence, double index, Check check) {
  const Eigen::Vector3d u = {cos_incidence, impact, 0};
  std::vector<Isa> isas = wide_isas();
  isas.push_back(Isa::scalar);
  for (const Isa isa : isas) {
    check(trace_exits_of(frozen_drop({}), {{CameraHit{1e-3 * u, u}}}, {1, 0, 0},
                         {.refractive_index = index, .min_power = 0}, isa));
  }
}

TEST(HardLights, NearGrazingRaysHaveFresnelsShares) {
  // At cos i = c the transmitted share is about 5 c; c itself is known to 1e-16, so shares are to
  // 1e-15 and 1e-13 of roundings of the path.
  for (const double cosine : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15}) {
    const double impact = std::sqrt(1 - cosine * cosine);
    for_exits_at_impact(impact, cosine, 1.333, [&](const HitExits& traced) {
      double total =
          traced.remainder.beyond_order + traced.remainder.given_up + traced.remainder.lost;
      for (const PathExit& exit : traced.exits) {
        ASSERT_TRUE(exit.direction.allFinite());
        ASSERT_NEAR(exit.direction.norm(), 1, 1e-14);
        ASSERT_GE(exit.throughput, 0);
        total += exit.throughput;
        if (exit.order > 0) {
          EXPECT_LT(exit.throughput, 8 * cosine) << "order " << exit.order << ", cos " << cosine;
          continue;
        }
        const FresnelPower r = fresnel_reflectance(cosine, 1 / 1.333);
        EXPECT_NEAR(exit.throughput, 0.5 * (r.s + r.p), 1e-13) << "cos " << cosine;
      }
      EXPECT_NEAR(total, 1, 1e-12) << "cos " << cosine;
    });
  }
}

TEST(HardLights, NearCriticalRaysKeepTheirPower) {
  // From inside at the critical angle and 1e-3 .. 1e-15 beside it. On the near side the transmitted
  // share is 4 n kappa / .. ~ sqrt(offset): it goes to 0 without a step, and the direction to the
  // tangent.
  const double critical = std::asin(1 / 1.333);
  const Eigen::Vector3d normal = {-1, 0, 0};
  for (double offset = 1e-3; offset > 1e-16; offset /= 10) {
    for (const double side : {-1.0, 1.0}) {
      const double i = critical + side * offset;
      const Eigen::Vector3d d = {std::cos(i), std::sin(i), 0};
      const InterfaceExit exit = leave_interface(true, d, normal, 0.5, 0.5, 1.333);
      ASSERT_TRUE(exit.direction.allFinite() && std::isfinite(exit.throughput));
      EXPECT_GE(exit.throughput, 0);
      // ct^2 = 2 n^2 sin i cos i offset = 1.76 offset; 1 - R is 4 ct / (n cos i) = 4.6 ct for s,
      // n^2 times that, 8.1 ct, for p. ct^2 itself is known to some roundings, 1e-15.
      const double ct = std::sqrt(1.77 * offset + 1e-15);
      EXPECT_LE(std::abs(exit.direction.x()), ct) << i;
      EXPECT_LE(exit.throughput, 6.4 * ct) << i;
      const Split split = split_at_interface(unpolarised_beam(d), normal, 1.333);
      EXPECT_NEAR(power(split.reflected) + power(split.refracted), 1, 1e-14);
      EXPECT_NEAR(exit.throughput, power(split.refracted), 6.4 * 1e-15 / ct);
    }
  }
}

TEST(HardLights, NearCriticalPathsOfAConcaveDropKeepTheirPower) {
  // Hits where some path turns to total reflection, approached by bisection to one rounding: all
  // power is accounted for on both sides.
  const DropInstant drop = concave_drop(0.2, 0.1);
  const Eigen::Vector3d to_camera = {1, 0, 0};
  const auto trace = [&](double angle) {
    const Eigen::Vector3d u = {std::cos(angle), std::sin(angle), 0.1};
    const auto p = surface_points_of(drop, {{u.normalized()}}, to_camera, Isa::scalar).front();
    return trace_exits_of(drop, {{CameraHit{p.position_m, p.normal}}}, to_camera, {.min_power = 0},
                          Isa::scalar);
  };
  const auto lit = [](const HitExits& traced) {
    return std::count_if(traced.exits.begin(), traced.exits.end(),
                         [](const PathExit& exit) { return exit.throughput > 0; });
  };
  int breaks = 0;
  for (double angle = 0; angle < 1.2; angle += 0.02) {
    double low = angle, high = angle + 0.02;
    const auto at_low = lit(trace(low));
    if (lit(trace(high)) == at_low) continue;
    ++breaks;
    while (high - low > 4e-16) {
      const double middle = 0.5 * (low + high);
      const HitExits traced = trace(middle);
      (lit(traced) == at_low ? low : high) = middle;
      double total = traced.remainder.beyond_order + traced.remainder.lost;
      for (const PathExit& exit : traced.exits) {
        ASSERT_TRUE(exit.direction.allFinite() && exit.throughput >= 0) << middle;
        total += exit.throughput;
      }
      ASSERT_NEAR(total, 1, 1e-12) << middle;
      if (middle == low || middle == high) break;
    }
  }
  EXPECT_GT(breaks, 0) << "nothing was tested";
}

TEST(HardLights, AnIndexOfOneOrNearlyOneLetsTheLightThrough) {
  // Light straight behind passes: its flux is the silhouette over pi sin^2; nothing comes from
  // elsewhere. For 1 + 1e-9 what is reflected is of order 1e-9 of the disc (R is of order 1 for cos
  // i < sqrt(2e-9) only), and rays are bent by 2 (n - 1) tan i, less than the cone but for b > 1 -
  // 1e-10. 1 %: cells at the outline have no nodes beyond it.
  const double cone = 5 * degree;
  const ConeLights lights = {.directions = {{-1, 0, 0}, {1, 0, 0}, light_direction(10, 120)},
                             .half_angle_rad = cone};
  const double weight = 1 / (pi * std::pow(std::sin(cone), 2));
  for (const double index : {1.0, 1 + 2.3e-16, 1 + 1e-9, 1 + 1e-6}) {
    for (const DropInstant& drop : {frozen_drop({}), concave_drop(0.2, 0.1)}) {
      FieldOptions options;
      options.paths.refractive_index = index;
      const auto flux = fluxes(drop, lights, options, 8, 8, 16);
      EXPECT_NEAR(flux[3] / flux[4], 1, 1e-6) << "index " << index << ": energy";
      EXPECT_NEAR(flux[0] / (weight * flux[4]), 1, 0.01) << "index " << index;
      EXPECT_LT(flux[1] + flux[2], 1e-3 * flux[0]) << "index " << index;
    }
  }
}

TEST(HardLights, AnIndexOfOneTracesAStreak) {
  for (const double index : {1.0, 1 + 1e-9}) {
    StreakRequest request = few_rows(1.6e-3, published_modes(0.11, 0.1), {{0, 180}, {0, 0}});
    request.field.paths.refractive_index = index;
    const TracedStreak streak = trace_streak(request);
    expect_sound(request, streak);
    const double weight = 1 / (pi * std::pow(std::sin(request.cone_half_angle_rad), 2));
    EXPECT_NEAR(sum(streak.light[0].mean) / (weight * sum(streak.coverage.mean)), 1, 0.01);
    EXPECT_LT(sum(streak.light[1].mean), 1e-3 * sum(streak.light[0].mean));
  }
}

TEST(HardLights, AStrongIndexIsTheClosedForm) {
  // Diamond: Brewster's continuation beyond the outline has its pole much nearer.
  const double cone = 5 * degree;
  ConeLights lights = {.half_angle_rad = cone};
  for (const double azimuth : {20.0, 80.0, 110.0, 150.0}) {
    lights.directions.push_back(light_direction(0, azimuth));
  }
  FieldOptions options;
  options.paths.refractive_index = 2.42;
  const auto flux = dithered_fluxes(frozen_drop({}), lights, options);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(flux[k] / closed_form(lights.directions[k], cone, 2.42), 1, dithered_error) << k;
  }
}

// Share of the circle of scattering angle `angle` that lies within `cone` of a point at `centre`.
double circle_share(double angle, double centre, double cone) {
  const double c =
      (std::cos(cone) - std::cos(angle) * std::cos(centre)) / (std::sin(angle) * std::sin(centre));
  return std::acos(std::clamp(c, -1.0, 1.0)) / pi;
}

TEST(HardLights, BowsHaveTheFluxOfTheTablesBins) {
  // Cones of 5 degrees about the middle of the bin that holds the singularity of p = 2 and p = 3
  // (137.9 and 129.1 degrees for 1.333): the flux is the sum of the table's bins, each by the share
  // of it within the cone. Within the bow's bin that share varies by (0.5 / 5)^2 / 2 = 0.5 %
  // (elsewhere intensity is nearly level).
  const double cone = 5 * degree;
  const auto rows = table_rows("sphere_go_binned_1deg.csv");
  ASSERT_EQ(rows.size(), 180u);
  for (const int order : {2, 3}) {
    const double bow = sphere_rainbow_rad(1.333, order) / degree;
    const double centre = std::floor(bow) + 0.5;
    double expected = 0, bow_bin = 0;
    for (const auto& row : rows) {
      double intensity = 0, share = 0;
      for (std::size_t p = 0; p <= 3; ++p) intensity += std::stod(row[3 + p]);
      const double low = std::stod(row[0]);
      for (int k = 0; k < 20; ++k) {
        share += circle_share((low + (k + 0.5) / 20) * degree, centre * degree, cone) / 20;
      }
      const double flux = pi * intensity * std::stod(row[2]) * share;
      expected += flux;
      if (low == std::floor(bow)) bow_bin = flux;
    }
    EXPECT_GT(bow_bin, 0.1 * expected) << "the caustic is not in the comparison";
    expected /= pi * std::pow(std::sin(cone), 2);
    const ConeLights light = {.directions = {light_direction(0, 180 - centre)},
                              .half_angle_rad = cone};
    EXPECT_NEAR(dithered_fluxes(frozen_drop({}), light)[0] / expected, 1, dithered_error + 0.005)
        << "order " << order;
  }
}

}  // namespace
}  // namespace pluvia
