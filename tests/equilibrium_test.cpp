#include "oscillation/equilibrium.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "oscillation/drop_shape.h"
#include "tests/table_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

std::string table_file() {
  return std::string(PLUVIA_SOURCE_DIR) + "/data/tables/chuang_beard_1990_cn.csv";
}

DropInstant resting_drop(double diameter_m) {
  DropShape shape;
  shape.mean_radius_m = diameter_m / 2;
  shape.equilibrium_cos = equilibrium_cos(read_equilibrium_table(table_file()), diameter_m);
  return drop_at(shape, 0);
}

TEST(Equilibrium, EveryRowEnclosesTheVolumeOfItsSphere) {
  // Chuang and Beard's four digits keep the volume to 4e-4; the uncorrected 8 mm row is 2.5e-3 off.
  const auto table = read_equilibrium_table(table_file());
  ASSERT_EQ(table.diameter_m.size(), 15u);
  for (const double d : table.diameter_m) {
    EXPECT_NEAR(volume_m3(resting_drop(d)) / (pi / 6 * d * d * d), 1, 1e-3) << d;
  }
  EXPECT_NEAR(volume_m3(resting_drop(8e-3)) / (pi / 6 * 512e-9), 1.0001, 1e-4);
}

TEST(Equilibrium, DropsAreFlatBelow) {
  // The table's own columns: distance to the bottom and to the top over d / 2, five digits.
  for (const auto& row : table_rows("chuang_beard_1990_cn.csv")) {
    const double d = std::stod(row[0]) * 1e-3;
    const DropInstant drop = resting_drop(d);
    const double top = surface_radius_m(drop, 0, 0), bottom = surface_radius_m(drop, pi, 0);
    EXPECT_LT(bottom, top) << d;
    if (row[0] == "8") continue;  // its columns belong to the uncorrected c_0
    EXPECT_NEAR(bottom / (d / 2), std::stod(row[16]), 2e-4) << d;
    EXPECT_NEAR(top / (d / 2), std::stod(row[17]), 2e-4) << d;
  }
}

TEST(Equilibrium, TheCentreOfGravityLiesAboveTheOriginByTheTablesShare) {
  for (const auto& row : table_rows("chuang_beard_1990_cn.csv")) {
    const double d = std::stod(row[0]) * 1e-3;
    const double above = centroid_m(resting_drop(d)).z() / (d / 2);
    EXPECT_NEAR(above, -std::stod(row[13]), row[0] == "8" ? 1e-3 : 2e-5) << d;
  }
}

TEST(Equilibrium, CoefficientsAreLinearBetweenRowsAndExactOnThem) {
  const auto table = read_equilibrium_table(table_file());
  for (std::size_t i = 1; i < table.diameter_m.size(); ++i) {
    const double a = table.diameter_m[i - 1], b = table.diameter_m[i];
    const auto here = equilibrium_cos(table, b),
               between = equilibrium_cos(table, 0.25 * a + 0.75 * b);
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double below = table.cos_terms[i - 1][k], above = table.cos_terms[i][k];
      EXPECT_DOUBLE_EQ(here[k], above) << b << " c_" << k;
      EXPECT_NEAR(between[k], 0.25 * below + 0.75 * above, 1e-16) << b << " c_" << k;
    }
  }
}

TEST(Equilibrium, SmallDropsTendToSpheresWithTheSquareOfTheirSize) {
  const auto table = read_equilibrium_table(table_file());
  const auto one = equilibrium_cos(table, 1e-3), tenth = equilibrium_cos(table, 1e-4);
  EXPECT_DOUBLE_EQ(one[2], -83e-4);
  EXPECT_NEAR(tenth[2], -83e-6, 1e-18);
  EXPECT_NEAR(equilibrium_cos(table, 1e-3 * (1 + 1e-9))[2], one[2], 1e-9);
}

TEST(Equilibrium, RefusesDiametersOutsideTheTable) {
  const auto table = read_equilibrium_table(table_file());
  for (const double d : {0.0, -1e-3, 9.001e-3, std::nan("")}) {
    EXPECT_THROW(equilibrium_cos(table, d), std::invalid_argument) << d;
  }
  EXPECT_NO_THROW(equilibrium_cos(table, 9e-3));
}

// The message with which a file of this text is refused; empty when it is read.
std::string refusal(const std::string& text) {
  const TemporaryFolder folder;
  const std::string file = folder / "shapes.csv";
  std::ofstream(file) << text;
  try {
    read_equilibrium_table(file);
  } catch (const std::runtime_error& e) {
    return std::string(e.what()).substr(file.size());
  }
  return "";
}

TEST(Equilibrium, RefusesBrokenTablesWithFileAndLine) {
  const std::string good = "d_mm,c\n1,0,0,0,0,0,0,0,0,0,0,0\n2,0,0,0,0,0,0,0,0,0,0,0\n";
  EXPECT_EQ(refusal(good), "");
  EXPECT_EQ(refusal("d_mm,c\n1,0,0\n"), ":2: 3 columns; expected at least 12: d_mm, c0 .. c10");
  EXPECT_EQ(refusal("# head\nd_mm\n1,x,0\n"),
            ":3: \"x,0\"; expected finite numbers between commas");
  EXPECT_EQ(refusal(good + "2,0,0,0,0,0,0,0,0,0,0,0\n"),
            ":4: d = 2 mm; expected ascending diameters");
  EXPECT_EQ(refusal(good + "3,nan,0,0,0,0,0,0,0,0,0,0\n"),
            ":4: \"nan,0,0,0,0,0,0,0,0,\"; expected finite numbers between commas");
  EXPECT_EQ(refusal("-1,0,0,0,0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0,0,0,0,0\n"),
            ":1: d = -1 mm; expected d > 0");
  EXPECT_EQ(refusal("1,0,0,0,0,0,0,0,0,0,0,0\n"),
            ": fewer than two rows; expected a table of c_0 .. c_10");
  EXPECT_THROW(read_equilibrium_table("/nowhere/shapes.csv"), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
