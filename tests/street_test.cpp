// The scenes that the repository ships.
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "raytrace/drop_field.h"
#include "raytrace/scene.h"
#include "raytrace/streak_placement.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

const std::string scenes = PLUVIA_SOURCE_DIR "/data/scenes/";

std::string bytes_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Street, ItsProgramWritesTheCommittedFile) {
  const std::string file = scratch_file("street.gltf", "");
  ASSERT_EQ(std::system(fmt::format("'{}' '{}'", PLUVIA_MAKE_STREET, file).c_str()), 0);
  EXPECT_TRUE(bytes_of(file) == bytes_of(scenes + "street.gltf"))
      << "run make_street data/scenes/street.gltf and look at what changed";
}

TEST(Street, EveryLampHangsJustBelowALightPanelOfItsOwn) {
  const Scene scene = read_scene(scenes + "street.toml");
  EXPECT_GT(scene.mesh.indices.size() / 3, 5000u);
  ASSERT_EQ(scene.lights.size(), 6u);
  for (const Light& light : scene.lights) {
    int panels = 0;
    for (std::size_t t = 0; t < scene.mesh.triangle_material.size(); ++t) {
      const std::uint32_t* corner = &scene.mesh.indices[3 * t];
      if (scene.mesh.normals[corner[0]].z() > -0.99f) continue;
      Eigen::Vector3d centre = {0, 0, 0};
      for (int i = 0; i < 3; ++i) centre += scene.mesh.positions_m[corner[i]].cast<double>() / 3;
      const Eigen::Vector3d up = centre - light.position_m;
      const double emission =
          scene.mesh.materials[scene.mesh.triangle_material[t]].emission_cd_m2.sum();
      panels += emission > 0 && up.z() > 0.04 && up.z() < 0.06 && up.norm() < 0.2;
    }
    EXPECT_EQ(panels, 2) << light.name;  // the two triangles of one rectangle
  }
}

TEST(Street, SurfacesReflectBetweenFiveHundredthsAndAHalf) {
  const Scene scene = read_scene(scenes + "street.toml");
  for (std::uint32_t m : scene.mesh.triangle_material) {
    const Eigen::Vector3d& albedo = scene.mesh.materials[m].base_color;
    ASSERT_TRUE(albedo.minCoeff() >= 0.05 && albedo.maxCoeff() <= 0.5) << m;
  }
}

TEST(Street, TheCloseSceneShowsWideStreaks) {
  const Scene scene = read_scene(scenes + "close.toml");
  const StreakGeometry geometry = {.pixel_m = 2.85e-4,
                                   .cell_width_px = 16,
                                   .exposure_s = scene.camera.exposure_s,
                                   .path_top_row = 15};
  long seen = 0, wide = 0;
  for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 0)) {
    const auto placed = place_streak(scene, drop, geometry);
    if (!placed) continue;
    const Eigen::Vector2d middle =
        placed->origin_px + 8 * placed->column_px + (15 + placed->path_rows / 2) * placed->row_px;
    if (middle.x() < 0 || middle.x() > 1280 || middle.y() < 0 || middle.y() > 720) continue;
    ++seen;
    // A drop of 3.2 mm is 11.2 of the database's pixels wide.
    wide += 11.2 * placed->column_px.norm() > 10;
  }
  // 0.59 m^3 of the box are in view: 29 +- 5.4 streaks, bounds at 3 sigma: false alarm 0.25 %.
  EXPECT_GE(seen, 13);
  EXPECT_LE(seen, 45);
  EXPECT_GE(wide, 1);
}

TEST(Block, ItsProgramWritesTheCommittedFile) {
  const std::string file = scratch_file("block.gltf", "");
  ASSERT_EQ(std::system(fmt::format("'{}' '{}'", PLUVIA_MAKE_BLOCK, file).c_str()), 0);
  EXPECT_TRUE(bytes_of(file) == bytes_of(scenes + "block.gltf"))
      << "run make_block data/scenes/block.gltf and look at what changed";
}

TEST(Car, ItsProgramWritesTheCommittedFile) {
  const std::string file = scratch_file("car.gltf", "");
  ASSERT_EQ(std::system(fmt::format("'{}' '{}'", PLUVIA_MAKE_CAR, file).c_str()), 0);
  EXPECT_TRUE(bytes_of(file) == bytes_of(scenes + "car.gltf"))
      << "run make_car data/scenes/car.gltf and look at what changed";
}

// Whether a surface lies above a point, by looking at every triangle.
bool is_covered(const Mesh& mesh, const Eigen::Vector3d& p) {
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    Eigen::Vector3d c[3];
    for (std::size_t i = 0; i < 3; ++i)
      c[i] = mesh.positions_m[mesh.indices[t + i]].cast<double>() - p;
    const auto cross = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return a.x() * b.y() - a.y() * b.x();
    };
    const double w[3] = {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
    const bool inside = (w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0);
    if (!inside) continue;
    const double z = (w[0] * c[0].z() + w[1] * c[1].z() + w[2] * c[2].z()) / (w[0] + w[1] + w[2]);
    if (z > 1e-6) return true;
  }
  return false;
}

TEST(Block, NoDropIsEverSeenUnderARoof) {
  Scene scene = read_scene(scenes + "passages.toml");
  const RainSpace space = make_rain_space(scene);
  for (const double time_s : {0.0, 2.5, 3.5, 6.0}) {
    scene.camera = camera_at(scene, time_s);
    long covered = 0, open = 0, lost = 0;
    for (const Drop& drop : drop_field(scene, space, 10, time_s)) {
      // Near the passage, where it could be seen; others would only take time.
      if (std::abs(drop.centre_m.x()) > 4 || drop.centre_m.y() < 3 || drop.centre_m.z() > 4)
        continue;
      const bool hidden = is_covered(scene.mesh, drop.centre_m);
      const bool drawn = drop.hit_time_s > 0;
      EXPECT_FALSE(hidden && drawn) << drop.centre_m.transpose() << " at " << time_s << " s";
      covered += hidden;
      open += !hidden;
      lost += !hidden && !drawn;
    }
    EXPECT_GT(covered, 200) << time_s;
    EXPECT_GT(open, 100) << time_s;
    // A rim of 5 cm along the walls, ledges and pipes.
    EXPECT_LT(static_cast<double>(lost), 0.2 * static_cast<double>(open)) << time_s;
  }
}

TEST(Scenes, EveryShippedSceneIsReadAndHasItsRain) {
  for (const char* name :
       {"street", "courtyard", "sun_shower", "passages", "storm", "close", "splash", "car"}) {
    const Scene scene = read_scene(scenes + name + ".toml");
    const RainSpace space = make_rain_space(scene);
    EXPECT_GT(space.expected_drops, 60) << name;
    EXPECT_LE(space.lost_share, scene.rain.lost_share) << name;
  }
  EXPECT_EQ(read_scene(scenes + "one_drop.toml").drops.size(), 1u);
}

}  // namespace
}  // namespace pluvia
