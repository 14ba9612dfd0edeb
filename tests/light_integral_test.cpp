#include "raytrace/light_integral.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/drop_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

ConeLights lights_at(const std::vector<Eigen::Vector3d>& directions, double half_angle_deg) {
  return {.directions = directions, .half_angle_rad = half_angle_deg * degree};
}

// One pixel over the whole drop, standing still.
StreakFrame one_pixel(double size_m) {
  StreakFrame frame;
  frame.width_px = frame.height_px = 1;
  frame.pixel_m = size_m;
  frame.centre_column = frame.path_top_row = 0.5;
  return frame;
}

// Sums of all planes over r0^2 (r0 = 1 mm).
std::vector<double> fluxes(const DropInstant& drop, const View& view, const ConeLights& lights,
                           const FieldOptions& options, double time_share = 1) {
  const StreakFrame frame = one_pixel(4e-3);
  const int planes = static_cast<int>(lights.directions.size()) + 2;
  StreakWindow window = make_window(frame, planes, 1.6e-3, 0.5, 0.5);
  const SpanSlices moment = {.travel = {0.5, 0.5}, .time_share = time_share};
  integrate_lights(trace_exit_field(drop, view, lights, options), lights, frame, moment, window);
  for (double& value : window.values) value *= 16;  // pixel area over r0^2
  return window.values;
}

FieldOptions deep(int depth) {
  FieldOptions options;
  options.space_depth = depth;
  return options;
}

// Mean over differently turned and shifted grids, as a streak averages them.
std::vector<double> dithered_fluxes(const DropInstant& drop, const View& view,
                                    const ConeLights& lights, FieldOptions options) {
  constexpr int grids = 8;
  std::vector<double> mean(lights.directions.size() + 2, 0.0);
  for (int grid = 0; grid < grids; ++grid) {
    options.rotation_rad = 2 * pi * grid / grids + 0.1;
    options.shift = (grid + 0.5) / grids - 0.5;
    const auto flux = fluxes(drop, view, lights, options);
    for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += flux[k] / grids;
  }
  return mean;
}

TEST(LightIntegral, ASpheresFluxIsTheClosedFormsFromEverySide) {
  // In the bows, at the edge of direct light, straight behind (azimuth 180) and straight before the
  // drop (0). Cells are taken for flat when they bend by 3 % of the cone, so a leaf's triangles by
  // 1 % and less, to either side; the mean of eight grids is good to 1 %.
  const double cone = 3;
  std::vector<Eigen::Vector3d> directions;
  const std::vector<double> angles = {0, 10, 25, 42, 51, 60, 75, 97, 120, 140, 160, 180};
  for (const double a : angles) directions.push_back(light_direction(0, a));
  FieldOptions options = deep(3);
  const auto flux = dithered_fluxes(frozen_drop({}), view_from_elevation(0),
                                    lights_at(directions, cone), options);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double expected =
        pi * sphere_intensity_in_cone(1.333, 3, (180 - angles[k]) * degree, cone * degree);
    EXPECT_NEAR(flux[k] / expected, 1, 0.01) << angles[k] << " degrees";
  }
}

TEST(LightIntegral, EnvironmentAndCoverageAreTheSpheresEnergyAndDisc) {
  const auto flux = fluxes(frozen_drop({}), view_from_elevation(40), lights_at({}, 3), deep(4));
  double energy = 0;
  for (int order = 0; order <= 3; ++order) energy += sphere_energy(1.333, order);
  // The outline's cracks (exit_field_test.cpp): 2e-3.
  EXPECT_NEAR(flux[0] / (pi * energy), 1, 2e-3);
  EXPECT_NEAR(flux[1] / pi, 1, 2e-3);
  const auto half =
      fluxes(frozen_drop({}), view_from_elevation(40), lights_at({}, 3), deep(4), 0.5);
  EXPECT_NEAR(half[1] / flux[1], 0.5, 1e-14);
}

TEST(LightIntegral, TheSphereLooksAlikeUnderAnyElevation) {
  // The same scattering angle from four sides and views: the grids differ, 1 % each at 5 degrees.
  const DropInstant sphere = frozen_drop({});
  const double expected = pi * sphere_intensity_in_cone(1.333, 3, 130 * degree, 5 * degree);
  for (const double elevation : {0.0, 40.0, 80.0}) {
    const View view = view_from_elevation(elevation);
    std::vector<Eigen::Vector3d> directions;
    for (int k = 0; k < 4; ++k) {  // 50 degrees from the camera
      const double turn = 0.3 + k * pi / 2;
      directions.push_back(std::cos(50 * degree) * view.to_camera +
                           std::sin(50 * degree) *
                               (std::cos(turn) * view.right + std::sin(turn) * view.up));
    }
    const auto flux = fluxes(sphere, view, lights_at(directions, 5), deep(3));
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(flux[k] / expected, 1, 0.02) << elevation << k;
  }
}

TEST(LightIntegral, TheOrderOfLightsIsIrrelevant) {
  const DropInstant drop = concave_drop(0.15, 0.1);
  const View view = view_from_elevation(20);
  const Eigen::Vector3d a = light_direction(10, 30), b = light_direction(40, 120);
  const Eigen::Vector3d c = light_direction(-20, 250);
  const auto abc = fluxes(drop, view, lights_at({a, b, c}, 5), {});
  const auto cab = fluxes(drop, view, lights_at({c, a, b}, 5), {});
  EXPECT_EQ(abc[0], cab[1]);
  EXPECT_EQ(abc[1], cab[2]);
  EXPECT_EQ(abc[2], cab[0]);
  EXPECT_EQ(abc[3], cab[3]);
  EXPECT_GT(abc[0], 0);
}

