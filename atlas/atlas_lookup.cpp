#include "atlas/atlas_lookup.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace pluvia {
namespace {

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

const char* lookup_name(LookupMode mode) {
  return mode == LookupMode::nearest       ? "nearest"
         : mode == LookupMode::view_linear ? "view-linear"
                                           : "trilinear";
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

std::vector<LightRow> light_rows(const StreakAtlas& atlas) {
  std::vector<LightRow> rows;
  for (std::size_t i = 0; i < atlas.lights.size(); ++i) {
    const LightDirection& light = atlas.lights[i];
    const auto same = std::find_if(rows.begin(), rows.end(), [&](const LightRow& row) {
      return row.elevation_deg == light.elevation_deg;
    });
    LightRow& row = same != rows.end() ? *same : rows.emplace_back();
    row.elevation_deg = light.elevation_deg;
    const int index = static_cast<int>(i);
    const double azimuth = light.azimuth_deg;
    row.entries.push_back({azimuth, index, false});
    // At 0 and 180 a light is its own mirror image, and so is a pole.
    const bool pole = std::abs(light.elevation_deg) == 90;
    if (!pole && azimuth > 0 && azimuth < 180) row.entries.push_back({360 - azimuth, index, true});
  }
  std::sort(rows.begin(), rows.end(),
            [](const LightRow& a, const LightRow& b) { return a.elevation_deg < b.elevation_deg; });
  for (LightRow& row : rows) {
    std::sort(row.entries.begin(), row.entries.end(),
              [](const auto& a, const auto& b) { return a.azimuth_deg < b.azimuth_deg; });
  }
  return rows;
}

namespace {

// The row's two neighbours of an azimuth 0 .. 180, times a weight.
void tap_row(const LightRow& row, double azimuth_deg, double weight, LightTap* taps) {
  std::size_t above = 0;
  while (above < row.entries.size() && row.entries[above].azimuth_deg <= azimuth_deg) ++above;
  const std::size_t count = row.entries.size();
  const LightRow::Entry& low = row.entries[(above + count - 1) % count];
  const LightRow::Entry& high = row.entries[above % count];
  const double from = low.azimuth_deg - (above == 0 ? 360 : 0);
  const double to = high.azimuth_deg + (above == count ? 360 : 0);
  const double share = count > 1 ? (azimuth_deg - from) / (to - from) : 0;
  taps[0] = {low.light, weight * (1 - share), low.mirrored};
  taps[1] = {high.light, weight * share, high.mirrored};
}

}  // namespace

std::array<LightTap, 4> light_taps(const std::vector<LightRow>& rows, const FoldedAngles& angles) {
  assert(!rows.empty());
  std::size_t above = 0;
  while (above < rows.size() && rows[above].elevation_deg <= angles.light_elevation_deg) ++above;
  const std::size_t low = above == 0 ? 0 : above - 1, high = std::min(above, rows.size() - 1);
  const double span = rows[high].elevation_deg - rows[low].elevation_deg;
  const double share = span > 0 ? (angles.light_elevation_deg - rows[low].elevation_deg) / span : 0;
  std::array<LightTap, 4> taps;
  tap_row(rows[low], angles.light_azimuth_deg, 1 - share, &taps[0]);
  tap_row(rows[high], angles.light_azimuth_deg, share, &taps[2]);
  return taps;
}

CellMix mix_cells(const StreakAtlas& atlas, const std::vector<LightRow>& rows,
                  const FoldedAngles& angles, LookupMode mode) {
  const CellChoice choice = choose_cells(atlas, angles);
  CellMix mix;
  for (int i = 0; i < 2; ++i) {
    mix.view[i] = choice.view[i];
    mix.view_weight[i] = choice.view_weight[i];
  }
  if (mode == LookupMode::nearest) {
    mix.view[0] = choice.view[choice.view_weight[1] > 0.5 ? 1 : 0];
    mix.view_weight[0] = 1;
    mix.view_weight[1] = 0;
  }
  if (mode == LookupMode::trilinear)
    mix.lights = light_taps(rows, angles);
  else
    mix.lights[0] = {choice.light, 1, false};
  return mix;
}

}  // namespace pluvia
