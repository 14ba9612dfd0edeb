#include "oscillation/water.h"

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/table_file.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

TEST(Water, IndexAgreesWithThePublishedCheckValues) {
  // Published with nine figures: half a unit of the last is 5e-9.
  EXPECT_NEAR(water_index(997.047435, 25, 226.5), 1.39277824, 5e-9);
  EXPECT_NEAR(water_index(30.4758534, 500, 589.3), 1.00949307, 5e-9);
  EXPECT_NEAR(water_index(997.047435, 25, 589.3), 1.33285819, 5e-9);
}

TEST(Water, IndexOfTheTableFollowsFromTemperatureAndWavelength) {
  const double temperatures_c[] = {0, 10, 20, 25, 30};
  const auto rows = table_rows("water_index.csv");
  ASSERT_EQ(rows.size(), 17u);
  for (const auto& row : rows) {
    const double wavelength_nm = std::stod(row[0]);
    for (std::size_t k = 0; k < 5; ++k) {
      const double t = temperatures_c[k];
      EXPECT_NEAR(water_index(water_density_kg_m3(t), t, wavelength_nm), std::stod(row[k + 1]),
                  6e-7)  // six decimals, and the last digit of the density
          << wavelength_nm << " nm, " << t << " C";
    }
    // The table divides by 1.000273 at all wavelengths; air's dispersion from 375 to 775 nm is
    // -2e-6 .. +7e-6 about that.
    EXPECT_NEAR(drop_index(20, 101325, wavelength_nm), std::stod(row[6]), 1.1e-5);
    // Measured by others (Quan and Fry 1995): the two agree to 5e-5 above 375 nm, 9e-5 at 775.
    EXPECT_NEAR(drop_index(20, 101325, wavelength_nm), std::stod(row[7]), 1e-4) << wavelength_nm;
  }
}

TEST(Water, DensityIsThatOfTheHandbooks) {
  // CRC Handbook (IAPWS-95, ITS-90); Kell's scale of 1968 differs by up to 0.01 K there: 4e-3
  // kg/m^3 at 40 C, and his fit by 3e-3.
  const double known[][2] = {{0.1, 999.8495}, {4, 999.9749},  {10, 999.7027}, {20, 998.2067},
                             {25, 997.0470},  {30, 995.6488}, {40, 992.2152}};
  for (const auto& [t, rho] : known) EXPECT_NEAR(water_density_kg_m3(t), rho, 7e-3) << t;
}

TEST(Water, SurfaceTensionIsThatOfTheReleasesTable) {
  // IAPWS R1-76(2014), table 1: mN/m with two decimals.
  const double known[][2] = {{0.01, 75.65}, {20, 72.74},  {25, 71.97}, {50, 67.94},
                             {100, 58.91},  {200, 37.67}, {300, 14.36}};
  for (const auto& [t, sigma] : known) {
    EXPECT_NEAR(1e3 * water_surface_tension_n_m(t), sigma, 5e-3) << t;
  }
}

TEST(Water, AirIsThinAndThinnerWhereItIsWarmOrHigh) {
  // Handbooks give 1.0002926 for the sodium lines at 0 C and one atmosphere; real air is up to 5e-4
  // denser there than an ideal gas scaled from 15 C.
  EXPECT_NEAR(air_index(0, 101325, 589.3) - 1, 2.926e-4, 4e-7);
  EXPECT_NEAR((air_index(15, 101325 / 2.0, 589.3) - 1) / (air_index(15, 101325, 589.3) - 1), 0.5,
              1e-10);  // the 1 of n takes six digits off
  EXPECT_LT(air_index(40, 101325, 589.3), air_index(0, 101325, 589.3));
  EXPECT_GT(air_index(15, 101325, 400), air_index(15, 101325, 700));
}

TEST(Water, OutsideTheirRangesTheFormulasAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::pair<std::function<double()>, const char*> refusals[] = {
      {[] { return water_density_kg_m3(-0.1); }, "temperature_c = -0.1; expected 0 <= "},
      {[] { return water_density_kg_m3(150.1); }, "<= 150"},
      {[&] { return water_density_kg_m3(nan); }, "temperature_c = nan"},
      {[] { return water_surface_tension_n_m(-26); }, "temperature_c = -26; expected -25 <="},
      {[] { return water_surface_tension_n_m(374); }, "temperature_c = 374"},
      {[] { return water_index(998, 20, 199); }, "wavelength_nm = 199; expected 200 <="},
      {[&] { return water_index(998, 20, infinity); }, "wavelength_nm = inf"},
      {[] { return water_index(1061, 20, 589); }, "density_kg_m3 = 1061"},
      {[] { return air_index(20, 9e3, 589); }, "pressure_pa = 9000"},
      {[] { return drop_index(-1, 101325, 589); }, "temperature_c = -1; expected 0 <="},
      {[] { return drop_index(20, 101325, 299); }, "wavelength_nm = 299; expected 300"},
  };
  for (const auto& [call, says] : refusals) {
    std::string message = "no refusal";
    try {
      call();
    } catch (const std::invalid_argument& error) {
      message = error.what();
    }
    EXPECT_THAT(message, HasSubstr(says));
  }
}

TEST(Water, EveryFormulaIsFiniteToTheEdgeOfItsRange) {
  for (const double t : {-25.0, 0.0, 370.0}) EXPECT_GT(water_surface_tension_n_m(t), 0) << t;
  for (const double t : {0.0, 150.0}) EXPECT_GT(water_density_kg_m3(t), 900) << t;
  for (const double wavelength_nm : {200.0, 1100.0}) {
    for (const double rho : {0.0, 1060.0}) {
      const double n = water_index(rho, 20, wavelength_nm);
      EXPECT_TRUE(std::isfinite(n) && n >= 1 && n < 1.5) << rho << ", " << wavelength_nm;
    }
  }
}

}  // namespace
}  // namespace pluvia
