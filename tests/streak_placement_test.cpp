#include "raytrace/streak_placement.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

constexpr StreakGeometry geometry = {
    .pixel_m = 2.85e-4, .cell_width_px = 16, .exposure_s = 1.0 / 60, .path_top_row = 15};
constexpr double speed_m_s = 8.49;
constexpr double path_m = speed_m_s / 60;

// 640 x 360 pixels, 40 degrees high, at eye height, looking north.
Scene looking(const Eigen::Vector3d& direction) {
  Scene scene;
  scene.camera.position_m = {0, 0, 1.6};
  scene.camera.target_m = scene.camera.position_m + direction;
  return scene;
}

// The middle of its path is at m.
Drop drop_at(const Eigen::Vector3d& m) {
  return {.centre_m = m + Eigen::Vector3d(0, 0, path_m / 2),
          .velocity_m_s = {0, 0, -speed_m_s},
          .r0_m = 1.6e-3,
          .hit_time_s = 100};
}

// An independent projection: the angles between the ray and the view give the picture's tangents.
Eigen::Vector2d seen_at(const Scene& scene, const Eigen::Vector3d& p) {
  const Eigen::Vector3d f = (scene.camera.target_m - scene.camera.position_m).normalized();
  const Eigen::Vector3d c = p - scene.camera.position_m;
  const Eigen::Vector3d right = f.cross(Eigen::Vector3d(0, 0, 1)).normalized();
  const double tangent = std::tan(scene.camera.vertical_fov_deg / 2 * std::numbers::pi / 180);
  const double along = c.dot(f);
  return {320 + 180 / tangent * c.dot(right) / along,
          180 - 180 / tangent * c.dot(right.cross(f)) / along};
}

Eigen::Vector2d on_screen(const StreakPlacement& placed, double column, double row) {
  return placed.origin_px + column * placed.column_px + row * placed.row_px;
}

TEST(StreakPlacement, ThePathsEndsAreWhereTheDropIsSeenAtShutterOpenAndClose) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-2, 2), ahead(1.5, 30);
  for (int trial = 0; trial < 500; ++trial) {
    const Scene scene = looking({0.3, 1, 0.2 * side(random)});
    const Drop drop = drop_at({side(random), ahead(random), 1.6 + side(random)});
    const auto placed = place_streak(scene, drop, geometry);
    ASSERT_TRUE(placed) << trial;
    const Eigen::Vector3d end = drop.centre_m - Eigen::Vector3d(0, 0, path_m);
    const double top = geometry.path_top_row;
    EXPECT_LT((on_screen(*placed, 8, top) - seen_at(scene, drop.centre_m)).norm(), 1e-8) << trial;
    EXPECT_LT((on_screen(*placed, 8, top + placed->path_rows) - seen_at(scene, end)).norm(), 1e-8)
        << trial;
    // The rows are the path's length across the line of sight.
    const Eigen::Vector3d middle = (drop.centre_m + end) / 2;
    const double slant = std::abs((middle - scene.camera.position_m).normalized().z());
    EXPECT_NEAR(placed->path_rows, path_m / 2.85e-4 * std::sqrt(1 - slant * slant), 1e-8);
  }
}

