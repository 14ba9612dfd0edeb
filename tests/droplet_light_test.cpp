#include "raytrace/droplet_light.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/table_file.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

TEST(DropletLight, IsAllOfTheLightThatMeetsTheDroplet) {
  for (const int bins : {90, 180, 360}) {
    const std::vector<double> phase = droplet_phase(bins);
    double sum = 0;
    for (int i = 0; i < bins; ++i)
      sum += phase[static_cast<std::size_t>(i)] * 2 * pi *
             (std::cos(i * pi / bins) - std::cos((i + 1) * pi / bins));
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(DropletLight, AgreesWithTheTableOfAnotherComputation) {
  const auto rows = table_rows("sphere_go_binned_1deg.csv");
  ASSERT_EQ(rows.size(), 180u);
  const std::vector<double> phase = droplet_phase(180);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double expected = std::stod(rows[i].back());
    // 200,000 rings: the rays of an order that meet a bin are counted to one or two at its ends,
    // each 1 / 200,000 of the light over the bin's solid angle. 1e-4: orders beyond the twelfth.
    const double ray = 1 / (200000 * std::stod(rows[i][2]));
    EXPECT_NEAR(phase[i], expected, 2e-3 * expected + 2 * ray + 1e-4 / (4 * pi)) << i << " deg";
  }
}

TEST(DropletLight, AgreesWithTheClosedFormAwayFromRainbows) {
  const std::vector<double> phase = droplet_phase(360);
  for (const double deg : {10.25, 30.25, 60.25, 80.25, 110.25, 150.25, 170.25}) {
    const double expected = sphere_intensity(1.333, 20, deg * pi / 180);
    // The bin is half a degree: second derivative times its square, and the count of rays.
    EXPECT_NEAR(phase[static_cast<std::size_t>(2 * deg)], expected, 0.01 * expected) << deg;
  }
}

}  // namespace
}  // namespace pluvia
