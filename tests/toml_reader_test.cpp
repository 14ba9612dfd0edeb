#include "raytrace/toml_reader.h"

#include <cmath>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

constexpr Range exposure = {0, 1, true};

// Reads [camera] exposure_s (required), width_px and flip of a text; "" or the refusal without the
// folder.
std::string refusal_of(const std::string& text) {
  const std::string file = scratch_file("street.toml", text);
  const std::string message = message_of([&] {
    const toml::table table = read_toml(file);
    TomlReader root(table, file, "");
    TomlReader camera = root.table("camera");
    double exposure_s = 0;
    int width_px = 0;
    bool flip = false;
    std::string name;
    unsigned long long seed = 0;
    Eigen::Vector3d position_m = {0, 0, 0};
    std::vector<int> views;
    camera.required("exposure_s", exposure_s, exposure, "s");
    camera.optional("width_px", width_px, 1, 16384);
    camera.optional("flip", flip);
    camera.optional("name", name);
    camera.optional("seed", seed);
    camera.optional("position_m", position_m, {-10, 10});
    camera.optional("views_deg", views, -90, 90);
    camera.finish();
    root.finish();
  });
  const std::size_t folder = message.rfind("street.toml");
  return folder == std::string::npos ? message : message.substr(folder);
}

TEST(TomlReader, ReadsEveryKindOfValueAndAnIntegerAsARealNumber) {
  const std::string file = scratch_file("all.toml",
                                        "[camera]\nexposure_s = 1\nwidth_px = 640\nflip = true\n"
                                        "name = \"a\"\nseed = 9223372036854775807\n"
                                        "position_m = [1, -2.5, 3e0]\nviews_deg = [-20, 0, 20]\n");
  const toml::table table = read_toml(file);
  TomlReader root(table, file, "");
  TomlReader camera = root.table("camera");
  double exposure_s = 0;
  int width_px = 0;
  bool flip = false;
  std::string name;
  unsigned long long seed = 0;
  Eigen::Vector3d position_m = {0, 0, 0};
  std::vector<int> views;
  camera.required("exposure_s", exposure_s, exposure);
  camera.required("width_px", width_px, 1, 16384);
  camera.optional("flip", flip);
  camera.required("name", name);
  camera.optional("seed", seed);
  camera.required("position_m", position_m);
  camera.optional("views_deg", views, -90, 90);
  EXPECT_NO_THROW(camera.finish());
  EXPECT_EQ(exposure_s, 1);
  EXPECT_EQ(width_px, 640);
  EXPECT_TRUE(flip);
  EXPECT_EQ(name, "a");
  EXPECT_EQ(seed, 9223372036854775807ULL);
  EXPECT_EQ(position_m, Eigen::Vector3d(1, -2.5, 3));
  EXPECT_EQ(views, (std::vector<int>{-20, 0, 20}));
}

TEST(TomlReader, AnAbsentOptionalKeyLeavesItsValueAlone) {
  const toml::table table;
  TomlReader reader(table, "empty.toml", "");
  double value = 7;
  std::vector<int> list = {1, 2};
  reader.optional("value", value, {0, 1});
  reader.optional("list", list, 0, 1);
  EXPECT_EQ(value, 7);
  EXPECT_EQ(list.size(), 2u);
  EXPECT_TRUE(reader.tables("light").empty());
  EXPECT_FALSE(reader.has("value"));
}

TEST(TomlReader, ARefusalTellsPlaceValueAndRange) {
  EXPECT_EQ(refusal_of("# a comment\n\n[camera]\n    exposure_s = -1\n"),
            "street.toml:4:5: camera.exposure_s = -1; expected 0 < exposure_s <= 1 s");
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = 0\n"),
            "street.toml:2:1: camera.exposure_s = 0; expected 0 < exposure_s <= 1 s");
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = 0.01\nwidth_px = 0\n"),
            "street.toml:3:1: camera.width_px = 0; expected an integer, 1 <= width_px <= 16384");
}

TEST(TomlReader, ValuesThatTomlCanSayButNoNumberIsAreRefused) {
  for (const char* value : {"nan", "+inf", "-inf", "\"1\"", "true", "[1]", "{ a = 1 }",
                            "1979-05-27T07:32:00Z", "1.0000001"})
    EXPECT_NE(refusal_of(fmt::format("[camera]\nexposure_s = {}\n", value))
                  .find("street.toml:2:1: camera.exposure_s = "),
              std::string::npos)
        << value;
}

TEST(TomlReader, ANumberWithoutBoundsIsStillFinite) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    const std::string file = scratch_file("free.toml", fmt::format("a = {}\n", value));
    const toml::table table = read_toml(file);
    TomlReader reader(table, file, "");
    double a = 0;
    const Range anything = {-HUGE_VAL, HUGE_VAL};
    EXPECT_EQ(message_of([&] { reader.required("a", a, anything); }),
              fmt::format("{}:1:1: a = {}; expected a finite number", file, value));
  }
}

TEST(TomlReader, ARealNumberIsNoIntegerAndALongOneDoesNotWrapAround) {
  EXPECT_EQ(
      refusal_of("[camera]\nexposure_s = 0.01\nwidth_px = 640.5\n"),
      "street.toml:3:1: camera.width_px = 640.5; expected an integer, 1 <= width_px <= 16384");
  // 2^32 + 640 would be 640 in 32 bits.
  EXPECT_NE(refusal_of("[camera]\nexposure_s = 0.01\nwidth_px = 4294967936\n"), "");
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = 0.01\nseed = -1\n"),
            "street.toml:3:1: camera.seed = -1; expected an integer, seed >= 0");
}

