#include "atlas/atlas_lookup.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

StreakAtlas gn2006_atlas() {
  StreakAtlas atlas;
  for (const int elevation : {0, 20, 40, 60, 80})
    atlas.views.push_back({.elevation_deg = elevation});
  atlas.lights = gn2006_light_directions();
  return atlas;
}

void expect_angles(const FoldedAngles& folded, double view, double light, double azimuth,
                   int oscillation, bool mirrored) {
  EXPECT_EQ(folded.view_elevation_deg, view);
  EXPECT_EQ(folded.light_elevation_deg, light);
  EXPECT_EQ(folded.light_azimuth_deg, azimuth);
  EXPECT_EQ(folded.oscillation, oscillation);
  EXPECT_EQ(folded.mirrored, mirrored);
}

// Angle between two directions by the haversine formula: another road than a difference of vectors,
// and exact for small angles too.
double angle_between(double elevation_a, double azimuth_a, double elevation_b, double azimuth_b) {
  const double rad = std::numbers::pi / 180;
  const double v = std::sin((elevation_a - elevation_b) * rad / 2);
  const double h = std::sin((azimuth_a - azimuth_b) * rad / 2);
  const double x = v * v + std::cos(elevation_a * rad) * std::cos(elevation_b * rad) * h * h;
  return 2 * std::asin(std::sqrt(std::min(1.0, x)));
}

TEST(AtlasLookup, GridDirectionsFindTheirOwnCell) {
  const StreakAtlas atlas = gn2006_atlas();
  for (std::size_t view = 0; view < atlas.views.size(); ++view) {
    for (std::size_t light = 0; light < atlas.lights.size(); ++light) {
      const FoldedAngles folded =
          fold_angles(atlas.views[view].elevation_deg, atlas.lights[light].elevation_deg,
                      atlas.lights[light].azimuth_deg, 2);
      EXPECT_FALSE(folded.mirrored);
      EXPECT_EQ(folded.oscillation, 2);
      const CellChoice choice = choose_cells(atlas, folded);
      EXPECT_EQ(choice.view[0], static_cast<int>(view));
      EXPECT_EQ(choice.view_weight[0], 1);
      EXPECT_EQ(choice.view_weight[1], 0);
      EXPECT_EQ(choice.light, static_cast<int>(light));
    }
  }
}

TEST(AtlasLookup, AzimuthBeyond180IsTheMirrorImageOfTheMirroredDrop) {
  expect_angles(fold_angles(20, 30, 190, 0), 20, 30, 170, 0, true);
  const int partner[10] = {0, 1, 4, 3, 2, 5, 8, 7, 6, 9};
  for (int oscillation = 0; oscillation < 10; ++oscillation) {
    expect_angles(fold_angles(20, 30, 190, oscillation), 20, 30, 170, partner[oscillation], true);
    expect_angles(fold_angles(20, 30, -170, oscillation), 20, 30, 170, partner[oscillation], true);
    expect_angles(fold_angles(20, 30, 170, oscillation), 20, 30, 170, oscillation, false);
  }
}

TEST(AtlasLookup, EndsOfTheAzimuthRangeAreNotMirrored) {
  for (const double azimuth : {0.0, -0.0, 360.0, -360.0, 720.0}) {
    const FoldedAngles folded = fold_angles(0, 0, azimuth, 2);
    expect_angles(folded, 0, 0, 0, 2, false);
    EXPECT_FALSE(std::signbit(folded.light_azimuth_deg)) << azimuth;
  }
  for (const double azimuth : {180.0, -180.0, 540.0, -540.0}) {
    expect_angles(fold_angles(0, 0, azimuth, 2), 0, 0, 180, 2, false);
  }
  expect_angles(fold_angles(0, 0, 359, 6), 0, 0, 1, 8, true);
  expect_angles(fold_angles(0, 0, 361, 6), 0, 0, 1, 6, false);
}

