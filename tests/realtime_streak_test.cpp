#include <limits>

#include <gtest/gtest.h>

#include "atlas/atlas_lookup.h"
#include "raytrace/drop_field.h"
#include "raytrace/streak_placement.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

const StreakAtlas& shared_atlas() {
  static const StreakAtlas atlas = synthetic_atlas({.layers = 5});
  return atlas;
}

struct Single {  // one drop, one lamp
  Scene scene = {};
  Drop drop = {};
  StreakPlacement placed = {};
};

struct Pose {
  const char* name;
  double column_px;           // how wide a level-0 column is on screen, about
  Eigen::Vector3d direction;  // of the view
  Eigen::Vector2d off_axis;   // where the drop stands, in half pictures right and up
  Eigen::Vector3d lamp_m = {2, 1, 4};
  double bound = 5e-3;  // of the relative error of its flux
};

// The camera is put where the drop's path has the wanted size and place in the picture.
Single single_streak(const Pose& pose) {
  Single single;
  Scene& scene = single.scene;
  scene.camera.width_px = 512;
  scene.camera.height_px = 640;
  scene.camera.vertical_fov_deg = 70;
  scene.camera.exposure_s = shared_atlas().exposure_s;
  scene.lights = {{"lamp", pose.lamp_m, {700, 500, 300}}};
  const Eigen::Vector3d aim(0.5, 0.5, 2);
  scene.drops = {{.centre_m = aim, .oscillation = 2}};
  const Eigen::Vector3d middle = aim - Eigen::Vector3d(0, 0, 8.49 / 60 / 2);
  scene.camera.position_m = middle - pose.direction;
  scene.camera.target_m = middle;
  const CameraFrame frame = camera_frame(scene.camera);
  const double depth_m = frame.focal_px * shared_atlas().pixel_m / pose.column_px;
  const double half_m = depth_m * 320 / frame.focal_px;
  scene.camera.position_m =
      middle - depth_m * frame.forward -
      half_m * (pose.off_axis.x() * frame.right + pose.off_axis.y() * frame.up);
  scene.camera.target_m = scene.camera.position_m + frame.forward;
  const auto drops = drop_field(scene, make_rain_space(scene), 5, 0);
  EXPECT_EQ(drops.size(), 1u);
  single.drop = drops.at(0);
  single.placed = place_streak(scene, single.drop,
                               {shared_atlas().pixel_m, 16, shared_atlas().exposure_s,
                                shared_atlas().views[0].path_top_row})
                      .value();
  return single;
}

double cell_sum(const Image& picture, const CellRect& cell) {
  double sum = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x)
      sum += static_cast<double>(picture.at(cell.x + x, cell.y + y));
  }
  return sum;
}

double sum_of(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, channel));
  }
  return sum;
}

struct Look {  // which cells show the single streak
  FoldedAngles folded = {};
  CellChoice choice = {};
};

Look look_of(const Single& single) {
  const LitStreak& lit = single.placed.lights.at(0);
  Look look;
  look.folded = fold_angles(single.placed.view_elevation_deg, lit.light_elevation_deg,
                            lit.light_azimuth_deg, single.drop.oscillation);
  look.choice = choose_cells(shared_atlas(), look.folded);
  return look;
}

double determinant(const StreakPlacement& p) {
  return std::abs(p.column_px.x() * p.row_px.y() - p.column_px.y() * p.row_px.x());
}

const Pose poses[] = {{"wide", 1, {0, 1, 0}, {0.013, 0.021}},
                      {"one pixel", 1 / 16.0, {0, 1, 0}, {0.013, 0.021}},
                      {"a tenth of a pixel", 1 / 160.0, {0, 1, 0}, {0.013, 0.021}},
                      {"a hundredth of a pixel", 1 / 1600.0, {0, 1, 0}, {0.013, 0.021}},
                      {"wide, slanted, from above", 0.3, {0.2, 1, -1}, {0.6, 0.1}},
                      {"one pixel, slanted, from below", 1 / 16.0, {0.1, 1, 0.9}, {-0.7, 0.4}},
                      {"a tenth of a pixel, slanted", 1 / 160.0, {0, 0.5, -1}, {0.6, 0.6}},
                      {"nearly along the fall", 0.3, {0, 0.02, -1}, {0.2, 0.1}},
                      // All of the path in less than a row, 8 pixels wide: where the spike lies in
                      // a pixel differs across a strip, and the centre line speaks for all of it.
                      {"along the fall", 0.5, {0, 0, -1}, {0, 0}, {2, 1, 4}, 0.02}};

