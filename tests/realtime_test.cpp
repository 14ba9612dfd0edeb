#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "atlas/atlas_lookup.h"
#include "atlas/atomic_file.h"
#include "raytrace/drop_field.h"
#include "raytrace/streak_geometry.h"
#include "raytrace/streak_placement.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_renderer.h"
#include "tests/frame_threads.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

constexpr double degree = std::numbers::pi / 180;

// Packets of the whole world: every drop of the field is looked at.
constexpr RenderOptions no_selection = {.packets = {.scheme = PacketScheme::world}};

// Thin streaks have no records.
constexpr RenderOptions all_quads = {.widest_splat_px = 0};

TEST(RainRenderer, DropsAreWhereTheDropFieldSaysAlsoAfterADay) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(5000);
  RainRenderer renderer(scene, quarter_atlas(), no_selection);
  for (const double time_s : {0.0, 3.7, 86400.0, 86400.0 * 30 + 0.123}) {
    const auto drops = drop_field(scene, make_rain_space(scene), 10, time_s);
    const std::vector<float> centres = renderer.drop_centres_m(time_s);
    ASSERT_EQ(centres.size(), 3 * drops.size());
    double worst_m = 0;
    for (std::size_t i = 0; i < centres.size(); ++i)
      worst_m = std::max(worst_m, std::abs(static_cast<double>(centres[i]) -
                                           drops[i / 3].centre_m[static_cast<int>(i % 3)]));
    // Integers decide everything but the last product: 2^-24 of an 18 m box is 1e-6 m.
    EXPECT_LT(worst_m, 5e-6) << "at " << time_s << " s";
  }
}

struct View {
  const char* name;
  Eigen::Vector3d position_m, target_m;
};

const View views[] = {{"level", {0.3, -0.4, 1.6}, {1, 5, 2.1}},
                      {"looking up", {0.3, 0.4, 0.5}, {1, 1.5, 5}},
                      {"looking down", {0.1, -0.4, 6.5}, {1, 2, 0}},
                      {"straight up the fall", {0.3, 0.4, 0.5}, {0.3, 0.4, 5}},
                      {"straight down the fall", {0.3, 0.4, 9}, {0.3, 0.4, 0}}};

double angle_between_deg(const LightDirection& light, const FoldedAngles& wanted) {
  const double v = light.elevation_deg * degree, w = wanted.light_elevation_deg * degree;
  const double h = (light.azimuth_deg - wanted.light_azimuth_deg) * degree;
  const Eigen::Vector3d a(std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v));
  const Eigen::Vector3d b(std::cos(w), 0, std::sin(w));
  return std::atan2(a.cross(b).norm(), a.dot(b)) / degree;
}

// A float holds a pixel coordinate of 1e3 to 6e-5; angles come from an atan of 3e-6 rad.
void expect_same_placement(const StreakRecord& record, const StreakPlacement& placed) {
  const auto near = [](const glm::vec2& a, const Eigen::Vector2d& b, double bound) {
    EXPECT_NEAR(static_cast<double>(a.x), b.x(), bound);
    EXPECT_NEAR(static_cast<double>(a.y), b.y(), bound);
  };
  const double px = placed.origin_px.norm() + placed.row_px.norm() * 500;
  near(record.origin_px, placed.origin_px, 1e-5 * px + 1e-3);
  near(record.column_px, placed.column_px, 1e-4 * placed.column_px.norm());
  near(record.row_px, placed.row_px, 1e-4 * placed.row_px.norm());
  EXPECT_NEAR(static_cast<double>(record.path_rows), placed.path_rows, 1e-3);
  EXPECT_NEAR(static_cast<double>(record.depth_m), placed.depth_m, 1e-5);
  EXPECT_NEAR(static_cast<double>(record.view_elevation_deg), placed.view_elevation_deg, 1e-3);
  if (std::isinf(placed.clip_row))
    EXPECT_GT(record.clip_row, 1e29f);
  else
    EXPECT_NEAR(static_cast<double>(record.clip_row), placed.clip_row, 0.02);
}