TEST(StreakPlacement, ColumnsAndShortRowsAreTheProjectionsDerivative) {
  // Against central differences of the independent projection, everywhere in the picture; a step of
  // 1e-5 m leaves 1e-10 of curvature. A drop of 1 mm/s has a path below one row: its rows are the
  // picture's own up, reversed.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-2, 2), ahead(2, 10);
  for (int trial = 0; trial < 200; ++trial) {
    const Scene scene = looking({0.2, 1, 0.15});
    const Eigen::Vector3d m(side(random), ahead(random), 1.6 + side(random));
    Drop drop = drop_at(m);
    drop.velocity_m_s = {0, 0, -1e-3};
    drop.centre_m = m + Eigen::Vector3d(0, 0, 1e-3 / 120);
    const auto placed = place_streak(scene, drop, geometry);
    ASSERT_TRUE(placed && placed->path_rows < 1);
    const Eigen::Vector3d toward = (scene.camera.position_m - m).normalized();
    const Eigen::Vector3d right = Eigen::Vector3d(0, 0, 1).cross(toward).normalized();
    const Eigen::Vector3d up = toward.cross(right);
    const auto moved = [&](const Eigen::Vector3d& w) -> Eigen::Vector2d {
      return (seen_at(scene, m + 1e-5 * w) - seen_at(scene, m - 1e-5 * w)) / 2e-5 * 2.85e-4;
    };
    EXPECT_LT((placed->column_px - moved(right)).norm(), 1e-7) << trial;
    EXPECT_LT((placed->row_px + moved(up)).norm(), 1e-7) << trial;
  }
}

TEST(StreakPlacement, ADropOnTheFallsAxisButNotTheCamerasTakesTheCamerasSide) {
  // Straight above a camera that looks up and north at 60 degrees: its backward axis lies south, so
  // a lamp in the south is on the camera's side.
  Scene scene = looking({0, 0.5, std::sqrt(0.75)});
  scene.lights.push_back({"south", {0, -50, 6.6}, {1, 1, 1}});
  const auto placed = place_streak(scene, drop_at({0, 0, 6.6}), geometry);
  ASSERT_TRUE(placed);
  EXPECT_NEAR(placed->lights[0].light_azimuth_deg, 0, 1e-9);
}

TEST(StreakPlacement, PixelsAreSquareForAHorizontalViewAndSeenFromAfar) {
  // Straight ahead at distance d a database pixel measures focal * pixel_m / d in both directions;
  // the path bends the view by +-path/(2 d), which lengthens its mean by less than (path / d)^2.
  for (double d : {2.0, 10.0, 30.0}) {
    const auto placed = place_streak(looking({0, 1, 0}), drop_at({0, d, 1.6}), geometry);
    ASSERT_TRUE(placed);
    const double expected = 180 / std::tan(20 * std::numbers::pi / 180) * 2.85e-4 / d;
    EXPECT_NEAR(placed->column_px.dot(placed->row_px), 0, 1e-12);
    EXPECT_NEAR(placed->column_px.x(), expected, 1e-9);  // image right
    EXPECT_NEAR(placed->row_px.y(), expected, expected * std::pow(path_m / d, 2));
    EXPECT_NEAR(placed->depth_m, d, 1e-9);
    EXPECT_NEAR(placed->view_elevation_deg, 0, 1e-9);
  }
}

TEST(StreakPlacement, ADropBelowTheEyeIsSeenFromAbove) {
  for (double e : {-60.0, -20.0, 20.0, 60.0}) {
    const double r = e * std::numbers::pi / 180;
    const Eigen::Vector3d from(0, 5 * std::cos(r), 1.6 - 5 * std::sin(r));
    const auto placed =
        place_streak(looking({0, std::cos(r), -std::sin(r)}), drop_at(from), geometry);
    ASSERT_TRUE(placed);
    EXPECT_NEAR(placed->view_elevation_deg, e, 1e-9);
    // Right and down of the picture whichever way the camera is tilted.
    EXPECT_GT(placed->column_px.x(), 0);
    EXPECT_GT(placed->row_px.y(), 0);
  }
}