TEST(Streak, ItsFluxOnScreenIsIrradianceTimesItsCells) {
  PLUVIA_NEEDS_OPENGL();
  for (const Pose& pose : poses) {
    const Single single = single_streak(pose);
    const Look look = look_of(single);
    double cells = 0;
    for (int i = 0; i < 2; ++i) {
      const auto& layer = shared_atlas().layers[static_cast<std::size_t>(look.folded.oscillation)];
      cells += look.choice.view_weight[i] *
               cell_sum(layer.point[0],
                        cell_rect(shared_atlas(), look.choice.view[i], look.choice.light, 0));
    }
    RainRenderer renderer(single.scene, shared_atlas());
    const Frame frame = renderer.render(0);
    ASSERT_EQ(frame.streaks_in_view, 1) << pose.name;
    for (int c = 0; c < 3; ++c) {
      const double expected =
          single.placed.lights[0].irradiance_lux[c] * cells * determinant(single.placed);
      // Strips take their brightness where their centre line crosses the pixel; in pixels that a
      // strip only clips, that is off by a part of a pixel: a few 1e-3 where the glint changes.
      EXPECT_NEAR(sum_of(frame.rain, c) / expected, 1, pose.bound)
          << pose.name << ", channel " << c;
    }
  }
}

// The streak picture in double, level 0, at a point of the screen.
double radiance_at(const Single& single, const Look& look, double x, double y) {
  const StreakPlacement& p = single.placed;
  const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - p.origin_px;
  const double det = p.column_px.x() * p.row_px.y() - p.column_px.y() * p.row_px.x();
  const double u = (offset.x() * p.row_px.y() - offset.y() * p.row_px.x()) / det;
  const double r = (p.column_px.x() * offset.y() - p.column_px.y() * offset.x()) / det;
  if (u < 0 || u >= 16 || r > p.clip_row) return 0;
  double value = 0;
  for (int i = 0; i < 2; ++i) {
    const AtlasView& view = shared_atlas().views[static_cast<std::size_t>(look.choice.view[i])];
    const double path = view.path_bottom_row - view.path_top_row;
    const double row = cell_row(r, view.path_top_row, p.path_rows, path);
    if (row < 0 || row >= view.height_px) continue;
    const bool on_path = r > view.path_top_row && r < view.path_top_row + p.path_rows;
    const CellRect cell = cell_rect(shared_atlas(), look.choice.view[i], look.choice.light, 0);
    const int column = look.folded.mirrored ? 15 - static_cast<int>(u) : static_cast<int>(u);
    const auto& layer = shared_atlas().layers[static_cast<std::size_t>(look.folded.oscillation)];
    value +=
        look.choice.view_weight[i] * (on_path ? path / p.path_rows : 1) *
        static_cast<double>(layer.point[0].at(cell.x + column, cell.y + static_cast<int>(row)));
  }
  return value * p.lights[0].irradiance_lux[0];
}

double difference_from_dense_samples(const Single& single, const Image& rain) {
  constexpr int samples = 24;
  const Look look = look_of(single);
  double error = 0, power = 0;
  for (int y = 0; y < rain.height; ++y) {
    for (int x = 0; x < rain.width; ++x) {
      double truth = 0;
      // Beyond half a streak and a pixel's diagonal from the axis there is nothing to sample.
      const Eigen::Vector2d from_axis =
          Eigen::Vector2d(x + 0.5, y + 0.5) - single.placed.origin_px - 8 * single.placed.column_px;
      const Eigen::Vector2d row = single.placed.row_px.normalized();
      const bool near = std::abs(from_axis.x() * row.y() - from_axis.y() * row.x()) <
                        8 * single.placed.column_px.norm() + 1;
      for (int k = 0; near && k < samples * samples; ++k)
        truth += radiance_at(single, look, x + (k % samples + 0.5) / samples,
                             y + (k / samples + 0.5) / samples);
      truth /= samples * samples;
      const double difference = static_cast<double>(rain.at(x, y, 0)) - truth;
      error += difference * difference;
      power += truth * truth;
    }
  }
  return std::sqrt(error / power);
}

TEST(Streak, EveryPixelIsTheMeanOfThePictureOverItsSquare) {
  PLUVIA_NEEDS_OPENGL();
  for (const Pose& pose : {Pose{"wide", 1, {0, 1, 0}, {0.013, 0.021}},
                           Pose{"lit from the left", 1, {0, 1, 0}, {0.013, 0.021}, {-2, 1, 4}},
                           Pose{"slanted", 0.3, {0.2, 1, -1}, {0.6, 0.1}},
                           Pose{"one pixel", 1 / 16.0, {0.1, 1, 0.9}, {-0.7, 0.4}}}) {
    const Single single = single_streak(pose);
    RainRenderer renderer(single.scene, shared_atlas(), {.max_texel_px = 1e-6});
    // 24 x 24 samples of a piecewise constant picture err by about 1/24 of what changes in a pixel
    // at its edge, at random: below 1 %. The strips' centre lines add the rest where they are
    // slanted.
    EXPECT_LT(difference_from_dense_samples(single, renderer.render(0).rain), 0.015) << pose.name;
  }
}

// Of the two views between which a drop is seen; pictures: environment or coverage.
double plain_cells(const Single& single, std::vector<Image> AtlasLayer::*pictures) {
  const Look look = look_of(single);
  const auto& layer = shared_atlas().layers[static_cast<std::size_t>(single.drop.oscillation)];
  double cells = 0;
  for (int i = 0; i < 2; ++i)
    cells += look.choice.view_weight[i] *
             cell_sum((layer.*pictures)[0], cell_rect(shared_atlas(), look.choice.view[i], 0, 0));
  return cells * determinant(single.placed);
}

