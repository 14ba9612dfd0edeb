// The amplitudes of the sets from their factors: with maxima in closed form, so that what is tested
// is the fit; and that the traced maxima are those of the drop asked for.
#include "validate/amplitude_fit.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/outline_samples.h"
#include "tests/temporary_folder.h"
#include "validate/amplitude_table.h"

namespace pluvia {
namespace {

const std::vector<OscillationSet> three_sets = {
    {.index = 0},
    {.index = 2, .a20 = 0.1, .a31 = 0.1, .phi_drop_deg = 90},
    {.index = 3, .a20 = 0.2, .a31 = 0.05}};

// A smooth stand-in: every light depends on both amplitudes in a way of its own. `noise`: standard
// deviation, new with every seed. `blind`: A31 changes nothing.
AmplitudeModel smooth_model(double noise = 0, bool blind = false) {
  AmplitudeModel model;
  model.lights = {{90, 170}};
  for (int h = 10; h <= 170; h += 20) {
    model.lights.insert(model.lights.end(), {{10, h}, {50, h}});
  }
  model.log_maxima = [=, count = model.lights.size()](double a20, double a31, double phi_drop_deg,
                                                      std::uint64_t seed) {
    Random random(seed + static_cast<std::uint64_t>(1e6 * (a20 + 7 * a31) + 1e9 * phi_drop_deg));
    std::vector<double> maxima;
    for (std::size_t k = 0; k < count; ++k) {
      const double light = static_cast<double>(k);
      const double angle = phi_drop_deg * std::numbers::pi / 180;
      maxima.push_back(-2 + std::sin(light) * 4 * a20 + 3 * std::cos(5 * a20 + light) +
                       (blind ? 0 : 5 * a31 * std::cos(2 * light + angle)) +
                       noise * normal(random));
    }
    return maxima;
  };
  return model;
}

std::vector<RealFactor> made_factors(const AmplitudeModel& model,
                                     const std::vector<OscillationSet>& truth, double unit) {
  std::vector<RealFactor> factors;
  for (const OscillationSet& set : truth) {
    const auto maxima = model.log_maxima(set.a20, set.a31, set.phi_drop_deg, 5);
    for (std::size_t k = 0; k < maxima.size(); ++k) {
      factors.push_back({model.lights[k], set.index, unit * std::pow(10, maxima[k])});
    }
  }
  return factors;
}

// Amplitudes that differ from those of three_sets.
std::vector<OscillationSet> other_amplitudes() {
  std::vector<OscillationSet> truth = three_sets;
  truth[1].a20 = 0.13;
  truth[1].a31 = 0.06;
  truth[2].a20 = 0.07;
  truth[2].a31 = 0.095;
  return truth;
}

TEST(AmplitudeTable, TheBorderContinuesALinearTableOnAllSides) {
  std::vector<double> plane;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) plane.push_back(10 * i + j);
  }
  const std::vector<double> wider = with_border(plane, 3, 2);
  ASSERT_EQ(wider.size(), 5u * 4u);
  for (int i = -1; i < 4; ++i) {
    for (int j = -1; j < 3; ++j) {
      EXPECT_EQ(wider[static_cast<std::size_t>((i + 1) * 4 + j + 1)], 10 * i + j) << i << " " << j;
    }
  }
}

TEST(AmplitudeFit, FindsTheAmplitudesAndTheUnitThatMadeTheFactors) {
  const AmplitudeModel model = smooth_model();
  const std::vector<OscillationSet> truth = other_amplitudes();
  const AmplitudeFit fit = fit_amplitudes(three_sets, made_factors(model, truth, 50), model);
  ASSERT_EQ(fit.sets.size(), 3u);
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.log10_constant, -std::log10(50), 0.01);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SetAmplitudes& set = fit.sets[i];
    // What is left is the table's: cubics over steps of 0.05 of 3 cos(5 A) err by some
    // 3 (5 0.05)^3 / 48 = 1e-3, over slopes of 4 or more per unit of amplitude.
    EXPECT_NEAR(set.values[0].value, truth[i].a20, 1e-3) << "set " << set.oscillation;
    EXPECT_NEAR(set.values[1].value, truth[i].a31, 1e-3) << "set " << set.oscillation;
    EXPECT_LT(set.rms_judged, 0.01);
    EXPECT_EQ(set.rms_judged_preset > 0.1, i > 0) << "the amplitudes it is compared with";
  }
  EXPECT_EQ(fit.log10_noise, 0);
  EXPECT_EQ(fit.traced, 6 * (1 + 2 * 3) * 2 + 6);
}

