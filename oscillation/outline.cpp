#include "oscillation/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr int intervals = 48;  // of psi
constexpr double step_rad = pi / intervals;

// r cos psi / scale is a trigonometric polynomial of degree N <= 11 in psi, so that its second
// derivative is at most N^2 = 121 times its largest value on the whole circle (Bernstein). A
// maximum rises above the nearer sample by at most half of that times (step / 2)^2 = 6.5 % of the
// largest value, which on the far side of the drop may be three times the one on this side: a
// sample below 0.8 of the highest cannot be beside the highest maximum.
constexpr double worth_a_look = 0.8;

struct Profile {
  const HarmonicSurface<double>& surface;
  const OutlineRay& ray;

  Eigen::Vector3d direction(double psi) const {
    return std::cos(psi) * ray.across + std::sin(psi) * ray.to_camera;
  }
  double reach(double psi) const { return evaluate(surface, direction(psi)).h * std::cos(psi); }
};

// Newton on the slope of the reach, kept within one sampling interval of the start.
double polished(const Profile& profile, double start) {
  double psi = start;
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Eigen::Vector3d u = profile.direction(psi);
    const Eigen::Vector3d along =
        -std::sin(psi) * profile.ray.across + std::cos(psi) * profile.ray.to_camera;
    const auto value = evaluate(profile.surface, u);
    const double slope_h = value.gradient.dot(along);
    const double bend_h = along.dot(hessian(profile.surface, u) * along) - value.gradient.dot(u);
    const double c = std::cos(psi), s = std::sin(psi);
    const double slope = slope_h * c - value.h * s;
    const double bend = bend_h * c - 2 * slope_h * s - value.h * c;
    if (!(bend < 0)) break;  // no maximum here: the sample stands
    const double next = std::clamp(psi - slope / bend, start - step_rad, start + step_rad);
    const bool done = std::abs(next - psi) < 1e-12;
    psi = next;
    if (done) break;
  }
  return profile.reach(psi) >= profile.reach(start) ? psi : start;
}

}  // namespace

OutlineRay outline_ray(double view_elevation_rad, double view_azimuth_rad, double theta_rad) {
  const double ce = std::cos(view_elevation_rad), se = std::sin(view_elevation_rad);
  const double ca = std::cos(view_azimuth_rad), sa = std::sin(view_azimuth_rad);
  const Eigen::Vector3d right = {-sa, ca, 0}, up = {-se * ca, -se * sa, ce};
  return {std::cos(theta_rad) * up + std::sin(theta_rad) * right, {ce * ca, ce * sa, se}};
}

Eigen::Vector3d outline_direction(const HarmonicSurface<double>& surface, const OutlineRay& ray) {
  const Profile profile{surface, ray};
  std::array<double, intervals + 1> reach = {};
  for (std::size_t k = 0; k < reach.size(); ++k) {
    reach[k] = profile.reach(-0.5 * pi + step_rad * static_cast<double>(k));
  }
  const double highest = *std::max_element(reach.begin(), reach.end());
  double best = 0, best_reach = -1;
  for (std::size_t k = 1; k + 1 < reach.size(); ++k) {
    const bool peak = reach[k] >= reach[k - 1] && reach[k] >= reach[k + 1];
    if (!peak || reach[k] < worth_a_look * highest) continue;
    const double psi = polished(profile, -0.5 * pi + step_rad * static_cast<double>(k));
    const double here = profile.reach(psi);
    if (here <= best_reach) continue;
    best_reach = here;
    best = psi;
  }
  return profile.direction(best);
}

double outline_radius_m(const HarmonicSurface<double>& surface, const OutlineRay& ray) {
  const Eigen::Vector3d u = outline_direction(surface, ray);
  return std::max(0.0, surface.scale * evaluate(surface, u).h * u.dot(ray.across));
}

}  // namespace pluvia
