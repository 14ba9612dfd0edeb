#include "raytrace/splash.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "oscillation/fall_speed.h"
#include "oscillation/water.h"
#include "raytrace/rain_space.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
const double density_kg_m3 = water_density_kg_m3(20);
const double tension_n_m = water_surface_tension_n_m(20);
constexpr double air_density_kg_m3 = 1.204;
constexpr double air_viscosity_m2_s = 1.51e-5;

constexpr double far_share = 0.35;
constexpr double radius_spread = 0.45, speed_spread = 0.25;
constexpr double speed_share = 0.22;
constexpr double elevation_deg = 62, elevation_spread_deg = 8;
constexpr double crown_share = 0.1;

// Uniform numbers in (0, 1) and normal ones, of one seed.
class Draws {
 public:
  Draws(std::uint32_t seed, std::uint32_t variant) : seed_(seed), variant_(variant) {}
  double uniform() { return std::ldexp(rain_hash(seed_, variant_, next_++)[0] + 0.5, -32); }
  double normal() {  // Box and Muller, drawn again beyond two standard deviations
    while (true) {
      const double radius = std::sqrt(-2 * std::log(uniform()));
      const double value = radius * std::cos(2 * pi * uniform());
      if (std::abs(value) < 2) return value;
    }
  }

 private:
  std::uint32_t seed_, variant_, next_ = 0;
};

