// A fit must find what made-up factors were made with, and say so when the factors say nothing.
#include "validate/factor_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

// Coarse and narrow: the same field makes and fits the factors, so its own error cancels.
Preset coarse_preset() {
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  preset.width_px = 8;
  preset.field.base_cells = 6;
  preset.field.space_depth = 1;
  preset.field.time_depth = 0;
  return preset;
}

// Ten lights, of elevations 10 and 90, in a unit of their own.
std::vector<RealFactor> made_up_factors(const Preset& truth, double unit) {
  std::vector<RealFactor> factors;
  StreakRequest request = shard_request(truth, {.oscillation = 0});
  request.lights.clear();
  for (int h = 10; h <= 170; h += 20) request.lights.push_back({10, h});
  request.lights.push_back({90, 170});
  const TracedStreak streak = trace_streak(request);
  for (std::size_t k = 0; k < request.lights.size(); ++k) {
    const auto& mean = streak.light[k].mean;
    factors.push_back({request.lights[k], 0, unit * *std::max_element(mean.begin(), mean.end())});
  }
  return factors;
}

TEST(FactorFit, RecoversTheConeAndTheUnitThatMadeTheFactors) {
  Preset truth = coarse_preset();
  truth.cone_half_angle_deg = 5.5;
  const FactorFit fit = fit_factors(coarse_preset(), made_up_factors(truth, 100));
  // A maximum moves in steps of a coarse cell, so the fit stops near the truth: within a tenth of
  // the way from the start.
  EXPECT_TRUE(fit.cone.identifiable);
  EXPECT_NEAR(fit.cone.value, 5.5, 0.05);
  EXPECT_NEAR(fit.log10_constant, -2, 0.02);
  EXPECT_LT(fit.rms_after, 0.3 * fit.rms_before);
}

TEST(FactorFit, FactorsOfTheJudgedElevationAloneAreRefused) {
  const std::vector<RealFactor> factors = {{{50, 10}, 0, 1.0}};
  EXPECT_EQ(message_of([&] { fit_factors(coarse_preset(), factors); }),
            "no factor of set 0 and light elevation 10 or 90; expected some to fit");
}

TEST(FactorFit, WhatIsNotDeterminedIsWrittenWithoutANumber) {
  FactorFit fit;
  fit.cone = {"cone_half_angle_deg", 5, 5, -1, false};
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/fit.json";
  write_factor_fit(file, fit, {.sets = {{.values = {{.name = "A31", .why = "nothing tells"}}}}});
  const std::string text = read_file(file);
  EXPECT_NE(text.find("\"identifiable\": false"), std::string::npos);
  EXPECT_EQ(text.find("\"value\""), std::string::npos);
  EXPECT_NE(text.find("nothing tells"), std::string::npos);
}

}  // namespace
}  // namespace pluvia
