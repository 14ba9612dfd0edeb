#include "raytrace/rain_packets.h"

#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "raytrace/depth_of_field.h"
#include "raytrace/drop_field.h"
#include "raytrace/streak_placement.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

constexpr StreakGeometry geometry = {
    .pixel_m = 2.85e-4, .cell_width_px = 16, .exposure_s = 1.0 / 60, .path_top_row = 15};

struct View {
  const char* name;
  Eigen::Vector3d direction;
  double fov_deg;
};

const View views[] = {{"level", {0.3, 1, 0.1}, 40},
                      {"up the fall", {0, 0, 1}, 60},
                      {"down the fall", {0, 0, -1}, 30},
                      {"nearly down", {1e-4, 0, -1}, 90},
                      {"wide", {-1, 0.2, 0.4}, 120},
                      {"narrow", {0.7, 0.7, -0.2}, 3},
                      {"along a slanted fall", {4, 2, -7}, 50}};

Scene scene_for(const View& view) {
  Scene scene;
  scene.camera.position_m = {1, 2, 4};
  scene.camera.target_m = scene.camera.position_m + view.direction;
  scene.camera.vertical_fov_deg = view.fov_deg;
  scene.rain.sizes = {{.drops_per_m3 = 8},
                      {.r0_m = 1e-3, .drops_per_m3 = 8, .velocity_m_s = {4, 2, -7}}};
  scene.rain.box_min_m = {-20, -20, 0};
  scene.rain.box_max_m = {20, 20, 9};
  scene.rain.culling_radius_m = 12;
  scene.rain.local_height_m = 6;
  return scene;
}

bool in_picture(const StreakPlacement& placed, const Camera& camera) {
  const double beside_px = circle_px(camera, placed.depth_m);
  // Points along the path, in the middle and at both rims of the picture.
  for (int i = 0; i <= 20; ++i) {
    for (const double column : {0.0, 8.0, 16.0}) {
      const Eigen::Vector2d at = placed.origin_px + column * placed.column_px +
                                 (15 + placed.path_rows * i / 20) * placed.row_px;
      if (at.x() >= -beside_px && at.x() <= camera.width_px + beside_px && at.y() >= -beside_px &&
          at.y() <= camera.height_px + beside_px)
        return true;
    }
  }
  return false;
}

using CellNames = std::set<std::tuple<int, int, int>>;

CellNames names_of(const std::vector<SizedCell>& cells) {
  CellNames names;
  for (const SizedCell& cell : cells)
    EXPECT_TRUE(names.emplace(cell.size, cell.cell.x, cell.cell.y).second) << "a cell twice";
  return names;
}

constexpr PacketScheme schemes[] = {PacketScheme::world, PacketScheme::tree, PacketScheme::grid};

void expect_all_shown(const std::optional<DepthOfField>& lens) {
  for (const View& view : views) {
    Scene scene = scene_for(view);
    scene.camera.depth_of_field = lens;
    const RainSpace space = make_rain_space(scene);
    std::vector<Drop> shown;
    for (const Drop& drop : drop_field(scene, space, 10, 1.3)) {
      for (int k = 0; k < segment_times(scene.camera.exposure_s, drop.r0_m, geometry).count; ++k) {
        const auto placed = place_streak(scene, drop, geometry, k);
        if (placed && in_picture(*placed, scene.camera)) shown.push_back(drop);
      }
    }
    EXPECT_GT(shown.size(), view.fov_deg < 10 ? 5u : 100u) << view.name;
    for (const PacketScheme scheme : schemes) {
      for (const auto selection : {PacketSelection::hull, PacketSelection::rectangle}) {
        for (const double most : {1.0, 300.0, 1e9}) {
          const RainPackets packets =
              make_rain_packets(scene.rain, space, {scheme, selection, most});
          const PacketChoice choice = select_packets(scene.rain, space, packets, scene.camera, 1.3);
          const CellNames cells =
              names_of(packet_cells(scene.rain, space, choice, scene.camera, 1.3));
          for (const Drop& drop : shown)
            ASSERT_TRUE(cells.count({drop.name.size, drop.name.cell_x, drop.name.cell_y}))
                << view.name << ", " << packet_scheme_name(scheme) << ", " << most;
        }
      }
    }
  }
}

TEST(RainPackets, EverySchemeTakesEveryDropThatThePictureShows) {
  expect_all_shown({});
}

TEST(RainPackets, AndEveryDropWhoseCircleReachesIntoIt) {
  expect_all_shown(DepthOfField{.aperture_m = 0.5, .focus_m = 1.5});
}

TEST(RainPackets, TheHullTakesFewerThanTheRectangle) {
  double hull = 0, rectangle = 0;
  for (const View& view : views) {
    const Scene scene = scene_for(view);
    const RainSpace space = make_rain_space(scene);
    const auto taken = [&](PacketSelection selection) {
      const auto packets =
          make_rain_packets(scene.rain, space, {PacketScheme::grid, selection, 100});
      return static_cast<double>(
          select_packets(scene.rain, space, packets, scene.camera, 0).packets.size());
    };
    EXPECT_LE(taken(PacketSelection::hull), taken(PacketSelection::rectangle)) << view.name;
    hull += taken(PacketSelection::hull);
    rectangle += taken(PacketSelection::rectangle);
  }
  EXPECT_LT(hull, 0.8 * rectangle);
}