void expect_same_cells(const StreakAtlas& atlas, const StreakRecord& record,
                       const LitStreakRecord& lit, const LitStreak& expected,
                       const StreakPlacement& placed, int oscillation) {
  const FoldedAngles folded =
      fold_angles(placed.view_elevation_deg, expected.light_elevation_deg,
                  expected.light_azimuth_deg, oscillation, views_below(atlas));
  const CellChoice choice = choose_cells(atlas, folded);
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
    double wanted = 0, found = 0;  // a view named twice or with weight 0 counts for what it adds
    for (int i = 0; i < 2; ++i) {
      wanted += choice.view[i] == view ? choice.view_weight[i] : 0;
      found += record.view[i] == view ? static_cast<double>(record.view_weight[i]) : 0;
    }
    EXPECT_NEAR(found, wanted, 1e-4);  // 1e-3 of 20 degrees
  }
  // Near a spot's rim t^2 is small: 2 t dt E of 20 lux, with dt = 6e-8 / 0.16 and less.
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(static_cast<double>(lit.light[c]), expected.irradiance_lux[c],
                1e-5 * expected.irradiance_lux.norm() + 2e-5);
  // Half-way between two lights rounding decides: then both are as near.
  const auto light = static_cast<std::size_t>(lit.cell >> 1 & 0x7fff);
  EXPECT_NEAR(angle_between_deg(atlas.lights[light], folded),
              angle_between_deg(atlas.lights[static_cast<std::size_t>(choice.light)], folded),
              2e-3);
  if (std::abs(std::sin(expected.light_azimuth_deg * degree)) > 1e-4) {
    EXPECT_EQ(lit.cell & 1, folded.mirrored ? 1u : 0u);
    EXPECT_EQ(static_cast<int>(lit.cell >> 16), folded.oscillation);
  }
}

void expect_streaks_as_their_formulas_say(const StreakAtlas& atlas, Scene scene) {
  for (const View& view : views) {
    SCOPED_TRACE(view.name);
    scene.camera.position_m = view.position_m;
    scene.camera.target_m = view.target_m;
    RainRenderer renderer(scene, atlas, all_quads);
    const StreakRecords records = renderer.streak_records(1.25);
    std::size_t next = 0, skipped = 0;
    for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 1.25)) {
      const auto placed = place_streak(scene, drop, streak_geometry(atlas));
      if (!placed || next == records.streaks.size()) continue;
      // Both lists are in order of id; a drop that the picture does not show has no record.
      const StreakRecord& record = records.streaks[next];
      const double dx = static_cast<double>(record.origin_px.x) - placed->origin_px.x();
      const double dz = static_cast<double>(record.depth_m) - placed->depth_m;
      if (std::abs(dx) > 0.5 || std::abs(dz) > 1e-4) {
        ++skipped;
        continue;
      }
      expect_same_placement(record, *placed);
      for (std::size_t i = 0; i < scene.lights.size(); ++i)
        expect_same_cells(atlas, record, records.lit[next * records.lit_per_streak + i],
                          placed->lights[i], *placed, drop.oscillation);
      EXPECT_EQ(layer_of(record), drop.oscillation);
      ++next;
      if (testing::Test::HasFailure()) FAIL() << "drop " << drop.id;
    }
    // Every record belongs to a drop, and there are many: nothing was skipped by mistake.
    EXPECT_EQ(next, records.streaks.size());
    EXPECT_GT(next, 100u) << skipped << " drops out of the picture";
  }
}

TEST(RainRenderer, StreaksArePlacedAndLitAsTheirFormulasSay) {
  PLUVIA_NEEDS_OPENGL();
  expect_streaks_as_their_formulas_say(quarter_atlas(), rainy_scene(20000));
}

TEST(RainRenderer, SpotsAndSunsLightDropsAsTheirFormulasSay) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(20000);
  Light spot{"spot", {0, 5, 5}, {400, 300, 200}, LightKind::spot};
  spot.direction = Eigen::Vector3d(0.6, 0, -0.8);
  spot.inner_half_angle_deg = 30;
  spot.radius_m = 0.5;
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(1, 2, -2) / 3;
  sun.illuminance_lux = {8, 7, 6};
  scene.lights = {spot, sun};
  expect_streaks_as_their_formulas_say(quarter_atlas(), scene);
}