TEST(StreakPlacement, LampsAreFiledByTheirSideOfTheDrop) {
  // The drop is 5 m north of the camera: south of it is the camera's side (azimuth 0), north is
  // behind (180), east is the picture's right (90), west the left (-90).
  Scene scene = looking({0, 1, 0});
  const Eigen::Vector3d m(0, 5, 1.6);
  const double h = std::sqrt(0.5);
  const struct {
    Eigen::Vector3d direction;
    double elevation_deg, azimuth_deg;
  } lamps[] = {{{0, -1, 0}, 0, 0},   {{0, 1, 0}, 0, 180}, {{1, 0, 0}, 0, 90},
               {{-1, 0, 0}, 0, -90}, {{0, -h, h}, 45, 0}, {{h, 0, -h}, -45, 90}};
  for (const auto& lamp : lamps)
    scene.lights.push_back({"", m + 4 * lamp.direction, {160, 80, 16}});
  scene.lights.push_back({"", m + Eigen::Vector3d(0, 0, 4), {160, 80, 16}});
  scene.lights.push_back({"", m - Eigen::Vector3d(0, 0, 2), {160, 80, 16}});
  const auto placed = place_streak(scene, drop_at(m), geometry);
  ASSERT_TRUE(placed);
  ASSERT_EQ(placed->lights.size(), 8u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(placed->lights[i].light_elevation_deg, lamps[i].elevation_deg, 1e-9) << i;
    const double off = placed->lights[i].light_azimuth_deg - lamps[i].azimuth_deg;
    EXPECT_NEAR(std::remainder(off, 360), 0, 1e-9) << i;  // -180 is 180
    EXPECT_LT((placed->lights[i].irradiance_lux - Eigen::Vector3d(10, 5, 1)).norm(), 1e-9) << i;
  }
  EXPECT_NEAR(placed->lights[6].light_elevation_deg, 90, 1e-6);
  EXPECT_NEAR(placed->lights[7].light_elevation_deg, -90, 1e-6);
  EXPECT_NEAR(placed->lights[7].irradiance_lux.x(), 40, 1e-9);
}

TEST(StreakPlacement, LookingStraightUpALinelessDropStaysADrop) {
  // The drop falls along the axis: no path on screen, no direction of its own; the picture's right
  // stays right and the streak's picture keeps its size.
  Scene scene = looking({0, 0, 1});
  scene.lights.push_back({"east", {100, 0, 6.6}, {1, 1, 1}});
  const auto placed = place_streak(scene, drop_at({0, 0, 6.6}), geometry);
  ASSERT_TRUE(placed);
  EXPECT_NEAR(placed->view_elevation_deg, -90, 1e-9);
  EXPECT_EQ(placed->path_rows, 0.01);
  const double expected = 180 / std::tan(20 * std::numbers::pi / 180) * 2.85e-4 / 5;
  EXPECT_LT((placed->column_px - Eigen::Vector2d(expected, 0)).norm(), 1e-9);
  EXPECT_LT((placed->row_px - Eigen::Vector2d(0, expected)).norm(), 1e-9);
  EXPECT_LT((on_screen(*placed, 8, 15) - Eigen::Vector2d(320, 180)).norm(), 1e-9);
  EXPECT_NEAR(placed->lights[0].light_azimuth_deg, 90, 1e-9);
}

TEST(StreakPlacement, NearTheAxisNothingJumps) {
  // Looking up at drops ever closer to the axis, south to north of it: all numbers stay finite, and
  // the streak points away from where the drop comes from, outward, as it approaches the camera.
  const Scene scene = looking({0, 0, 1});
  for (double off_m : {1.0, 0.1, 1e-2, 1e-4, 1e-7, 1e-12, 0.0})
    for (double sign : {-1.0, 1.0}) {
      const auto placed = place_streak(scene, drop_at({0, sign * off_m, 6.6}), geometry);
      ASSERT_TRUE(placed);
      EXPECT_TRUE(placed->origin_px.allFinite() && placed->row_px.allFinite() &&
                  placed->column_px.allFinite());
      EXPECT_GT(placed->row_px.norm(), 0);
      // 1e-3 m / 5 m is a hundredth of a row's path: from there on the fall-back decides. North is
      // down in this picture.
      if (off_m > 1e-6) {
        EXPECT_GT(placed->row_px.y() * sign, 0) << off_m * sign;
      }
      // Right-handed: the picture is turned, never mirrored.
      EXPECT_GT(
          placed->column_px.x() * placed->row_px.y() - placed->column_px.y() * placed->row_px.x(),
          0);
    }
}