TEST(RainPackets, TheShadowHoldsWhatThePictureShowsOfTheSlabAndLittleElse) {
  // Points of the prism are thrown on the plane: inside the shadow exactly when their line along
  // the fall meets the frustum within the slab, to the two pixels and the path that the shadow
  // adds.
  for (const View& view : views) {
    const Scene scene = scene_for(view);
    const RainSpace space = make_rain_space(scene);
    const CameraFrame frame = camera_frame(scene.camera);
    for (int size = 0; size < 2; ++size) {
      const LocalSpace local = local_space(space, size, scene.camera.position_m, 0);
      const PlanePolygon shadow = view_shadow(space, size, local, scene.camera);
      const FallFrame& fall = space.sizes[static_cast<std::size_t>(size)].frame;
      const auto inside = [&](const Eigen::Vector2d& p) {
        for (std::size_t i = 0; i < shadow.size(); ++i) {
          const Eigen::Vector2d edge = shadow[(i + 1) % shadow.size()] - shadow[i];
          const Eigen::Vector2d to = p - shadow[i];
          if (edge.x() * to.y() - edge.y() * to.x() < -1e-9) return false;
        }
        return shadow.size() >= 3;
      };
      const auto seen = [&](const Eigen::Vector2d& p, double margin_px, double path_m) {
        const double bottom = local.floor_m - path_m;
        for (int i = 0; i <= 400; ++i) {
          const double z = bottom + (space.local_height_m + path_m) * i / 400;
          const Eigen::Vector3d c =
              p.x() * fall.x + p.y() * fall.y + z * fall.z - scene.camera.position_m;
          const double depth = c.dot(frame.forward);
          if (depth > 1e-3 &&
              std::abs(c.dot(frame.right)) * frame.focal_px <
                  (scene.camera.width_px / 2.0 + margin_px) * depth &&
              std::abs(c.dot(frame.up)) * frame.focal_px <
                  (scene.camera.height_px / 2.0 + margin_px) * depth)
            return true;
        }
        return false;
      };
      int kept = 0;
      for (int j = -24; j <= 24; ++j) {
        for (int i = -24; i <= 24; ++i) {
          const Eigen::Vector2d p = local.centre_m + Eigen::Vector2d(0.5 * i, 0.5 * j);
          if ((p - local.centre_m).norm() > 12) continue;
          EXPECT_TRUE(inside(p) || !seen(p, 0, 0)) << view.name << " " << p.transpose();
          EXPECT_TRUE(seen(p, 12, 0.4) || !inside(p)) << view.name << " " << p.transpose();
          kept += inside(p);
        }
      }
      EXPECT_GT(kept, view.fov_deg > 10 ? 3 : 0) << view.name;
    }
  }
}

TEST(RainPackets, AutomaticTakesTheSchemeOfFewestPackets) {
  Scene scene = scene_for(views[0]);
  RainSpace space = make_rain_space(scene);
  const auto taken = [&](double most) {
    return make_rain_packets(scene.rain, space, {.most_drops = most}).options.scheme;
  };
  EXPECT_EQ(taken(1e6), PacketScheme::world);
  // A prism wider than the box: a tree over the box has the fewer.
  scene.rain.culling_radius_m = 60;
  space = make_rain_space(scene);
  EXPECT_EQ(taken(5000), PacketScheme::tree);
  scene.rain.culling_radius_m = 12;
  scene.rain.box_min_m = {-400, -400, 0};
  scene.rain.box_max_m = {400, 400, 9};
  space = make_rain_space(scene);
  EXPECT_EQ(taken(100), PacketScheme::grid) << "a tree over all of the box has many more leaves";
  scene.rain.box_min_m = Rain().box_min_m;
  scene.rain.box_max_m = Rain().box_max_m;
  space = make_rain_space(scene);
  EXPECT_EQ(taken(100), PacketScheme::grid);
  EXPECT_NE(message_of([&] {
              make_rain_packets(scene.rain, space, {.scheme = PacketScheme::tree});
            }).find("a tree over a rain without bounds"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              make_rain_packets(scene.rain, space, {.most_drops = 0});
            }).find("expected 1 or"),
            std::string::npos);
}

TEST(RainPackets, ATreesLeavesCoverTheBoxOnceAndHoldNoMoreThanTold) {
  const Scene scene = scene_for(views[0]);
  const RainSpace space = make_rain_space(scene);
  const RainPackets packets = make_rain_packets(scene.rain, space, {PacketScheme::tree, {}, 700});
  CellNames cells;
  for (const RainPacket& leaf : packets.stored) {
    const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(leaf.size)];
    const double per_cell = size.drops.drops_per_m3 * 6 * size.cell_m * size.cell_m;
    const int count = (leaf.cells.x1 - leaf.cells.x0) * (leaf.cells.y1 - leaf.cells.y0);
    EXPECT_LE(count * per_cell, 700);
    for (int y = leaf.cells.y0; y < leaf.cells.y1; ++y) {
      for (int x = leaf.cells.x0; x < leaf.cells.x1; ++x)
        ASSERT_TRUE(cells.emplace(leaf.size, x, y).second);
    }
  }
  for (const Drop& drop : drop_field(scene, space, 1, 0))
    ASSERT_TRUE(cells.count({drop.name.size, drop.name.cell_x, drop.name.cell_y}));
}

}  // namespace
}  // namespace pluvia