TEST(RainRenderer, EightTapsAreThoseOfTheLookup) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(20000);
  const StreakAtlas& atlas = quarter_atlas();
  RainRenderer renderer(scene, atlas, {.widest_splat_px = 0, .lookup = LookupMode::trilinear});
  const StreakRecords records = renderer.streak_records(1.25);
  ASSERT_EQ(records.lit_per_streak, 9u);  // two lights, a uniform sky
  ASSERT_EQ(records.lit.size(), 9 * records.streaks.size());
  const auto rows = light_rows(atlas);
  std::size_t next = 0;
  for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 1.25)) {
    const auto placed = place_streak(scene, drop, streak_geometry(atlas));
    if (!placed || next == records.streaks.size()) continue;
    const StreakRecord& record = records.streaks[next];
    if (std::abs(static_cast<double>(record.origin_px.x) - placed->origin_px.x()) > 0.5 ||
        std::abs(static_cast<double>(record.depth_m) - placed->depth_m) > 1e-4)
      continue;
    for (std::size_t i = 0; i < 2; ++i) {
      const LitStreak& lit = placed->lights[i];
      const FoldedAngles folded =
          fold_angles(placed->view_elevation_deg, lit.light_elevation_deg, lit.light_azimuth_deg,
                      drop.oscillation, views_below(atlas));
      // By cell, since a weight of nothing may name any.
      std::map<std::uint32_t, double> wanted, found;
      for (const LightTap& tap : light_taps(rows, folded)) {
        const int set =
            tap.mirrored ? mirrored_oscillation(folded.oscillation) : folded.oscillation;
        const bool flip = folded.mirrored != tap.mirrored;
        wanted[static_cast<std::uint32_t>(set << 16 | tap.light << 1 | (flip ? 1 : 0))] +=
            tap.weight * lit.irradiance_lux[0];
      }
      for (std::size_t t = 0; t < 4; ++t) {
        const LitStreakRecord& tap = records.lit[9 * next + 4 * i + t];
        found[tap.cell] += static_cast<double>(tap.light[0]);
      }
      // Angles from an atan of 3e-6 rad, in steps of 20 degrees.
      for (const auto& [cell, lux] : wanted)
        EXPECT_NEAR(found[cell], lux, 1e-4 * lit.irradiance_lux[0]) << std::hex << cell;
    }
    ++next;
    if (testing::Test::HasFailure()) FAIL() << "drop " << drop.id;
  }
  EXPECT_EQ(next, records.streaks.size());
  EXPECT_GT(next, 1000u);
}

TEST(RainRenderer, TheNearestLookupTakesOneView) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(5000);
  scene.camera.target_m = {1, 5, 4};
  RainRenderer renderer(scene, quarter_atlas(),
                        {.widest_splat_px = 0, .lookup = LookupMode::nearest});
  for (const StreakRecord& record : renderer.streak_records(1.25).streaks) {
    const int nearest = static_cast<int>(
        std::lround(std::abs(static_cast<double>(record.view_elevation_deg)) / 20));
    const double off =
        std::abs(std::abs(static_cast<double>(record.view_elevation_deg)) / 20 - nearest);
    if (std::abs(off - 0.5) < 1e-3) continue;  // rounding decides
    EXPECT_EQ(record.view.x, std::min(nearest, 4));
    EXPECT_EQ(record.view_weight.x, 1.0f);
    EXPECT_EQ(record.view_weight.y, 0.0f);
  }
}

TEST(RainRenderer, ViewsFromBelowAreTheAtlassOwnWhereItHasThem) {
  PLUVIA_NEEDS_OPENGL();
  StreakAtlas atlas = quarter_atlas();
  for (std::size_t i = 0; i < 5; ++i) atlas.views[i].elevation_deg = 40 * static_cast<int>(i) - 80;
  ASSERT_EQ(views_below(atlas), ViewsBelow::own);
  expect_streaks_as_their_formulas_say(atlas, rainy_scene(20000));
}

TEST(RainRenderer, EveryDropThatMeetsThePictureHasARecord) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(20000);
  RainRenderer renderer(scene, quarter_atlas(), all_quads);
  // A drop counts when its path's middle is in the picture.
  std::size_t inside = 0;
  for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 0.5)) {
    const auto placed = place_streak(scene, drop, streak_geometry(quarter_atlas()));
    if (!placed || placed->clip_row < 150) continue;
    const Eigen::Vector2d middle =
        placed->origin_px + 4 * placed->column_px + 127.5 * placed->row_px;
    inside += middle.x() > 0 && middle.x() < 160 && middle.y() > 0 && middle.y() < 120;
  }
  const std::size_t found = renderer.streak_records(0.5).streaks.size();
  EXPECT_GE(found, inside);
  EXPECT_LT(found, inside * 2);
  EXPECT_GT(inside, 500u);
}

// Two sizes, one of them slanted, and a single drop.
Scene mixed_scene() {
  Scene scene = rainy_scene(4000);
  scene.rain.sizes.push_back({.r0_m = 0.8e-3, .drops_per_m3 = 3, .velocity_m_s = {3, -1, -5}});
  scene.drops = {{.centre_m = {0.8, 3, 2.5}, .r0_m = 2e-3, .oscillation = 3}};
  return scene;
}

