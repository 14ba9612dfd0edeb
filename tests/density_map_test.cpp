#include "raytrace/density_map.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/rain_packets.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

// A binary PGM or PPM: stb_image reads both, and every byte is in sight.
std::string picture(const std::string& kind, int width, int height, const std::string& bytes) {
  return fmt::format("{}\n{} {}\n255\n{}", kind, width, height, bytes);
}

DensityMap read(const std::string& bytes) {
  return read_density_map(scratch_file("density.pgm", bytes), {-2, -1}, {4, 3}, 10);
}

TEST(DensityMap, WhiteIsAllOfTheRainAndTheFirstRowLiesNorth) {
  const DensityMap map = read(picture("P5", 3, 2, std::string("\xff\x00\x33\x00\x80\xff", 6)));
  ASSERT_EQ(map.width, 3);
  ASSERT_EQ(map.height, 2);
  const auto at = [&](double x, double y) {
    return density_of_texel(map, density_texel(map, {x, y}));
  };
  EXPECT_EQ(at(-1.9, 2.9), 1);
  EXPECT_EQ(at(-0.1, 1.1), 1);
  EXPECT_EQ(at(0.1, 2), 0);
  EXPECT_NEAR(at(3, 2), 0.2, 1e-7);
  EXPECT_NEAR(at(1, 0), 128 / 255.0, 1e-7);
  EXPECT_EQ(at(3.9, -0.9), 1);
  for (const auto& [x, y] : {std::pair(-2.1, 0.0), {4.1, 0.0}, {0.0, 3.1}, {0.0, -1.1}})
    EXPECT_EQ(at(x, y), 0) << x << ", " << y;
  EXPECT_NEAR(density_sum(map, {0, 0}, {3, 2}), 2.2 + 128 / 255.0, 1e-6);
  EXPECT_EQ(density_sum(map, {1.1, 0.1}, {1.9, 0.9}), 0);
  EXPECT_NEAR(density_sum(map, {1.1, 0.1}, {2.1, 0.9}), 0.2, 1e-7);
  EXPECT_EQ(density_sum(map, {-9, -9}, {-1, 9}), 0);
}

TEST(DensityMap, ColouredBrokenAndMissingPicturesAreRefused) {
  const std::string coloured = picture("P6", 2, 1, std::string("\x10\x10\x10\x10\x11\x10", 6));
  EXPECT_NE(message_of([&] { read(coloured); }).find("density.pgm: pixel (1, 0) is coloured"),
            std::string::npos);
  EXPECT_NE(message_of([&] { read("no picture"); }).find("is no picture that can be read"),
            std::string::npos);
  EXPECT_NE(message_of([&] { read(""); }).find("is no picture"), std::string::npos);
  EXPECT_NE(message_of([&] {
              read_density_map("/none.png", {0, 0}, {1, 1}, 0);
            }).find("/none.png: cannot be read"),
            std::string::npos);
}

DensityMap map_of(int width, int height, const std::vector<float>& share) {
  DensityMap map = {.width = width,
                    .height = height,
                    .share = share,
                    .min_m = {-10, -5},
                    .max_m = {10, 15},
                    .height_m = 12};
  sum_density(map);
  return map;
}

Scene rain_under(const DensityMap& map, const Eigen::Vector3d& velocity_m_s) {
  Scene scene;
  scene.camera.position_m = {0, 5, 6};
  scene.camera.target_m = {0.3, 15, 6};
  scene.rain.sizes = {{.drops_per_m3 = 10, .velocity_m_s = velocity_m_s}};
  scene.rain.box_min_m = {-10, -5, 0};
  scene.rain.box_max_m = {10, 15, 12};
  scene.rain.culling_radius_m = 40;
  scene.rain.local_height_m = 12;
  scene.rain.density = map;
  return scene;
}

