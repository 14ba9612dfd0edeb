#include "atlas/atlas_lookup.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace pluvia {
namespace {

int mirrored_oscillation(int oscillation) {
  switch (oscillation) {
    case 2:
      return 4;
    case 4:
      return 2;
    case 6:
      return 8;
    case 8:
      return 6;
    default:
      return oscillation;
  }
}

using Direction = std::array<double, 3>;

Direction direction(double elevation_deg, double azimuth_deg) {
  const double v = elevation_deg * std::numbers::pi / 180;
  const double h = azimuth_deg * std::numbers::pi / 180;
  return {std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v)};
}

// Squared chord: grows with the angle, and unlike the cosine it keeps its digits near 0.
double squared_distance(const Direction& a, const Direction& b) {
  const double x = a[0] - b[0];
  const double y = a[1] - b[1];
  const double z = a[2] - b[2];
  return x * x + y * y + z * z;
}

int nearest_light(const StreakAtlas& atlas, const FoldedAngles& angles) {
  // Directions half-way between two lights come out of the rounding a few 1e-16 apart: a tie is
  // what lies within this, far below any angle that matters.
  constexpr double tie = 1e-12;
  const Direction wanted = direction(angles.light_elevation_deg, angles.light_azimuth_deg);
  int nearest = 0;
  double least = 5;  // a squared chord is at most 4
  for (std::size_t i = 0; i < atlas.lights.size(); ++i) {
    const LightDirection& light = atlas.lights[i];
    const double distance =
        squared_distance(wanted, direction(light.elevation_deg, light.azimuth_deg));
    if (distance < least - tie) {
      least = distance;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

}  // namespace

ViewsBelow views_below(const StreakAtlas& atlas) {
  assert(!atlas.views.empty());
  return atlas.views.front().elevation_deg < 0 ? ViewsBelow::own : ViewsBelow::flipped;
}

FoldedAngles fold_angles(double view_elevation_deg, double light_elevation_deg,
                         double light_azimuth_deg, int oscillation, ViewsBelow below) {
  assert(std::abs(view_elevation_deg) <= 90 && std::abs(light_elevation_deg) <= 90);
  assert(std::isfinite(light_azimuth_deg));
  const bool flipped = below == ViewsBelow::flipped && view_elevation_deg < 0;
  // "+ 0.0" and "0.0 -" turn a -0.0 into 0.0.
  FoldedAngles folded = {
      .view_elevation_deg = (flipped ? -1 : 1) * view_elevation_deg + 0.0,
      .light_elevation_deg = flipped ? 0.0 - light_elevation_deg : light_elevation_deg + 0.0,
      .light_azimuth_deg = std::fmod(light_azimuth_deg, 360.0) + 0.0,
      .oscillation = oscillation};
  // Now -360 < azimuth < 360; 181 and -179 are the same direction.
  if (folded.light_azimuth_deg <= -180) folded.light_azimuth_deg += 360;
  if (folded.light_azimuth_deg > 180) folded.light_azimuth_deg -= 360;
  if (folded.light_azimuth_deg < 0) {
    folded.light_azimuth_deg = -folded.light_azimuth_deg;
    folded.mirrored = true;
    folded.oscillation = mirrored_oscillation(oscillation);
  }
  return folded;
}

CellChoice choose_cells(const StreakAtlas& atlas, const FoldedAngles& angles) {
  assert(!atlas.views.empty() && !atlas.lights.empty());
  CellChoice choice = {.light = nearest_light(atlas, angles)};
  const int last = static_cast<int>(atlas.views.size()) - 1;
  int above = 0;  // first view beyond the wanted elevation
  while (above <= last &&
         atlas.views[static_cast<std::size_t>(above)].elevation_deg <= angles.view_elevation_deg) {
    ++above;
  }
  if (above == 0 || above > last) {
    choice.view[0] = choice.view[1] = above == 0 ? 0 : last;
    return choice;
  }
  const double low = atlas.views[static_cast<std::size_t>(above) - 1].elevation_deg;
  const double high = atlas.views[static_cast<std::size_t>(above)].elevation_deg;
  choice.view[0] = above - 1;
  choice.view[1] = above;
  choice.view_weight[1] = (angles.view_elevation_deg - low) / (high - low);
  choice.view_weight[0] = 1 - choice.view_weight[1];
  return choice;
}

}  // namespace pluvia