TEST(Streak, ItsOpticalDepthIsThatOfItsCoverage) {
  PLUVIA_NEEDS_OPENGL();
  const Single single = single_streak(poses[0]);
  RainRenderer renderer(single.scene, shared_atlas());
  const Frame frame = renderer.render(0);
  double covered = 0;
  for (const float tau : frame.rain_tau.values) covered += 1 - std::exp(-static_cast<double>(tau));
  EXPECT_NEAR(covered / plain_cells(single, &AtlasLayer::coverage), 1, 5e-3);
}

TEST(Streak, AUniformEnvironmentShinesThroughItAsItsCellsSay) {
  PLUVIA_NEEDS_OPENGL();
  Single single = single_streak(poses[1]);
  single.scene.lights[0].intensity_cd = {0, 0, 0};
  single.scene.environment.uniform_cd_m2 = {3, 2, 1};
  RainRenderer renderer(single.scene, shared_atlas());
  const Frame frame = renderer.render(0);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(sum_of(frame.rain, c) / plain_cells(single, &AtlasLayer::env), 3 - c, 5e-3);
}

TEST(Streak, AWallInFrontHidesItAndAWallBehindDoesNot) {
  PLUVIA_NEEDS_OPENGL();
  Single single = single_streak(poses[0]);
  RainRenderer open(single.scene, shared_atlas());
  const Image rain = open.render(0).rain;
  const auto y_m = static_cast<float>(single.drop.centre_m.y());
  for (const float offset_m : {-0.01f, 0.01f}) {
    Scene scene = single.scene;
    scene.mesh = {};
    add_rectangle(scene.mesh, {-5, y_m + offset_m, -5}, {10, 0, 0}, {0, 0, 20}, {});
    RainRenderer renderer(scene, shared_atlas());
    const Image seen = renderer.render(0).rain;
    if (offset_m < 0)
      EXPECT_EQ(sum_of(seen, 0), 0);
    else
      EXPECT_GT(sum_of(seen, 0), 0.9 * sum_of(rain, 0));
  }
}

TEST(Streak, ItEndsWhereTheDropHitsTheGround) {
  PLUVIA_NEEDS_OPENGL();
  Single single = single_streak(poses[0]);
  // The ground 5 cm below the drop: 5 of 14.15 cm of the path are left.
  const double ground_m = single.drop.centre_m.z() - 0.05;
  // Behind the drop, but under the centre of the top heights' texel that the drop falls through: a
  // texel is 0.1 m, and their grid starts at the corner of the first rectangle, which is far below.
  add_rectangle(single.scene.mesh, {0.45f, 0.46f, -9}, {0.3f, 0, 0}, {0, 0.3f, 0}, {});
  add_rectangle(single.scene.mesh, {0.495f, 0.502f, static_cast<float>(ground_m)}, {0.04f, 0, 0},
                {0, 0.04f, 0}, {});
  RainRenderer renderer(single.scene, shared_atlas());
  const Frame frame = renderer.render(0);
  single.placed.clip_row = 8 + 495 * 0.05 / 0.1415;
  const double end_px =
      single.placed.origin_px.y() + (single.placed.row_px * single.placed.clip_row).y();
  int last = 0;
  for (int y = 0; y < frame.rain.height; ++y) {
    for (int x = 0; x < frame.rain.width; ++x)
      if (frame.rain.at(x, y, 0) > 0) last = y;
  }
  EXPECT_NEAR(last, end_px, 1.5);
  // One row of pixels too many or too few of 170 would be an error of 170^-1/2 = 8 %.
  EXPECT_LT(difference_from_dense_samples(single, frame.rain), 0.02);
}

TEST(Streak, ItsFluxDoesNotDependOnHowAnExposureFallsIntoPictures) {
  PLUVIA_NEEDS_OPENGL();
  // A drop's light over an exposure T is spread over a path v T: radiance x area goes with 1 / T x
  // T. Exposures of a quarter to three pictures, seen from so far that all of the path is in view
  // under nearly one direction; the look of a cell changes along it, so that parts of one differ.
  for (const double exposure_s : {0.25 / 60, 1.0 / 60, 2.0 / 60, 3.0 / 60}) {
    Single single = single_streak(poses[1]);
    const double traced = [&] {
      RainRenderer renderer(single.scene, shared_atlas());
      return sum_of(renderer.render(0).rain_tau, 0);
    }();
    single.scene.camera.exposure_s = exposure_s;
    RainRenderer renderer(single.scene, shared_atlas());
    const Frame frame = renderer.render(0);
    EXPECT_EQ(frame.streaks_in_view, std::max(1L, std::lround(exposure_s * 60)));
    // Coverage per row is the same for every whole picture; its first quarter has 3 % less.
    EXPECT_NEAR(sum_of(frame.rain_tau, 0) / traced, 1, exposure_s < 1.0 / 61 ? 0.05 : 5e-3)
        << exposure_s;
  }
}

}  // namespace
}  // namespace pluvia