TEST(RainRenderer, SlantedRainOfSeveralSizesIsWhereTheDropFieldSays) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = mixed_scene();
  scene.drops.clear();  // after a day it has fallen 700 km
  DensityMap& map = scene.rain.density;
  map = {.width = 16, .height = 16};
  for (int i = 0; i < 256; ++i) map.share.push_back(static_cast<float>(i * 37 % 256) / 255.0f);
  sum_density(map);
  for (const double far_m : {0.0, 1e4}) {
    const Eigen::Vector3d to(far_m, -far_m, 0);
    map.min_m = Eigen::Vector2d(-6, -6) + to.head<2>();
    map.max_m = Eigen::Vector2d(6, 12) + to.head<2>();
    map.height_m = 7;
    scene.camera.position_m += to;
    scene.camera.target_m += to;
    scene.rain.box_min_m += to;
    scene.rain.box_max_m += to;
    RainRenderer renderer(scene, quarter_atlas(), no_selection);
    const RainSpace space = make_rain_space(scene);
    for (const double time_s : {0.3, 86400.25}) {
      const auto drops = drop_field(scene, space, 10, time_s);
      const std::vector<float> centres = renderer.drop_centres_m(time_s);
      ASSERT_EQ(centres.size(), 3 * drops.size());
      double worst_m = 0;
      for (std::size_t i = 0; i < centres.size(); ++i)
        worst_m = std::max(worst_m, std::abs(static_cast<double>(centres[i]) -
                                             drops[i / 3].centre_m[static_cast<int>(i % 3)]));
      // 5e-6 m as above, and what the world's coordinate loses in float: 2^-25 of 10 km.
      EXPECT_LT(worst_m, far_m > 0 ? 6e-4 : 5e-6) << far_m << " m, " << time_s << " s";
    }
  }
}

std::string frame_bytes(const Frame& frame) {
  std::string bytes;
  for (const Image* image :
       {&frame.color, &frame.background, &frame.rain, &frame.rain_tau, &frame.depth_m})
    bytes.append(reinterpret_cast<const char*>(image->values.data()),
                 image->values.size() * sizeof(float));
  return bytes;
}

// The number of threads is read once in a process, so each runs this very test with a file to
// write.
TEST(RainRenderer, AFrameHasTheSameBytesForEveryRunAndNumberOfThreads) {
  PLUVIA_NEEDS_OPENGL();
  if (const char* file = file_of_rerun()) {
    Scene scene = rainy_scene(20000);
    scene.splashes.emplace();
    RainRenderer renderer(scene, quarter_atlas());
    std::ofstream(file, std::ios::binary) << frame_bytes(renderer.render(0.5));
    return;
  }
  const std::vector<std::string> frames = bytes_of_reruns({1, 2, 2});
  ASSERT_FALSE(frames[0].empty());
  EXPECT_EQ(sha256(frames[0]), sha256(frames[1]));
  EXPECT_EQ(sha256(frames[1]), sha256(frames[2]));
}

// A wall at y = 4, from x = -1 to 1 and up to z = 3, and what it hides from a lamp.
bool wall_hides(const Eigen::Vector3d& lamp_m, const Eigen::Vector3d& at_m, double grow_m) {
  const double share = (4 - lamp_m.y()) / (at_m.y() - lamp_m.y());
  if (!(share > 0 && share < 1)) return false;
  const Eigen::Vector3d through = lamp_m + share * (at_m - lamp_m);
  return std::abs(through.x()) < 1 + grow_m && through.z() < 3 + grow_m;
}