TEST(AtlasLookup, ViewFromBelowIsServedAsTheFlippedViewFromAbove) {
  expect_angles(fold_angles(-20, 30, 50, 2), 20, -30, 50, 2, false);
  expect_angles(fold_angles(-20, -90, 310, 2), 20, 90, 50, 4, true);
  // A level view is no view from below, whatever the sign of its zero; no zero comes out negative.
  const FoldedAngles level = fold_angles(-0.0, 30, 50, 2);
  expect_angles(level, 0, 30, 50, 2, false);
  EXPECT_FALSE(std::signbit(level.view_elevation_deg));
  EXPECT_FALSE(std::signbit(fold_angles(-20, 0, 50, 2).light_elevation_deg));
  EXPECT_FALSE(std::signbit(fold_angles(20, -0.0, 50, 2).light_elevation_deg));
}

TEST(AtlasLookup, AnAtlasWithViewsFromBelowKeepsThem) {
  expect_angles(fold_angles(-20, 30, 50, 2, ViewsBelow::own), -20, 30, 50, 2, false);
  expect_angles(fold_angles(-20, 30, 190, 2, ViewsBelow::own), -20, 30, 170, 4, true);
  expect_angles(fold_angles(20, 30, 190, 2, ViewsBelow::own), 20, 30, 170, 4, true);
  EXPECT_FALSE(std::signbit(fold_angles(-0.0, 0, 0, 2, ViewsBelow::own).view_elevation_deg));
  StreakAtlas atlas = gn2006_atlas();
  EXPECT_EQ(views_below(atlas), ViewsBelow::flipped);
  atlas.views.insert(atlas.views.begin(), {.elevation_deg = -20});
  EXPECT_EQ(views_below(atlas), ViewsBelow::own);
  const CellChoice choice = choose_cells(atlas, fold_angles(-5, 0, 0, 0, views_below(atlas)));
  EXPECT_EQ(choice.view[0], 0);
  EXPECT_DOUBLE_EQ(choice.view_weight[0], 0.25);
}

TEST(AtlasLookup, FoldingTwiceIsFoldingOnce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> elevation(-90, 90);
  std::uniform_real_distribution<double> azimuth(-1000, 1000);
  for (int i = 0; i < 10000; ++i) {
    const FoldedAngles once =
        fold_angles(elevation(random), elevation(random), azimuth(random), i % 10);
    ASSERT_GE(once.view_elevation_deg, 0);
    ASSERT_GE(once.light_azimuth_deg, 0);
    ASSERT_LE(once.light_azimuth_deg, 180);
    const FoldedAngles twice = fold_angles(once.view_elevation_deg, once.light_elevation_deg,
                                           once.light_azimuth_deg, once.oscillation);
    expect_angles(twice, once.view_elevation_deg, once.light_elevation_deg, once.light_azimuth_deg,
                  once.oscillation, false);
  }
}

TEST(AtlasLookup, ViewsAreWeighedLinearlyBetweenNeighbours) {
  const StreakAtlas atlas = gn2006_atlas();
  for (double elevation = 0; elevation <= 80; elevation += 0.37) {
    const CellChoice choice = choose_cells(atlas, {.view_elevation_deg = elevation});
    const double low = atlas.views[static_cast<std::size_t>(choice.view[0])].elevation_deg;
    const double high = atlas.views[static_cast<std::size_t>(choice.view[1])].elevation_deg;
    EXPECT_EQ(choice.view_weight[0] + choice.view_weight[1], 1);
    EXPECT_GE(choice.view_weight[0], 0);
    EXPECT_GE(choice.view_weight[1], 0);
    EXPECT_NEAR(choice.view_weight[0] * low + choice.view_weight[1] * high, elevation, 1e-12);
    EXPECT_LE(high - low, 20);
  }
}