Eigen::Vector3d direction(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

// The rim at even azimuths, a little uneven.
void add_crown(const SplashTable& table, Draws& draws, std::vector<SplashPart>& parts) {
  const double radius_m = table.radius_m * std::cbrt(crown_share / crown_beads);
  for (int i = 0; i < crown_beads; ++i) {
    const double azimuth_rad = 2 * pi * (i + 0.6 * (draws.uniform() - 0.5)) / crown_beads;
    const double height = 0.9 + 0.2 * draws.uniform();
    parts.push_back(
        {.radius_m = radius_m, .first = {std::cos(azimuth_rad), std::sin(azimuth_rad), height}});
  }
}

// When a droplet is back on a level surface; by halving, since it rises once and falls once.
double flight_s(double upward_m_s, double drag_s) {
  const auto height = [&](double t) {
    return -(upward_m_s + gravity_m_s2 * drag_s) * drag_s * std::expm1(-t / drag_s) -
           gravity_m_s2 * drag_s * t;
  };
  double low = 0, high = 2 * upward_m_s / gravity_m_s2;
  for (int i = 0; i < 36; ++i) {
    const double middle = (low + high) / 2;
    (height(middle) > 0 ? low : high) = middle;
  }
  return high;
}

// The tau of linear drag with which a droplet flies as far as with the full one: the length grows
// with tau.
double equal_drag_s(const SplashPart& part) {
  const double along_m_s = part.velocity_m_s.head<2>().norm(), up_m_s = part.velocity_m_s.z();
  const double wanted_m = flight_with_full_drag(part.radius_m, along_m_s, up_m_s).length_m;
  double low = 1e-4, high = 1e2;
  for (int i = 0; i < 36; ++i) {
    const double middle = std::sqrt(low * high);
    const double length_m = -along_m_s * middle * std::expm1(-flight_s(up_m_s, middle) / middle);
    (length_m < wanted_m ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

// First by how the rim sheds them: within the first half of the crown's life, where it then is.
void add_droplets(const SplashTable& table, Draws& draws, std::vector<SplashPart>& parts) {
  std::vector<double> radii;
  double cubes = 0;
  for (int i = 0; i < table.droplets; ++i) {
    radii.push_back(std::exp(radius_spread * draws.normal()));
    cubes += std::pow(radii.back(), 3);
  }
  const double mean_m =
      table.radius_m * std::cbrt(thrown_share(table.weber) / thrown_count(table.weber));
  const double scale_m = mean_m * std::cbrt(table.droplets / cubes);
  for (const double shape : radii) {
    SplashPart part = {.radius_m = scale_m * shape};
    const double speed_m_s = table.speed_m_s * speed_share * std::sqrt(mean_m / part.radius_m) *
                             std::exp(speed_spread * draws.normal());
    const double azimuth_rad = 2 * pi * draws.uniform();
    const double leaning_deg = elevation_deg + elevation_spread_deg * draws.normal();
    const double age = 0.5 * std::pow(draws.uniform(), 2);
    const CrownSize& crown = table.crown;
    const double place_m =
        crown.first_radius_m + (crown.last_radius_m - crown.first_radius_m) * age * (2 - age);
    part.first = place_m * direction(azimuth_rad, 0);
    part.velocity_m_s = speed_m_s * direction(azimuth_rad, leaning_deg * pi / 180);
    part.delay_s = age * crown.life_s;
    part.drag_s = equal_drag_s(part);
    parts.push_back(part);
  }
}

Eigen::Vector3d bead_place(const CrownSize& crown, const SplashPart& bead, double cosine,
                           double time_s) {
  const double age = time_s / crown.life_s;
  const double radius_m =
      crown.first_radius_m + (crown.last_radius_m - crown.first_radius_m) * age * (2 - age);
  return {radius_m * bead.first.x(), radius_m * bead.first.y(),
          cosine * crown.height_m * bead.first.z() * 4 * age * (1 - age)};
}

// With the surface's normal for z, turned about it.
Eigen::Matrix3d surface_axes(const SplashHit& hit) {
  const Eigen::Vector3d& z = hit.normal;
  const Eigen::Vector3d hint =
      std::abs(z.x()) < 0.9 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 1, 0);
  const Eigen::Vector3d x = (hint - hint.dot(z) * z).normalized(), y = z.cross(x);
  Eigen::Matrix3d axes;
  axes.col(0) = std::cos(hit.turn_rad) * x + std::sin(hit.turn_rad) * y;
  axes.col(1) = std::cos(hit.turn_rad) * y - std::sin(hit.turn_rad) * x;
  axes.col(2) = z;
  return axes;
}

}  // namespace

double weber_number(double diameter_m, double speed_m_s) {
  return density_kg_m3 * speed_m_s * speed_m_s * diameter_m / tension_n_m;
}

double thrown_count(double weber) {
  return std::clamp(droplets_a_threshold * (weber / splash_threshold_weber - 1), 0.0,
                    static_cast<double>(most_splash_droplets));
}

double thrown_share(double weber) {
  return weber > splash_threshold_weber ? far_share * (1 - splash_threshold_weber / weber) : 0;
}

CrownSize crown_size(double diameter_m, double weber) {
  return {.life_s = 4 * std::sqrt(density_kg_m3 * std::pow(diameter_m, 3) / (8 * tension_n_m)),
          .height_m = 0.03 * std::sqrt(weber) * diameter_m,
          .first_radius_m = diameter_m,
          .last_radius_m = 3 * diameter_m};
}

double drag_time_s(double radius_m, double speed_m_s) {
  const double reynolds = 2 * radius_m * speed_m_s / air_viscosity_m2_s;
  const double drag = 24 / reynolds * (1 + 0.15 * std::pow(reynolds, 0.687));
  return 8 * density_kg_m3 * radius_m / (3 * air_density_kg_m3 * drag * speed_m_s);
}

Flight flight_with_full_drag(double radius_m, double along_m_s, double up_m_s) {
  constexpr double step_s = 1e-3;
  Eigen::Vector2d place(0, 0), velocity(along_m_s, up_m_s);
  Flight flight;
  const auto change = [&](const Eigen::Vector2d& v) -> Eigen::Vector2d {
    return Eigen::Vector2d(0, -gravity_m_s2) - v / drag_time_s(radius_m, v.norm());
  };
  while (true) {
    const Eigen::Vector2d middle = velocity + step_s / 2 * change(velocity);
    const Eigen::Vector2d next = place + step_s * middle;
    flight.height_m = std::max(flight.height_m, next.y());
    if (next.y() <= 0) {
      flight.length_m = place.x() + place.y() / (place.y() - next.y()) * (next.x() - place.x());
      return flight;
    }
    place = next;
    velocity += step_s * change(middle);
  }
}

SplashTable splash_table(double radius_m, double speed_m_s, std::uint32_t seed) {
  SplashTable table = {
      .radius_m = radius_m, .speed_m_s = speed_m_s, .weber = weber_number(2 * radius_m, speed_m_s)};
  if (table.weber <= splash_threshold_weber) return table;
  table.crown = crown_size(2 * radius_m, table.weber);
  table.droplets = std::min(static_cast<int>(thrown_count(table.weber)) + 1, most_splash_droplets);
  for (std::uint32_t variant = 0; variant < splash_variants; ++variant) {
    Draws draws(seed, variant);
    add_crown(table, draws, table.parts);
    add_droplets(table, draws, table.parts);
  }
  return table;
}

int thrown_droplets(const SplashTable& table, int variant, double cosine) {
  // Rounded up as often as the variants have it, so that their mean is the law's.
  const double mean = thrown_count(table.weber * cosine * cosine);
  const double rounding = (variant + 0.5) / splash_variants;
  return mean > 0 ? std::min(static_cast<int>(mean + rounding), table.droplets) : 0;
}

Eigen::Vector3d splash_place_m(const SplashTable& table, const SplashPart& part,
                               const SplashHit& hit, double time_s) {
  const Eigen::Matrix3d axes = surface_axes(hit);
  const double along_m_s = -hit.normal.dot(hit.velocity_m_s);
  const double cosine = along_m_s / table.speed_m_s;
  if (part.drag_s == 0) return axes * bead_place(table.crown, part, cosine, time_s);
  const Eigen::Vector3d slide = hit.velocity_m_s + along_m_s * hit.normal;
  const Eigen::Vector3d launch = cosine * (axes * part.velocity_m_s) + splash_drift * slide;
  const Eigen::Vector3d falling = Eigen::Vector3d(0, 0, -gravity_m_s2) * part.drag_s;
  const double t = time_s - part.delay_s;
  return axes * part.first - (launch - falling) * part.drag_s * std::expm1(-t / part.drag_s) +
         falling * t;
}

double splash_duration_s(const SplashTable& table, double lean) {
  double longest = table.crown.life_s;
  for (const SplashPart& part : table.parts) {
    if (part.drag_s > 0)
      longest =
          std::max(longest, part.delay_s + flight_s(lean * part.velocity_m_s.z(), part.drag_s));
  }
  return longest;
}

double splash_reach_m(const SplashTable& table, double duration_s) {
  double reach_m = table.crown.last_radius_m + 1.1 * table.crown.height_m;
  const double drift_m_s = splash_drift * table.speed_m_s;
  for (const SplashPart& part : table.parts) {
    if (part.drag_s == 0) continue;
    const double launched_m = -(part.velocity_m_s.norm() + drift_m_s) * part.drag_s *
                              std::expm1(-duration_s / part.drag_s);
    // What gravity adds along the surface is at most what it takes off the height, for slopes up
    // to 45 degrees; on steeper ones nobody sees the ground below.
    reach_m = std::max(reach_m, part.first.norm() + 2 * launched_m);
  }
  return reach_m;
}

}  // namespace pluvia