TEST(StreakPlacement, ADropTooNearOrBehindTheCameraIsNotPlaced) {
  const Scene scene = looking({0, 1, 0});
  EXPECT_TRUE(place_streak(scene, drop_at({0, 0.11, 1.6}), geometry));
  EXPECT_FALSE(place_streak(scene, drop_at({0, 0.09, 1.6}), geometry));
  EXPECT_FALSE(place_streak(scene, drop_at({0, -3, 1.6}), geometry));
  // Looking up: open at 0.23 m, closed at 0.09 m.
  const Scene up = looking({0, 0, 1});
  EXPECT_FALSE(place_streak(up, drop_at({0, 0, 1.69 + path_m / 2}), geometry));
  EXPECT_TRUE(place_streak(up, drop_at({0, 0, 1.71 + path_m / 2}), geometry));
}

TEST(StreakPlacement, ElevenCentimetresAheadAStreakFillsThePicture) {
  // 141.5 mm of path at 110 mm: 494.5 px a unit tangent give 636 px.
  const auto placed = place_streak(looking({0, 1, 0}), drop_at({0, 0.11, 1.6}), geometry);
  ASSERT_TRUE(placed);
  EXPECT_NEAR((placed->path_rows * placed->row_px).y(),
              180 / std::tan(20 * std::numbers::pi / 180) * path_m / 0.11, 1e-6);
}

TEST(StreakPlacement, AStreakIsCutWhereItsDropHits) {
  const Scene scene = looking({0, 1, 0});
  Drop drop = drop_at({0, 5, 1.6});
  drop.hit_time_s = geometry.exposure_s / 2;
  const auto half = place_streak(scene, drop, geometry);
  ASSERT_TRUE(half);
  EXPECT_NEAR(half->clip_row, 15 + half->path_rows / 2, 1e-9);
  drop.hit_time_s = geometry.exposure_s * 1.01;
  EXPECT_EQ(place_streak(scene, drop, geometry)->clip_row, HUGE_VAL);
  for (double hit_time_s : {0.0, -1.0}) {
    drop.hit_time_s = hit_time_s;
    EXPECT_FALSE(place_streak(scene, drop, geometry)) << hit_time_s;
  }
}

TEST(StreakPlacement, ADropInsideALampIsNotDrawn) {
  Scene scene = looking({0, 1, 0});
  scene.lights.push_back({"lamp", {0, 5, 1.601}, {1, 1, 1}});
  EXPECT_FALSE(place_streak(scene, drop_at({0, 5, 1.6}), geometry));
  scene.lights[0].position_m.z() = 1.602;
  EXPECT_TRUE(place_streak(scene, drop_at({0, 5, 1.6}), geometry));
  scene.lights[0].radius_m = 0.1;
  EXPECT_FALSE(place_streak(scene, drop_at({0, 5, 1.6}), geometry));
}

TEST(StreakPlacement, ACellsRowsStretchOverThePathAndKeepTheirEnds) {
  // Top 15; the placement's path has 400 rows, the cell's 500.
  EXPECT_EQ(cell_row(0, 15, 400, 500), 0);
  EXPECT_EQ(cell_row(15, 15, 400, 500), 15);
  EXPECT_EQ(cell_row(215, 15, 400, 500), 265);
  EXPECT_EQ(cell_row(415, 15, 400, 500), 515);
  EXPECT_EQ(cell_row(430, 15, 400, 500), 530);
  EXPECT_EQ(cell_row(16, 15, 0, 8), 24);  // no path at all
  double last = -1;
  for (double row = 0; row < 430; row += 0.25) {
    const double mapped = cell_row(row, 15, 400, 500);
    EXPECT_GT(mapped, last) << row;
    last = mapped;
  }
}

