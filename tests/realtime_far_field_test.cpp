// Few far streaks that stand for many: what they count for, and the picture.
#include <cmath>

#include <gtest/gtest.h>

#include "realtime/far_field.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

// Of the scene's rain at time 0.
std::vector<SizedCell> all_cells(const Scene& scene, const RainSpace& space) {
  const RainPackets packets = make_rain_packets(scene.rain, space, {.scheme = PacketScheme::world});
  const PacketChoice choice = select_packets(scene.rain, space, packets, scene.camera, 0);
  return packet_cells(scene.rain, space, choice, scene.camera, 0);
}

// Rain all around, as far as 20 m, of which the picture holds a part. At 20 m and 1/60 s
// 60 x 0.14 m x (20 m)^2 / 165 px = 21 streaks cross a pixel within an e-fold.
Scene dense_rain() {
  Scene scene = rainy_scene(0);
  scene.mesh = {};
  scene.lights = {{.name = "sun", .kind = LightKind::sun, .illuminance_lux = {9, 7, 4}}};
  scene.rain.box_min_m = {-30, -30, -3};
  scene.rain.box_max_m = {30, 30, 7};
  scene.rain.sizes = {{.drops_per_m3 = 60}};
  return scene;
}

TEST(FarField, TheDropsOfACellCountForAllOfThem) {
  const Scene scene = dense_rain();
  const RainSpace space = make_rain_space(scene);
  int thinned = 0, whole = 0;
  for (const SizedCell& cell : all_cells(scene, space)) {
    const KeptDrops kept = kept_drops(scene, space, cell, 2);
    EXPECT_NEAR(kept.drops * kept.counts_for, cell.cell.count, 1e-9 * cell.cell.count);
    EXPECT_GE(kept.counts_for, 1);
    EXPECT_EQ(kept_drops(scene, space, cell, 0).drops, cell.cell.count);
    EXPECT_EQ(kept_drops(scene, space, cell, 0).counts_for, 1);
    (kept.counts_for > 1 ? thinned : whole) += cell.cell.count > 0;
  }
  EXPECT_GT(thinned, 100);
  EXPECT_GT(whole, 10);
}

TEST(FarField, WhereFewStreaksCrossAPixelEachIsDrawn) {
  const Scene scene = dense_rain();
  const RainSpace space = make_rain_space(scene);
  const double length_m = space.sizes[0].speed_m_s * scene.camera.exposure_s;
  // n L s^2 / f = 4
  const double edge_m = std::sqrt(4 * camera_frame(scene.camera).focal_px / (60 * length_m));
  const double cell_m = space.sizes[0].cell_m;
  for (const SizedCell& cell : all_cells(scene, space)) {
    if (cell.cell.count == 0) continue;
    const Eigen::Vector2d middle = cell_m * Eigen::Vector2d(cell.cell.x + 0.5, cell.cell.y + 0.5) -
                                   scene.camera.position_m.head<2>();
    const KeptDrops kept = kept_drops(scene, space, cell, 4);
    if (middle.norm() < edge_m) {
      EXPECT_EQ(kept.counts_for, 1);
    } else if (middle.norm() > edge_m + 1.5 * cell_m) {
      EXPECT_GT(kept.counts_for, 1);
    }
  }
}

TEST(FarField, DropsNearALampAreAllDrawn) {
  Scene scene = dense_rain();
  const RainSpace space = make_rain_space(scene);
  const Eigen::Vector3d lamp_m(4, 15, 5);
  Scene lit = scene;
  lit.lights.push_back({.name = "lamp", .position_m = lamp_m, .intensity_cd = {1, 1, 1}});
  int near = 0, far = 0;
  for (const SizedCell& cell : all_cells(scene, space)) {
    if (cell.cell.count == 0) continue;
    const Eigen::Vector2d middle =
        space.sizes[0].cell_m * Eigen::Vector2d(cell.cell.x + 0.5, cell.cell.y + 0.5);
    const double beside_m = (middle - lamp_m.head<2>()).norm();
    const double counts_for = kept_drops(lit, space, cell, 4).counts_for;
    const double without = kept_drops(scene, space, cell, 4).counts_for;
    EXPECT_LE(counts_for, without);
    // At 16 m four streaks cross a pixel over 5 m of the way.
    if (beside_m < 1) {
      EXPECT_EQ(counts_for, 1);
      ++near;
    }
    if (beside_m > 15) {
      EXPECT_EQ(counts_for, without);
      ++far;
    }
  }
  EXPECT_GT(near, 3);
  EXPECT_GT(far, 100);
}

TEST(FarField, NothingJumpsWhileTheCameraMoves) {
  Scene scene = dense_rain();
  const RainSpace space = make_rain_space(scene);
  const auto cells = all_cells(scene, space);
  Scene moved = scene;
  moved.camera.position_m.x() += 1e-6;
  for (const SizedCell& cell : cells) {
    const KeptDrops before = kept_drops(scene, space, cell, 4);
    const KeptDrops after = kept_drops(moved, space, cell, 4);
    // The share goes like the distance squared; thinned cells are metres away.
    EXPECT_NEAR(before.counts_for, after.counts_for, 4e-6 * before.counts_for);
    EXPECT_NEAR(before.drops, after.drops, 4e-6 * before.drops + 1e-12);
  }
}