TEST(RainRenderer, DropsBehindAWallGetNoLightAndThoseBesideItAllOfIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(20000);
  add_rectangle(scene.mesh, {-1, 4, -5}, {2, 0, 0}, {0, 0, 8}, {});
  Light spot{"spot", {0.5, 9, 3.5}, {400, 300, 200}, LightKind::spot};
  spot.direction = Eigen::Vector3d(0, -1, -0.2).normalized();
  spot.outer_half_angle_deg = 45;
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(0.1, -1, -0.5).normalized();
  sun.illuminance_lux = {8, 7, 6};
  scene.lights = {{"lamp", {0.2, 8, 2.5}, {900, 700, 400}}, spot, sun};
  const auto lit_records = [&](bool shadow) {
    for (Light& light : scene.lights) light.shadow = shadow;
    RainRenderer renderer(scene, quarter_atlas(), all_quads);
    return renderer.streak_records(1.25);
  };
  const StreakRecords open = lit_records(false), shaded = lit_records(true);
  ASSERT_EQ(open.lit.size(), shaded.lit.size());
  const RainSpace space = make_rain_space(scene);
  std::size_t next = 0;
  int dark[3] = {}, bright[3] = {};
  for (const Drop& drop : drop_field(scene, space, 10, 1.25)) {
    const auto placed = place_streak(scene, drop, streak_geometry(quarter_atlas()));
    if (!placed || next == open.streaks.size()) continue;
    const double dz = static_cast<double>(open.streaks[next].depth_m) - placed->depth_m;
    const double dx = static_cast<double>(open.streaks[next].origin_px.x) - placed->origin_px.x();
    if (std::abs(dx) > 0.5 || std::abs(dz) > 1e-4) continue;
    const Eigen::Vector3d end = drop.centre_m + drop.velocity_m_s / 60;
    for (std::size_t i = 0; i < 3; ++i) {
      // Far away along the sun's light.
      const Eigen::Vector3d from =
          i < 2 ? scene.lights[i].position_m
                : Eigen::Vector3d(drop.centre_m - 1e4 * scene.lights[i].direction);
      const float before = open.lit[open.lit_per_streak * next + i].light[0];
      const float after = shaded.lit[open.lit_per_streak * next + i].light[0];
      // What two texels of a map with 1024 a side do not know for sure; the sun's spans 85 m.
      const double edge_m = i < 2 ? 0.03 : 0.17;
      const bool surely = drop.centre_m.y() < 4 - 3 * edge_m &&
                          wall_hides(from, drop.centre_m, -edge_m) &&
                          wall_hides(from, end, -edge_m);
      const bool perhaps = wall_hides(from, drop.centre_m, edge_m) || wall_hides(from, end, edge_m);
      if (surely) {
        EXPECT_EQ(after, 0) << i << ", drop at " << drop.centre_m.transpose();
        ++dark[i];
      } else if (!perhaps && end.z() > edge_m) {
        EXPECT_EQ(after, before) << i << ", drop at " << drop.centre_m.transpose();
        ++bright[i];
      }
    }
    ++next;
    if (testing::Test::HasFailure()) FAIL() << "drop " << drop.id;
  }
  EXPECT_EQ(next, open.streaks.size());
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(dark[i], 30) << i;
    EXPECT_GT(bright[i], 300) << i;
  }
}

TEST(RainRenderer, ACameraOnAPathSeesWhatACameraAtThatPlaceSees) {
  PLUVIA_NEEDS_OPENGL();
  Scene moving = mixed_scene();
  moving.camera_path = {{0, {0.3, -0.4, 1.6}, {1, 5, 2.1}}, {2, {1.5, 2, 3}, {1, 5, 2.1}}};
  RainRenderer renderer(moving, quarter_atlas());
  renderer.render(0);
  const Frame moved = renderer.render(1.25);
  Scene still = mixed_scene();
  still.camera = camera_at(moving, 1.25);
  const Frame there = RainRenderer(still, quarter_atlas()).render(1.25);
  EXPECT_EQ(moved.streaks_in_view, there.streaks_in_view);
  // Vertices are relative to the first camera: 2^-24 of 3 m.
  double worst = 0, sum = 0;
  for (std::size_t i = 0; i < moved.rain.values.size(); ++i) {
    const auto a = static_cast<double>(moved.rain.values[i]);
    const auto b = static_cast<double>(there.rain.values[i]);
    worst = std::max(worst, std::abs(a - b));
    sum += b;
  }
  EXPECT_GT(sum, 0);
  EXPECT_EQ(worst, 0) << "a streak's depth test may flip on an edge, none does here";
}

TEST(RainRenderer, EverySchemeOfPacketsGivesTheSameBytes) {
  PLUVIA_NEEDS_OPENGL();
  std::string first;
  long world_drops = 0;
  for (const PacketScheme scheme : {PacketScheme::world, PacketScheme::tree, PacketScheme::grid}) {
    for (const auto selection : {PacketSelection::rectangle, PacketSelection::hull}) {
      RainRenderer renderer(mixed_scene(), quarter_atlas(), {.packets = {scheme, selection, 64}});
      const Frame frame = renderer.render(0.5);
      if (first.empty()) first = frame_bytes(frame);
      EXPECT_TRUE(first == frame_bytes(frame)) << packet_scheme_name(scheme);
      if (scheme == PacketScheme::world) {
        world_drops = frame.packets.drops_looked_at;
      } else {
        EXPECT_LT(frame.packets.drops_looked_at, world_drops) << packet_scheme_name(scheme);
      }
    }
  }
}

}  // namespace
}  // namespace pluvia