// A picture of 16 x 24 pixels of a drop that falls over half of it.
std::vector<double> picture(const DropInstant& drop, const Eigen::Vector3d& light) {
  StreakFrame frame;
  frame.width_px = 16;
  frame.height_px = 40;
  frame.pixel_m = 0.25e-3;
  frame.centre_column = 8;
  StreakWindow window = make_window(frame, 3, 1.6e-3, 12, 24);
  const ConeLights lights = lights_at({light}, 5);
  FieldOptions options = deep(3);
  const SpanSlices moment = {.travel = {12, 24}};
  integrate_lights(trace_exit_field(drop, view_from_elevation(0), lights, options), lights, frame,
                   moment, window);
  window.values.resize(static_cast<std::size_t>(window.rows * window.width_px));  // the light's
  return window.values;
}

TEST(LightIntegral, TheTopOfTheDropIsTheTopOfThePicture) {
  // P_3 of amplitude 0.2 reaches 1.2 r0 above the centre and 0.8 r0 below: 4.8 and 3.2 pixels of r0
  // / 4 from row 6, that is into row 1 and into row 9 (its first fifth), and no farther.
  StreakFrame frame;
  frame.width_px = frame.height_px = 12;
  frame.pixel_m = 0.25e-3;
  frame.centre_column = 6;
  StreakWindow window = make_window(frame, 2, 1.3e-3, 6, 6);
  const DropInstant drop = frozen_drop({{.n = 3, .amplitude = 0.2}});
  const ExitField field = trace_exit_field(drop, view_from_elevation(0), lights_at({}, 5), deep(3));
  const SpanSlices moment = {.travel = {6, 6}};
  integrate_lights(field, lights_at({}, 5), frame, moment, window);
  const auto covered = [&](int row) {
    const double* columns = window.row(1, row - window.first_row);
    return std::accumulate(columns, columns + 12, 0.0);
  };
  EXPECT_EQ(covered(0), 0);
  EXPECT_GT(covered(1), 0.3);
  EXPECT_GT(covered(9), 0.1);
  EXPECT_EQ(covered(10), 0);
}

TEST(LightIntegral, MirroredLightsGiveMirroredPictures) {
  // A drop that is symmetric about the plane of view and vertical: y -> -y mirrors the columns. The
  // map's grid is symmetric too, up to the diagonals of its quads: error of linear triangles, 1 %
  // of the brightest pixel.
  const DropInstant drop = concave_drop(0.1, 0.05);  // phi_drop = 0: even in y
  for (const double azimuth : {35.0, 90.0, 150.0}) {
    const auto left = picture(drop, light_direction(20, azimuth));
    const auto right = picture(drop, light_direction(20, -azimuth));
    const double brightest = *std::max_element(left.begin(), left.end());
    ASSERT_GT(brightest, 0);
    double most = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::size_t mirrored = i / 16 * 16 + 15 - i % 16;
      most = std::max(most, std::abs(left[i] - right[mirrored]) / brightest);
    }
    EXPECT_LT(most, 0.01) << azimuth;
  }
}

TEST(LightIntegral, TheSameFluxReachesFineAndCoarsePictures) {
  const DropInstant drop = concave_drop(0.1, 0.05);
  const Eigen::Vector3d light = light_direction(20, 90);
  const auto pixels = picture(drop, light);
  const double fine = std::accumulate(pixels.begin(), pixels.end(), 0.0) / 16;  // pixels of r0 / 4
  const auto coarse = fluxes(drop, view_from_elevation(0), lights_at({light}, 5), deep(3));
  EXPECT_NEAR(fine / coarse[0], 1, 1e-10);
}

TEST(LightIntegral, LightsOfAllDirectionsTogetherAreTheEnvironment) {
  // Cones tile nothing, but averaged over the sphere the light per unit irradiance times its
  // projected solid angle pi sin^2 is the environment's: mean over a spiral of 600 lights of
  // 4 pi / (pi sin^2) x L equals env. Spacing below the cone; the sampling errs by about 1 %.
  const DropInstant drop = concave_drop(0.1, 0.05);
  std::vector<Eigen::Vector3d> directions;
  const int count = 600;
  for (int k = 0; k < count; ++k) {
    const double z = -1 + (k + 0.5) * 2 / count, phi = k * pi * (3 - std::sqrt(5.0));
    const double rho = std::sqrt(1 - z * z);
    directions.push_back({rho * std::cos(phi), rho * std::sin(phi), z});
  }
  const double half_angle = 8;
  const auto flux =
      fluxes(drop, view_from_elevation(0), lights_at(directions, half_angle), deep(2));
  const double mean = std::accumulate(flux.begin(), flux.end() - 2, 0.0) / count;
  // Each cone of solid angle 2 pi (1 - cos) holds radiance 1 / (pi sin^2).
  const double sine = std::sin(half_angle * degree);
  const double solid_angle = 2 * pi * (1 - std::cos(half_angle * degree));
  const double env = mean * pi * sine * sine * 4 * pi / solid_angle;
  EXPECT_NEAR(env / flux[count], 1, 0.02);
}

}  // namespace
}  // namespace pluvia
