// [wind] of a scene file (raytrace/wind_reader.h).
#include <gtest/gtest.h>

#include "raytrace/scene.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

const std::string camera = "[camera]\nposition_m = [0, 0, 1]\ntarget_m = [0, 1, 1]\n";
const std::string rain =
    "[rain]\ndrops_per_m3 = 10\nbox_min_m = [0, 0, 0]\nbox_max_m = [9, 9, 9]\n";

Scene read(const std::string& wind, const std::string& head = camera + rain) {
  return read_scene(scratch_file("wind.toml", head + wind));
}

// What is refused, after the file's name.
std::string refusal(const std::string& wind, const std::string& head = camera + rain) {
  const std::string message = message_of([&] { read(wind, head); });
  const std::size_t at = message.find("wind.toml:");
  return at == std::string::npos ? message : message.substr(at + 10);
}

TEST(WindReader, ReadsEveryKindWithItsKeys) {
  const Scene scene = read(
      "[wind]\nvelocity_m_s = [1, 0, 0]\nrestitution = 0.3\n"
      "[[wind.primitive]]\nkind = \"uniform\"\naxis = [0, 2, 0]\nspeed_m_s = 4\n"
      "[[wind.primitive]]\nkind = \"sink\"\nposition_m = [1, 2, 3]\nstrength_m2_s = 5\n"
      "[[wind.primitive]]\nkind = \"tornado\"\nposition_m = [4, 4, 0]\nstrength_m2_s = 30\n"
      "core_radius_m = 0.5\ninflow = 0.25\nheight_m = 7\n"
      "[[wind.primitive]]\nkind = \"vortex\"\n"
      "[[wind.primitive.key]]\ntime_s = 0\nposition_m = [0, 0, 0]\nstrength_m2_s = 3\n"
      "[[wind.primitive.key]]\ntime_s = 2\nposition_m = [1, 0, 0]\nstrength_m2_s = 6\n"
      "axis = [1, 0, 0]\n");
  const Rain& found = scene.rain;
  EXPECT_EQ(found.wind_m_s, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(found.sizes[0].velocity_m_s.x(), 1);
  EXPECT_EQ(found.restitution, 0.3);
  ASSERT_EQ(found.wind.size(), 4u);
  EXPECT_EQ(found.wind[0].strength * found.wind[0].axis, Eigen::Vector3d(0, 4, 0));
  EXPECT_EQ(found.wind[1].kind, WindKind::source);
  EXPECT_EQ(found.wind[1].strength, -5);
  EXPECT_EQ(found.wind[1].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(found.wind[2].core_radius_m, 0.5);
  EXPECT_EQ(found.wind[2].inflow, 0.25);
  EXPECT_EQ(found.wind[2].height_m, 7);
  ASSERT_EQ(found.wind[3].path.size(), 2u);
  EXPECT_EQ(found.wind[3].path[1].axis, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(found.wind[3].strength, 3);
}

TEST(WindReader, SteadyUniformPrimitivesAreTheEvenWind) {
  const Scene scene = read(
      "[wind]\nvelocity_m_s = [1, 0, 0]\n"
      "[[wind.primitive]]\nkind = \"uniform\"\naxis = [0, 2, 0]\nspeed_m_s = 4\n");
  EXPECT_TRUE(scene.rain.wind.empty());
  EXPECT_EQ(scene.rain.wind_m_s, Eigen::Vector3d(1, 4, 0));
  EXPECT_EQ(scene.rain.sizes[0].velocity_m_s.y(), 4);
}

TEST(WindReader, RefusesWithThePlaceInTheFile) {
  const std::string vortex = "[wind]\n[[wind.primitive]]\nkind = \"vortex\"\n";
  EXPECT_EQ(refusal("[wind]\n[[wind.primitive]]\nkind = \"storm\"\n"),
            "10:1: wind.primitive[0].kind = \"storm\"; expected \"uniform\", \"source\", \"sink\", "
            "\"vortex\" or \"tornado\"");
  EXPECT_EQ(refusal(vortex + "position_m = [0, 0, 0]\nstrength_m2_s = 3\naxis = [0, 0, 0]\n"),
            "13:1: wind.primitive[0].axis is zero; expected the way it points");
  EXPECT_EQ(refusal(vortex + "position_m = [0, 0, 0]\nstrength_m2_s = 3000\n"),
            "12:1: wind.primitive[0]: a wind of up to 304.7 m/s; expected at most 100 m/s");
  EXPECT_EQ(refusal(vortex + "[[wind.primitive.key]]\ntime_s = 0\nposition_m = [0, 0, 0]\n"
                             "strength_m2_s = 3\n"),
            "11:18: wind.primitive[0] has 1 key; expected 2 or more, or a place and a strength");
  const std::string first =
      "[[wind.primitive.key]]\ntime_s = 1\nposition_m = [0, 0, 0]\nstrength_m2_s = 3\n";
  EXPECT_EQ(refusal(vortex + first + first),
            "16:1: wind.primitive[0].key[1].time_s = 1; expected 0.001 s or more after the one "
            "before");
  EXPECT_EQ(
      refusal(vortex + first +
              "[[wind.primitive.key]]\ntime_s = 2\nposition_m = [0, 0, 0]\n"
              "strength_m2_s = 3\naxis = [0, 0, -1]\n"),
      "19:1: wind.primitive[0].key[1].axis turns by more than 170 degrees; expected less from "
      "key to key");
  EXPECT_NE(refusal("[wind]\n").find("velocity_m_s"), std::string::npos);
  EXPECT_NE(refusal("[wind]\nvelocity_m_s = [1, 0, 0]\nrestitution = 0.5\n").find("unknown key"),
            std::string::npos);
  EXPECT_EQ(refusal(vortex + "position_m = [0, 0, 0]\nstrength_m2_s = 3\n",
                    camera + "[rain]\ndrops_per_m3 = 10\n"),
            "4:1: rain without a box in the wind of primitives; expected box_min_m and box_max_m");
  const std::string steady = vortex + "position_m = [0, 0, 0]\nstrength_m2_s = 3\n";
  EXPECT_NE(refusal(steady, camera + rain + "density_map = \"a.png\"\n")
                .find("rain.density_map in the wind of primitives"),
            std::string::npos);
  EXPECT_NE(refusal(steady, camera + rain + "lost_share = 0.1\n")
                .find("rain.lost_share in the wind of primitives"),
            std::string::npos);
}

}  // namespace
}  // namespace pluvia