TEST(DensityMap, DropsFallWhereItIsWhiteAndInItsShare) {
  // 4 x 4 texels of 5 m: counted where each drop fell through the plane at 12 m.
  std::mt19937 random(5);
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<float> shares(16);
  for (float& s : shares) s = share(random);
  shares[5] = 0;
  shares[6] = 1;
  const DensityMap map = map_of(4, 4, shares);
  for (const Eigen::Vector3d& velocity :
       {Eigen::Vector3d(0, 0, -8.49), Eigen::Vector3d(4, -3, -8)}) {
    const Scene scene = rain_under(map, velocity);
    std::vector<double> full(16), found(16);
    const auto count = [&](const Scene& s, std::vector<double>& counts) {
      for (const Drop& drop : drop_field(s, make_rain_space(s), 1, 3)) {
        const double back_s = (12 - drop.centre_m.z()) / velocity.z();
        const Eigen::Vector3d through = drop.centre_m + back_s * velocity;
        const Eigen::Vector2d at = density_texel(map, through.head<2>()).array().floor();
        if (at.x() < 0 || at.x() > 3 || at.y() < 0 || at.y() > 3) continue;
        ++counts[static_cast<std::size_t>(4 * at.y() + at.x())];
      }
    };
    Scene whole = scene;
    whole.rain.density = {};
    count(whole, full);
    count(scene, found);
    for (std::size_t i = 0; i < 16; ++i) {
      // Of the drops that are there without a map each stays with the texel's chance. 4.5 standard
      // deviations: false alarm 7e-6 a texel, 2e-4 over all 32 comparisons.
      const double p = static_cast<double>(shares[i]), n = full[i];
      EXPECT_NEAR(found[i], p * n, 4.5 * std::sqrt(n * p * (1 - p)) + 1e-9) << i;
    }
    EXPECT_EQ(found[5], 0);
    EXPECT_EQ(found[6], full[6]);
  }
}

TEST(DensityMap, AllBlackOnePixelAndOneTexelAreWhatTheySay) {
  const Eigen::Vector3d down(0, 0, -8.49);
  const auto drops = [&](const DensityMap& map) {
    const Scene scene = rain_under(map, down);
    return drop_field(scene, make_rain_space(scene), 1, 0).size();
  };
  const auto all = static_cast<double>(drops({}));
  EXPECT_EQ(drops(map_of(8, 8, std::vector<float>(64, 0))), 0u);
  EXPECT_EQ(static_cast<double>(drops(map_of(1, 1, {1}))), all);
  // 4 standard deviations: false alarm 1.3e-4 for both.
  EXPECT_NEAR(static_cast<double>(drops(map_of(1, 1, {0.5}))), all / 2, 4 * std::sqrt(all / 4));
  std::vector<float> one(64, 0);
  one[27] = 1;
  EXPECT_NEAR(static_cast<double>(drops(map_of(8, 8, one))), all / 64, 4 * std::sqrt(all / 64));
}

TEST(DensityMap, PacketsLookNowhereThatIsBlack) {
  const Eigen::Vector3d slanted(4, -3, -8);
  std::vector<float> shares(400, 0);
  for (std::size_t i : {105u, 210u, 211u}) shares[i] = 1;
  const Scene black = rain_under(map_of(20, 20, std::vector<float>(400, 0)), slanted);
  const Scene spots = rain_under(map_of(20, 20, shares), slanted);
  for (const auto scheme : {PacketScheme::world, PacketScheme::tree, PacketScheme::grid}) {
    for (const Scene* scene : {&black, &spots}) {
      const RainSpace space = make_rain_space(*scene);
      const RainPackets packets =
          make_rain_packets(scene->rain, space, {scheme, PacketSelection::hull, 50});
      const PacketChoice choice = select_packets(scene->rain, space, packets, scene->camera, 0);
      std::size_t held = 0;
      const auto cells = packet_cells(scene->rain, space, choice, scene->camera, 0);
      for (const SizedCell& cell : cells) held += cell.cell.count;
      const auto wanted = drop_field(*scene, space, 1, 0).size();
      EXPECT_GE(held, wanted > 0 ? 1u : 0u);
      if (scene == &black)
        EXPECT_EQ(cells.size(), 0u) << packet_scheme_name(scheme);
      else
        EXPECT_LT(held, 2000u) << packet_scheme_name(scheme) << ": three texels hold 120 drops";
    }
  }
}

TEST(DensityMap, ATreeOfHalvesOrQuartersHoldsTheDropsEitherWay) {
  std::vector<float> shares(400, 0.02f);
  for (std::size_t i = 0; i < 40; ++i) shares[i] = 1;
  const Scene scene = rain_under(map_of(20, 20, shares), {0, 0, -8.49});
  const RainSpace space = make_rain_space(scene);
  const RainPackets packets = make_rain_packets(scene.rain, space, {PacketScheme::tree, {}, 600});
  double drops = 0;
  for (const RainPacket& leaf : packets.stored)
    drops += rain_area_m2(scene.rain, space.sizes[0], leaf.cells) * 10 * 12;
  const double all = 10 * 12 * (40 + 360 * 0.02);
  EXPECT_GE(drops, all);
  EXPECT_LE(static_cast<double>(packets.stored.size()), 4 * all / 600 + 4);
}

}  // namespace
}  // namespace pluvia