TEST(StreakPlacement, ALongExposureIsSeveralPicturesEndToEnd) {
  Scene scene = looking({0, 1, 0});
  scene.camera.exposure_s = 2.5 / 60;
  const Drop drop = drop_at({0.2, 3, 2});
  ASSERT_EQ(segment_times(scene.camera.exposure_s, drop.r0_m, geometry).count, 3);
  double shares = 0;
  for (int k = 0; k < 3; ++k) {
    const auto placed = place_streak(scene, drop, geometry, k);
    ASSERT_TRUE(placed);
    const Eigen::Vector3d start = drop.centre_m + k / 60.0 * drop.velocity_m_s;
    EXPECT_LT((on_screen(*placed, 8, 15) - seen_at(scene, start)).norm(), 1e-8) << k;
    EXPECT_NEAR(placed->time_share, 1 / 2.5, 1e-12);
    if (k < 2)
      EXPECT_EQ(placed->clip_row, HUGE_VAL) << k;
    else
      EXPECT_NEAR(placed->clip_row, 15 + placed->path_rows / 2, 1e-9);
    shares += placed->time_share * (k < 2 ? 1 : 0.5);
  }
  EXPECT_NEAR(shares, 1, 1e-12);
}

TEST(StreakPlacement, AnotherSizeIsThePictureScaledAndItsTimeToThePowerThreeHalves) {
  const Scene scene = looking({0, 1, 0});
  Drop drop = drop_at({0.2, 3, 2});
  const auto traced = place_streak(scene, drop, geometry);
  drop.r0_m /= 4;  // an oscillation lasts an eighth
  EXPECT_EQ(segment_times(scene.camera.exposure_s, drop.r0_m, geometry).count, 8);
  const auto small = place_streak(scene, drop, geometry, 0);
  EXPECT_NEAR(small->column_px.norm() / traced->column_px.norm(), 0.25, 1e-3);
  // Its middle is higher, so it is seen a little more from below: 0.3 %.
  EXPECT_NEAR(small->path_rows, traced->path_rows / 8 * 4, 1);
  EXPECT_NEAR(small->time_share, 0.125, 1e-12);
  drop.r0_m = 4 * 1.6e-3;  // and eight times as long
  const SegmentTimes times = segment_times(scene.camera.exposure_s, drop.r0_m, geometry);
  EXPECT_EQ(times.count, 1);
  EXPECT_NEAR(times.each_s, 8.0 / 60, 1e-12);
  const auto large = place_streak(scene, drop, geometry, 0);
  EXPECT_NEAR(large->clip_row, 15 + large->path_rows / 8, 1e-9);
  EXPECT_NEAR(large->time_share, 8, 1e-12);
}

TEST(StreakPlacement, SegmentsAreBounded) {
  const SegmentTimes times = segment_times(1, 5e-5, geometry);
  EXPECT_EQ(times.count, most_segments);
  EXPECT_NEAR(times.each_s * most_segments, 1, 1e-12);
  EXPECT_EQ(segment_times(1e-6, 1.6e-3, geometry).count, 1);
  EXPECT_EQ(segment_times(1.0 / 60 * (1 + 1e-7), 1.6e-3, geometry).count, 1);
}

TEST(StreakPlacement, AHitCutsTheSegmentInWhichItHappensAndDropsThoseBehind) {
  Scene scene = looking({0, 1, 0});
  scene.camera.exposure_s = 3.0 / 60;
  Drop drop = drop_at({0.2, 3, 2});
  drop.hit_time_s = 1.25 / 60;
  EXPECT_EQ(place_streak(scene, drop, geometry, 0)->clip_row, HUGE_VAL);
  const auto second = place_streak(scene, drop, geometry, 1);
  EXPECT_NEAR(second->clip_row, 15 + second->path_rows / 4, 1e-9);
  EXPECT_FALSE(place_streak(scene, drop, geometry, 2));
}

}  // namespace
}  // namespace pluvia