TEST(AtlasLookup, BeyondTheOutermostViewsThatViewStandsAlone) {
  StreakAtlas atlas = gn2006_atlas();
  for (const double elevation : {80.0, 80.1, 90.0}) {
    const CellChoice choice = choose_cells(atlas, {.view_elevation_deg = elevation});
    EXPECT_EQ(choice.view[0], 4) << elevation;
    EXPECT_EQ(choice.view[1], 4) << elevation;
    EXPECT_EQ(choice.view_weight[0], 1) << elevation;
    EXPECT_EQ(choice.view_weight[1], 0) << elevation;
  }
  atlas.views.erase(atlas.views.begin());  // the lowest is 20 now
  const CellChoice choice = choose_cells(atlas, {.view_elevation_deg = 5});
  EXPECT_EQ(choice.view[0], 0);
  EXPECT_EQ(choice.view[1], 0);
  EXPECT_EQ(choice.view_weight[0], 1);
}

TEST(AtlasLookup, LightIsTheNearestDirectionOnTheSphere) {
  const StreakAtlas atlas = gn2006_atlas();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> height(-1, 1);
  std::uniform_real_distribution<double> azimuth(0, 180);
  for (int i = 0; i < 20000; ++i) {
    const double v = std::asin(height(random)) * 180 / std::numbers::pi;
    const double h = azimuth(random);
    const CellChoice choice =
        choose_cells(atlas, {.light_elevation_deg = v, .light_azimuth_deg = h});
    double least = 10;
    for (const LightDirection& light : atlas.lights) {
      least = std::min(least, angle_between(v, h, light.elevation_deg, light.azimuth_deg));
    }
    const LightDirection& chosen = atlas.lights[static_cast<std::size_t>(choice.light)];
    // 1e-9: a tie within the rule's 1e-12 of squared chord, at no less than a degree from both.
    ASSERT_NEAR(angle_between(v, h, chosen.elevation_deg, chosen.azimuth_deg), least, 1e-9)
        << "elevation " << v << " azimuth " << h;
  }
}

TEST(AtlasLookup, PolesFindThePolarLightAtAnyAzimuth) {
  const StreakAtlas atlas = gn2006_atlas();
  for (double azimuth = 0; azimuth <= 180; azimuth += 7.5) {
    EXPECT_EQ(choose_cells(atlas, {.light_elevation_deg = 90, .light_azimuth_deg = azimuth}).light,
              73);
    EXPECT_EQ(choose_cells(atlas, {.light_elevation_deg = -90, .light_azimuth_deg = azimuth}).light,
              0);
  }
}

TEST(AtlasLookup, HalfWayBetweenLightsTheLowerIndexWins) {
  const StreakAtlas atlas = gn2006_atlas();
  for (std::size_t i = 1; i + 2 < atlas.lights.size(); ++i) {
    const LightDirection& light = atlas.lights[i];
    if (light.azimuth_deg == 170) continue;
    const CellChoice beside =
        choose_cells(atlas, {.light_elevation_deg = static_cast<double>(light.elevation_deg),
                             .light_azimuth_deg = light.azimuth_deg + 10.0});
    EXPECT_EQ(beside.light, static_cast<int>(i)) << "between azimuths, light " << i;
    if (light.elevation_deg == 70) continue;
    const CellChoice above =
        choose_cells(atlas, {.light_elevation_deg = light.elevation_deg + 10.0,
                             .light_azimuth_deg = static_cast<double>(light.azimuth_deg)});
    EXPECT_EQ(above.light, static_cast<int>(i)) << "between elevations, light " << i;
  }
}

// What four taps make of a function of the light, mirrored taps taken at the mirrored azimuth.
double tapped(const StreakAtlas& atlas, const FoldedAngles& angles, auto value) {
  double sum = 0;
  for (const LightTap& tap : light_taps(light_rows(atlas), angles)) {
    const LightDirection& light = atlas.lights[static_cast<std::size_t>(tap.light)];
    const double azimuth = light.azimuth_deg;
    sum += tap.weight * value(light.elevation_deg, tap.mirrored ? -azimuth : azimuth);
  }
  return sum;
}