TEST(AmplitudeFit, NineteenOfTwentyIntervalsHoldTheTruthOfNoisyMaxima) {
  // Five times four intervals (sets 2 and 3): of 20 at 95 %, fewer than 15 hold the truth with
  // probability 3e-4.
  const std::vector<OscillationSet> truth = other_amplitudes();
  int held = 0;
  for (int trial = 0; trial < 5; ++trial) {
    AmplitudeModel noisy = smooth_model(0.1);
    const auto of = noisy.log_maxima;
    noisy.log_maxima = [=](double a20, double a31, double phi, std::uint64_t seed) {
      return of(a20, a31, phi, seed + 1000 * static_cast<std::uint64_t>(trial));
    };
    const AmplitudeFit fit = fit_amplitudes(three_sets, made_factors(noisy, truth, 1), noisy);
    // Of the mean of two seeds: 0.1 / sqrt(2); 19 lights x 42 nodes know it to 3 %.
    EXPECT_NEAR(fit.log10_noise, 0.0707, 0.009);
    for (const std::size_t i : {1u, 2u}) {
      for (const auto& [k, value] : {std::pair{0u, truth[i].a20}, {1u, truth[i].a31}}) {
        const Estimate& e = fit.sets[i].values[k];
        held += is_identifiable(e) && e.low <= value && value <= e.high ? 1 : 0;
      }
    }
  }
  EXPECT_GE(held, 15);
}

TEST(AmplitudeFit, OneWrongFactorDoesNotMoveTheOthers) {
  const AmplitudeModel model = smooth_model();
  const std::vector<OscillationSet> truth = other_amplitudes();
  std::vector<RealFactor> factors = made_factors(model, truth, 1);
  factors[19 + 3].factor *= 100;  // set 2, light elevation 10
  const AmplitudeFit fit = fit_amplitudes(three_sets, factors, model);
  // The loss is linear far out: a residual of 2 pulls like one of 0.15.
  EXPECT_NEAR(fit.sets[1].values[0].value, truth[1].a20, 0.02);
  EXPECT_NEAR(fit.sets[2].values[1].value, truth[2].a31, 0.01);
}

TEST(AmplitudeFit, AnAmplitudeThatChangesNothingIsNamedAsFree) {
  const AmplitudeModel blind = smooth_model(0, true);
  const AmplitudeFit fit = fit_amplitudes(three_sets, made_factors(blind, three_sets, 1), blind);
  for (const SetAmplitudes& set : fit.sets) {
    EXPECT_TRUE(is_identifiable(set.values[0]));
    EXPECT_EQ(set.values[1].why, "the data leave it free");
  }
}

TEST(AmplitudeFit, AnAmplitudeBeyondTheTableIsNotToldAsItsEnd) {
  const AmplitudeModel model = smooth_model();
  std::vector<OscillationSet> truth = three_sets;
  truth[1].a31 = 0.16;
  const AmplitudeFit fit = fit_amplitudes(three_sets, made_factors(model, truth, 1), model);
  EXPECT_EQ(fit.sets[1].values[1].why, "it would lie beyond 0.12, where the table ends");
}

TEST(AmplitudeFit, TooFewFactorsAreRefused) {
  const AmplitudeModel model = smooth_model();
  const std::vector<RealFactor> factors = {{{10, 10}, 3, 1.0}, {{90, 170}, 3, 1.0}};
  EXPECT_EQ(message_of([&] { fit_amplitudes(three_sets, factors, model); }),
            "2 factors of light elevations 10 and 90 for 1 sets; expected more than three a set "
            "and one");
}

TEST(AmplitudeFit, TracedMaximaAreThoseOfTheDropAskedFor) {
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  preset.width_px = 8;
  preset.slices = 32;
  preset.spans_per_period = 2;
  preset.field.base_cells = 6;
  preset.field.space_depth = preset.field.time_depth = 0;
  const AmplitudeModel model =
      traced_model(preset, {{{10, 130}, 3, 1}, {{50, 110}, 3, 1}, {{10, 130}, 4, 1}});
  ASSERT_EQ(model.lights, (std::vector<LightDirection>{{10, 130}, {50, 110}}));
  StreakRequest request = shard_request(preset, {.oscillation = 3});
  request.lights = model.lights;
  request.seed = 4;
  request.drop.modes = {{.n = 2, .m = 0, .amplitude = 0.1}, {.n = 3, .m = 1, .amplitude = 0.05}};
  request.drop.phi_drop_rad = 0.5 * std::numbers::pi;
  const auto maxima = model.log_maxima(0.1, 0.05, 90, 4);
  const TracedStreak streak = trace_streak(request);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& mean = streak.light[k].mean;
    const double brightest = *std::max_element(mean.begin(), mean.end());
    EXPECT_EQ(maxima[k], std::log10(brightest));
  }
}

}  // namespace
}  // namespace pluvia