TEST(FarField, ADensityMapThinsLater) {
  Scene scene = dense_rain();
  scene.rain.density = {.width = 1,
                        .height = 1,
                        .share = {0.25F},
                        .min_m = {-40, -40},
                        .max_m = {40, 40},
                        .height_m = 7};
  sum_density(scene.rain.density);
  const RainSpace space = make_rain_space(scene);
  const Scene plain = dense_rain();
  const RainSpace plain_space = make_rain_space(plain);
  const auto cells = all_cells(scene, space);
  int thinned = 0;
  for (const SizedCell& cell : cells) {
    const double many = kept_drops(plain, plain_space, cell, 1).counts_for;
    const double few = kept_drops(scene, space, cell, 1).counts_for;
    if (many < 4) {
      EXPECT_EQ(few, 1);
    }
    // A cell that keeps one drop for all has nothing to thin.
    if (few > 1 && many < cell.cell.count) {
      EXPECT_NEAR(few, many / 4, 1e-9 * many);
      ++thinned;
    }
  }
  EXPECT_GT(thinned, 10);
}

double sum(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(value);
  return sum;
}

TEST(FarField, LightAndOpticalDepthStayInTheMean) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = dense_rain();
  RainRenderer all(scene, quarter_atlas());
  RainRenderer few(scene, quarter_atlas(), {.far_streaks = 2});
  double light = 0, few_light = 0, tau = 0, few_tau = 0, drawn = 0;
  for (const double time_s : {0.0, 1.9}) {
    const Frame a = all.render(time_s), b = few.render(time_s);
    EXPECT_TRUE(all_finite(b.color));
    EXPECT_GT(b.packets.drops_stood_for, b.packets.drops_looked_at);
    EXPECT_EQ(b.packets.drops_looked_at + b.packets.drops_stood_for, a.packets.drops_looked_at);
    EXPECT_EQ(a.packets.drops_stood_for, 0);
    EXPECT_LT(b.streaks_in_view, a.streaks_in_view / 2);
    light += sum(a.rain), few_light += sum(b.rain);
    tau += sum(a.rain_tau), few_tau += sum(b.rain_tau);
    drawn += static_cast<double>(b.streaks_in_view);
  }
  // Each streak drawn adds its share with a relative deviation of less than 2 (near ones are as
  // bright as they are rare, but those are drawn in both): 4 deviations of the sum of all.
  const double bound = 4 * 2 / std::sqrt(drawn);
  EXPECT_LT(bound, 0.15);
  EXPECT_NEAR(few_tau / tau, 1, bound);
  EXPECT_NEAR(few_light / light, 1, bound);
}

TEST(FarField, ManyStreaksAPixelAreTheSameBytesAsAll) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = dense_rain();
  RainRenderer all(scene, quarter_atlas());
  RainRenderer many(scene, quarter_atlas(), {.far_streaks = 1e6});
  EXPECT_EQ(all.render(0.5).color.values, many.render(0.5).color.values);
}

TEST(FarField, BillboardsDrawEveryDrop) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = dense_rain();
  RainRenderer all(scene, quarter_atlas(), {.path = RainPath::billboards_2010});
  RainRenderer few(scene, quarter_atlas(), {.path = RainPath::billboards_2010, .far_streaks = 2});
  EXPECT_EQ(all.render(0.5).color.values, few.render(0.5).color.values);
}

TEST(FarField, QuadsDrawTheSameFewStreaks) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = dense_rain();
  RainRenderer walked(scene, quarter_atlas(), {.far_streaks = 2});
  RainRenderer quads(scene, quarter_atlas(), {.widest_splat_px = 0, .far_streaks = 2});
  const Frame a = walked.render(0.5), b = quads.render(0.5);
  EXPECT_EQ(a.streaks_in_view, b.streaks_in_view);
  // As much as the walk differs from quads without it (realtime_splat_test).
  EXPECT_LT(relative_rmse(a.rain, b.rain), 0.03);
  EXPECT_LT(relative_rmse(a.rain_tau, b.rain_tau), 0.03);
  bool stands_for_many = false;
  for (const StreakRecord& record : quads.streak_records(0.5).streaks)
    stands_for_many = stands_for_many || record.counts_for > 4;
  EXPECT_TRUE(stands_for_many);
}

TEST(FarField, EveryPacketSchemeGivesTheSameBytes) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = dense_rain();
  RainRenderer world(scene, quarter_atlas(),
                     {.far_streaks = 2, .packets = {.scheme = PacketScheme::world}});
  const Frame frame = world.render(0.5);
  for (const PacketScheme scheme : {PacketScheme::tree, PacketScheme::grid}) {
    RainRenderer other(scene, quarter_atlas(), {.far_streaks = 2, .packets = {.scheme = scheme}});
    EXPECT_EQ(other.render(0.5).color.values, frame.color.values) << packet_scheme_name(scheme);
  }
}

TEST(FarField, SaysWhatItExpects) {
  PLUVIA_NEEDS_OPENGL();
  for (const double wrong : {0.5, -1.0, 2e6, std::nan("")})
    EXPECT_THROW(RainRenderer(dense_rain(), quarter_atlas(), {.far_streaks = wrong}),
                 std::runtime_error);
}

}  // namespace
}  // namespace pluvia
