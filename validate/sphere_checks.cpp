#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "raytrace/drop_intersect.h"
#include "raytrace/light_integral.h"
#include "validate/checks.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double water_index = 1.333;
constexpr double radius_m = 1.6e-3;

// The exits of the camera ray that meets a sphere at impact b (0 .. 1), up to order p = 3.
std::vector<PathExit> trace_at_impact(const DropInstant& sphere, double b) {
  const Eigen::Vector3d to_camera = {1, 0, 0};
  const Eigen::Vector3d origin = {4 * radius_m, b * radius_m, 0};
  std::vector<PathExit> exits;
  const auto hit = intersect_drop(sphere, origin, -to_camera, RaySide::outside);
  if (hit) {
    PathOptions options;
    options.refractive_index = water_index;
    trace_exits(sphere, hit->position, hit->normal, to_camera, options, exits);
  }
  return exits;
}

DropInstant unit_sphere() {
  DropShape shape;
  shape.mean_radius_m = radius_m;
  return drop_at(shape, 0);
}

const PathExit* exit_of_order(const std::vector<PathExit>& exits, int order) {
  for (const PathExit& exit : exits) {
    if (exit.order == order && exit.throughput > 0) return &exit;
  }
  return nullptr;
}

// Angle between the light's way before and after the drop: light comes from exit.direction, goes to
// +x.
double scattering_angle_deg(const PathExit& exit) {
  return std::acos(std::clamp(-exit.direction.x(), -1.0, 1.0)) * 180 / pi;
}

void add_energies(const DropInstant& sphere, Report& report) {
  const int rays = 4000;
  std::array<double, 4> energy = {};
  for (int k = 0; k < rays; ++k) {
    const double i = pi / 2 * (k + 0.5) / rays;  // uniform in the angle: smooth up to the rim
    for (const PathExit& exit : trace_at_impact(sphere, std::sin(i))) {
      energy[static_cast<std::size_t>(exit.order)] +=
          exit.throughput * std::sin(2 * i) * pi / 2 / rays;
    }
  }
  for (int p = 0; p <= 3; ++p) {
    const double expected = sphere_energy(water_index, p);
    report.checks.push_back(
        deviation(fmt::format("sphere.energy.p{}", p), energy[static_cast<std::size_t>(p)],
                  expected, 0.003, "relative",
                  "Share of the power on a sphere (n = 1.333) that leaves with this order: traced "
                  "paths against the closed form with s and p kept apart, whose values agree "
                  "with data/tables/sphere_energy_fractions.csv to 1e-6. No uncertainty: both are "
                  "quadratures converged to 1e-6. The averaged Fresnel would be 8 % off at p = 2.",
                  expected));
  }
}

// The extremum of the scattering angle over the impact, by golden section on traced rays.
double traced_rainbow_deg(const DropInstant& sphere, int order, double sign) {
  const auto angle = [&](double b) {
    const auto exits = trace_at_impact(sphere, b);
    const PathExit* exit = exit_of_order(exits, order);
    return exit ? sign * scattering_angle_deg(*exit) : 1e9;
  };
  double low = 0.6, high = 0.999;
  const double golden = (std::sqrt(5.0) - 1) / 2;
  for (int step = 0; step < 60; ++step) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    (angle(a) < angle(b) ? high : low) = angle(a) < angle(b) ? b : a;
  }
  return sign * angle(0.5 * (low + high));
}

void add_rainbows(const DropInstant& sphere, Report& report) {
  for (int p = 2; p <= 3; ++p) {
    // Order 2 turns back at its smallest angle, order 3 at its largest.
    report.checks.push_back(deviation(
        fmt::format("sphere.rainbow.p{}_deg", p), traced_rainbow_deg(sphere, p, p == 2 ? 1 : -1),
        sphere_rainbow_rad(water_index, p) * 180 / pi, 0.01, "deg",
        "Rainbow angle as the extremum of traced exit directions over the impact, against "
        "Descartes: "
        "cos^2 i = (n^2 - 1)/(p^2 - 1). The extremum is flat, so a golden section in double "
        "precision finds its value to 1e-7 deg."));
  }
}

// Angles that are at least 6 degrees from the edge of p = 1 and from both bows: beyond the cone,
// and where the closed form itself varies slowly.
std::vector<double> smooth_angles_deg() {
  std::vector<double> angles;
  for (double a = 4; a <= 176; a += 4) {
    const bool near = std::abs(a - 82.8) < 6 || std::abs(a - 129.1) < 6 || std::abs(a - 137.9) < 6;
    if (!near) angles.push_back(a);
  }
  return angles;
}

void add_intensity(const DropInstant& sphere, Report& report) {
  const double cone_rad = pi / 180;
  const std::vector<double> angles = smooth_angles_deg();
  ConeLights lights;
  lights.half_angle_rad = cone_rad;
  for (const double a : angles) lights.directions.push_back(light_direction(0, 180 - a));
  StreakFrame frame;
  frame.width_px = 1;  // one pixel over the whole drop
  frame.height_px = 1;
  frame.pixel_m = 4 * radius_m;
  frame.centre_column = 0.5;
  frame.path_top_row = 0.5;
  StreakWindow window = make_window(frame, static_cast<int>(angles.size()) + 2, radius_m, 0.5, 0.5);
  FieldOptions options;
  options.paths.refractive_index = water_index;
  const ExitField field = trace_exit_field(sphere, view_from_elevation(0), lights, options);
  const SpanSlices moment = {.travel = {0.5, 0.5}};
  integrate_lights(field, lights, frame, moment, window);
  double square = 0;
  Curve traced{"exit field, 1 degree cone", {}, {}, {}}, closed{"closed form", {}, {}, {}};
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double disc_px = pi / 16;  // (radius / pixel)^2 pi
    const double ours = window.row(static_cast<int>(k), 0)[0] / disc_px;
    const double theirs = sphere_intensity_in_cone(water_index, 3, angles[k] * pi / 180, cone_rad);
    square += std::pow(ours / theirs - 1, 2);
    traced.x.push_back(angles[k]);
    traced.y.push_back(ours);
    closed.x.push_back(angles[k]);
    closed.y.push_back(theirs);
  }
  report.checks.push_back(
      deviation("sphere.intensity.rms", std::sqrt(square / static_cast<double>(angles.size())), 0,
                0.02, "relative",
                fmt::format("Root mean square of field / closed form - 1 for {} one-degree lights "
                            "around a sphere, orders 0 to 3, at least 6 degrees from the edge of "
                            "p = 1 and from both rainbows. One deterministic field: no "
                            "uncertainty.",
                            angles.size())));
  report.plots.push_back({"A sphere's light by scattering angle",
                          "scattering angle [deg]",
                          "(d sigma / d Omega) / (pi a^2) [1/sr]",
                          false,
                          true,
                          {closed, traced}});
}

}  // namespace

Check deviation(const std::string& name, double measured, double expected, double bound,
                const std::string& unit, const std::string& why, double scale) {
  Check check;
  check.name = name;
  check.measured = measured;
  check.expected = expected;
  check.value = std::abs(measured - expected) / scale;
  check.bound = bound;
  check.unit = unit;
  check.why = why;
  return check;
}

void add_sphere_checks(Report& report) {
  const DropInstant sphere = unit_sphere();
  add_energies(sphere, report);
  add_rainbows(sphere, report);
  add_intensity(sphere, report);
}

}  // namespace pluvia