TEST(TomlReader, AMisspeltKeyIsToldItsNeighbour) {
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = 0.01\nwidht_px = 3\n"),
            "street.toml:3:1: unknown key \"widht_px\" in [camera]; did you mean \"width_px\"?");
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = 0.01\n[camrea]\n"),
            "street.toml:3:2: unknown key \"camrea\"; did you mean \"camera\"?");
  EXPECT_EQ(refusal_of("fog = 1\n[camera]\nexposure_s = 0.01\n"),
            "street.toml:1:1: unknown key \"fog\"; expected one of camera");
}

TEST(TomlReader, AForgottenOrDoubledLetterIsAMisspellingToo) {
  for (const char* key : {"exposre_s", "exposuure_s"})
    EXPECT_NE(refusal_of(fmt::format("[camera]\nexposure_s = 1\n{} = 1\n", key))
                  .find("did you mean \"exposure_s\"?"),
              std::string::npos)
        << key;
}

TEST(TomlReader, TheFirstUnknownKeyInTheFileIsTheOneRefused) {
  for (const char* pair : {"zzz = 1\naaa = 2\n", "aaa = 1\nzzz = 2\n"})
    EXPECT_EQ(refusal_of(fmt::format("[camera]\nexposure_s = 0.01\n{}", pair)).substr(0, 34),
              fmt::format("street.toml:3:1: unknown key \"{}\"", std::string(pair, 3)));
}

TEST(TomlReader, AMissingKeyIsToldAtItsTable) {
  EXPECT_EQ(refusal_of("\n[camera]\nwidth_px = 640\n"),
            "street.toml:2:1: camera.exposure_s is missing; expected 0 < exposure_s <= 1 s");
  EXPECT_EQ(refusal_of("[lens]\n"),
            "street.toml:1:1: camera is missing; expected a table [camera]");
}

TEST(TomlReader, AVectorHasThreeFiniteNumbersInRange) {
  const std::string head = "[camera]\nexposure_s = 0.01\nposition_m = ";
  EXPECT_EQ(refusal_of(head + "[1, 2]\n"),
            "street.toml:3:1: camera.position_m = an array of 2 values; expected an array of 3 "
            "numbers");
  EXPECT_EQ(refusal_of(head + "[1, nan, 2]\n"),
            "street.toml:3:1: camera.position_m[1] = nan; expected -10 <= position_m[1] <= 10");
  EXPECT_EQ(refusal_of(head + "[1, 2, 11]\n"),
            "street.toml:3:1: camera.position_m[2] = 11; expected -10 <= position_m[2] <= 10");
  EXPECT_EQ(
      refusal_of("[camera]\nexposure_s = 0.01\nviews_deg = [0, 95]\n"),
      "street.toml:3:1: camera.views_deg[1] = 95; expected an integer, -90 <= views_deg[1] <= "
      "90");
}

TEST(TomlReader, ASyntaxErrorAndAKeyGivenTwiceCarryTheirPlace) {
  EXPECT_EQ(refusal_of("[camera]\nexposure_s = \n").find("street.toml:2:"), 0u);
  const std::string twice = refusal_of("[camera]\nexposure_s = 1\nexposure_s = 2\n");
  EXPECT_EQ(twice.find("street.toml:3:"), 0u) << twice;
  EXPECT_NE(twice.find("exposure_s"), std::string::npos) << twice;
  for (const std::string& message : {twice, refusal_of("[camera]\nname = \"\\q\"\n"),
                                     refusal_of("\xff\xfe"), refusal_of("a = [[[\n")}) {
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find("; expected "), std::string::npos) << message;
  }
}

TEST(TomlReader, AFileThatIsNotThereOrIsAFolderIsTold) {
  EXPECT_EQ(
      message_of([] { read_toml("/nowhere/a.toml"); }),
      "/nowhere/a.toml: cannot read: No such file or directory; expected a readable TOML file");
  EXPECT_EQ(message_of([] { read_toml("/"); }),
            "/: cannot read: is a directory; expected a readable TOML file");
}

TEST(TomlReader, TablesOfAnArrayAreNumbered) {
  const std::string file = scratch_file("lights.toml", "[[light]]\na = 1\n\n[[light]]\na = 2\n");
  const toml::table table = read_toml(file);
  TomlReader root(table, file, "");
  std::vector<TomlReader> lights = root.tables("light");
  ASSERT_EQ(lights.size(), 2u);
  int a = 0;
  EXPECT_EQ(message_of([&] { lights[1].required("a", a, 0, 1); }),
            file + ":5:1: light[1].a = 2; expected an integer, 0 <= a <= 1");
}

TEST(TomlReader, APathIsRelativeToTheFileThatNamesIt) {
  EXPECT_EQ(path_beside("scenes/a.toml", "b.gltf"), "scenes/b.gltf");
  EXPECT_EQ(path_beside("a.toml", "b.gltf"), "b.gltf");
  EXPECT_EQ(path_beside("scenes/a.toml", "/b.gltf"), "/b.gltf");
}

}  // namespace
}  // namespace pluvia