TEST(LightTaps, GiveBackTheGridAndAreLinearBetween) {
  StreakAtlas atlas;
  atlas.lights = gn2006_light_directions();
  for (const LightDirection& light : atlas.lights) {
    const FoldedAngles at = {.light_elevation_deg = static_cast<double>(light.elevation_deg),
                             .light_azimuth_deg = static_cast<double>(light.azimuth_deg)};
    for (const LightTap& tap : light_taps(light_rows(atlas), at)) {
      if (tap.weight == 0) continue;
      EXPECT_EQ(atlas.lights[static_cast<std::size_t>(tap.light)], light);
      EXPECT_FALSE(tap.mirrored);
    }
  }
  const auto plane = [](double v, double h) { return 3 + 0.1 * v + 0.02 * h; };
  for (double v = -70; v <= 70; v += 7) {
    for (double h = 10; h <= 170; h += 4) {
      const FoldedAngles at = {.light_elevation_deg = v, .light_azimuth_deg = h};
      EXPECT_NEAR(tapped(atlas, at, plane), plane(v, h), 1e-12) << v << ", " << h;
    }
  }
}

TEST(LightTaps, AreContinuousWhereTheMirrorBegins) {
  StreakAtlas atlas;
  atlas.lights = gn2006_light_directions();
  const auto value = [](double v, double h) {
    const double level = std::cos(v * 0.0174532925199);  // a pole has one value
    return v + level * (100 * std::sin(h * 0.0174532925) + 10 * std::cos(h * 0.0174532925));
  };
  for (double v = -90; v <= 90; v += 6) {
    for (const double h : {0.0, 180.0}) {
      const auto beside = [&](double off) {
        const FoldedAngles folded = fold_angles(0, v, h + off, 0);
        return tapped(atlas, folded,
                      [&](double e, double a) { return value(e, folded.mirrored ? -a : a); });
      };
      EXPECT_NEAR(beside(1e-6), beside(-1e-6), 1e-4) << v << ", " << h;
    }
  }
}

TEST(LightTaps, WeightsSumToOneForAnySetOfLights) {
  StreakAtlas atlas;
  for (const auto& lights : {std::vector<LightDirection>{{90, 0}},
                             {{10, 30}},
                             {{-10, 50}, {30, 50}, {30, 170}},
                             gn2006_light_directions()}) {
    atlas.lights = lights;
    for (double v = -90; v <= 90; v += 9) {
      for (double h = 0; h <= 180; h += 9) {
        double sum = 0;
        for (const LightTap& tap :
             light_taps(light_rows(atlas), {.light_elevation_deg = v, .light_azimuth_deg = h})) {
          EXPECT_GE(tap.weight, 0);
          sum += tap.weight;
        }
        EXPECT_NEAR(sum, 1, 1e-12);
      }
    }
  }
}

TEST(CellMix, EachModeMixesAsManyCellsAsItSays) {
  StreakAtlas atlas;
  atlas.lights = gn2006_light_directions();
  for (const int elevation : {0, 20, 40}) atlas.views.push_back({.elevation_deg = elevation});
  const auto rows = light_rows(atlas);
  const FoldedAngles at = {
      .view_elevation_deg = 33, .light_elevation_deg = 24, .light_azimuth_deg = 47};
  const auto cells = [&](LookupMode mode) {
    const CellMix mix = mix_cells(atlas, rows, at, mode);
    int views = 0, lights = 0;
    for (int i = 0; i < 2; ++i) views += mix.view_weight[i] > 0;
    for (const LightTap& tap : mix.lights) lights += tap.weight > 0;
    return views * lights;
  };
  EXPECT_EQ(cells(LookupMode::nearest), 1);
  EXPECT_EQ(cells(LookupMode::view_linear), 2);
  EXPECT_EQ(cells(LookupMode::trilinear), 8);
  EXPECT_EQ(mix_cells(atlas, rows, at, LookupMode::nearest).view[0], 2);
}

}  // namespace
}  // namespace pluvia
