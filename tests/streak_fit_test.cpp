// Fits of traced streaks: the drop that made them is found again from another seed's streak.
#include "validate/streak_fit.h"

#include <cmath>
#include <numbers>
#include <tuple>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "tests/outline_samples.h"
#include "tests/temporary_folder.h"
#include "validate/streak_features.h"
#include "validate/streak_input.h"

namespace pluvia {
namespace {

constexpr double degree = std::numbers::pi / 180;

// Coarse in space and time: cheap, and the raggedness of the generator is at its largest.
StreakRequest small_request() {
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  preset.width_px = 8;
  preset.slices = 64;
  preset.spans_per_period = 2;
  preset.field.base_cells = 6;
  preset.field.space_depth = 1;
  preset.field.time_depth = 0;
  return shard_request(preset, {.oscillation = 0, .view_elevation_deg = 0});
}

const std::vector<LightDirection> two_lights = {{10, 130}, {50, 110}};

std::vector<MeasuredStreak> made_streaks(const StreakStart& drop, std::uint64_t seed,
                                         double level = 1) {
  StreakRequest request = small_request();
  request.seed = seed;
  request.lights = two_lights;
  request.drop.modes = {{.n = 2, .m = 0, .amplitude = drop.a20, .phase_rad = drop.phase20_rad},
                        {.n = 3, .m = 1, .amplitude = drop.a31, .phase_rad = drop.phase31_rad}};
  request.drop.phi_drop_rad = drop.phi_drop_rad;
  const TracedStreak traced = trace_streak(request);
  std::vector<MeasuredStreak> streaks;
  for (std::size_t k = 0; k < two_lights.size(); ++k) {
    MeasuredStreak streak{two_lights[k], {}};
    for (const float v : traced.light[k].mean) streak.values.push_back(level * v);
    streaks.push_back(streak);
  }
  return streaks;
}

TEST(StreakFeatures, OfAnEvenStreakAreItsRootFluxAndNoMoment) {
  const StreakFrame frame = {.width_px = 8, .height_px = 64, .centre_column = 4, .path_rows = 48};
  const auto features = streak_features(frame, std::vector<double>(8 * 64, 0.25));
  const auto points = static_cast<std::size_t>(feature_points(frame));
  ASSERT_EQ(features.size(), 2 * points);
  for (std::size_t k = 0; k < points; ++k) {
    EXPECT_NEAR(features[k], std::sqrt(2 * 1.001), 1e-12);  // flux 2, floor a thousandth
    EXPECT_NEAR(features[points + k], 0, 1e-12);
  }
}

TEST(StreakFeatures, AGlintToTheRightHasAPositiveMomentAndBrightnessComesOutAsItsRoot) {
  const StreakFrame frame = {.width_px = 8, .height_px = 64, .centre_column = 4, .path_rows = 48};
  std::vector<double> values(8 * 64, 0.0);
  for (std::size_t row = 0; row < 64; ++row) values[row * 8 + 6] = 1;  // 2.5 columns off the middle
  const auto features = streak_features(frame, values);
  const std::size_t points = features.size() / 2;
  EXPECT_NEAR(features[points], 2.5 / 8 / std::sqrt(1.001), 1e-12);
  for (double& v : values) v *= 9;
  EXPECT_NEAR(streak_features(frame, values)[points], 3 * features[points], 1e-12);
}

TEST(StreakFit, AnotherSeedsStreakGivesTheDropThatMadeIt) {
  const StreakStart truth = {.a20 = 0.11, .a31 = 0.09, .phi_drop_rad = 60 * degree};
  const std::vector<StreakStart> starts = {
      {.a20 = 0.14, .a31 = 0.07, .phi_drop_rad = 45 * degree},
      {.a20 = 0.14, .a31 = 0.07, .phi_drop_rad = 225 * degree}};
  const StreakFit fit =
      fit_streak(small_request(), made_streaks(truth, 5), starts, {.polished = 1, .iterations = 5});
  EXPECT_EQ(fit.refusal, "");
  for (const Estimate& e : fit.values) ASSERT_TRUE(is_identifiable(e)) << e.name << ": " << e.why;
  // The intervals hold the truth, and are narrow enough to say something.
  for (const auto& [name, value, widest] :
       {std::tuple{"A20", 0.11, 0.05}, {"A31", 0.09, 0.02}, {"phi_drop_deg", 60.0, 20.0}}) {
    const Estimate& e = estimate_of(fit.values, name);
    EXPECT_TRUE(e.low <= value && value <= e.high) << name << " " << e.low << " .. " << e.high;
    EXPECT_LT(e.high - e.low, 2 * widest) << name;
  }
  EXPECT_LT(fit.residual, 0.1);
}

TEST(StreakFit, AnUnknownLevelIsFoundBesideTheDrop) {
  const StreakStart truth = {.a20 = 0.11, .a31 = 0.09, .phi_drop_rad = 60 * degree};
  const auto fitted = [&](bool known_level) {
    return fit_streak(small_request(), made_streaks(truth, 5, 7), {truth},
                      {.known_level = known_level, .polished = 1, .iterations = 2});
  };
  const StreakFit fit = fitted(false);
  // Two traced streaks of so few instants differ in flux by 1 or 2 %.
  EXPECT_NEAR(fit.level / 7, 1, 0.05);
  EXPECT_NEAR(estimate_of(fit.values, "A20").value, truth.a20, 0.03);
  EXPECT_GT(fitted(true).residual, 5 * fit.residual) << "held to be known, it spoils the likeness";
}

TEST(StreakFit, WithoutATransverseModeThereIsNoDirectionOfTheDrop) {
  const StreakStart truth = {.a20 = 0.12};
  const StreakFit fit = fit_streak(small_request(), made_streaks(truth, 5),
                                   {{.a20 = 0.12, .a31 = 0.01}}, {.polished = 1, .iterations = 3});
  EXPECT_TRUE(is_identifiable(estimate_of(fit.values, "A20")));
  EXPECT_LT(estimate_of(fit.values, "A31").high, 0.03);
  EXPECT_EQ(estimate_of(fit.values, "phi_drop_deg").why, "the amplitude cannot be told from zero");
}

TEST(StreakFit, ThePhaseOfAnAmplitudeOfZeroIsNotDetermined) {
  const StreakStart truth = {.a31 = 0.09, .phase31_rad = 50 * degree, .phi_drop_rad = 60 * degree};
  const StreakFit fit = fit_streak(small_request(), made_streaks(truth, 5), {truth},
                                   {.free_phases = true, .polished = 1, .iterations = 2});
  EXPECT_EQ(estimate_of(fit.values, "phase20_deg").why, "the amplitude cannot be told from zero");
  for (const auto& [name, value] : {std::pair{"phase31_deg", 50.0}, {"phi_drop_deg", 60.0}}) {
    // A 95 % interval misses one time in twenty, one of these two one time in ten. Twice as wide it
    // is four standard errors to either side: one time in ten thousand.
    const Estimate& e = estimate_of(fit.values, name);
    const double middle = 0.5 * (e.low + e.high), half_width = 0.5 * (e.high - e.low);
    EXPECT_LE(std::abs(value - middle), 2 * half_width) << name << " " << e.low << " .. " << e.high;
    EXPECT_LT(half_width, 20) << name << " is hardly determined: nothing was tested";
  }
}

TEST(StreakFit, NoiseIsNoStreak) {
  Random random(9);
  std::vector<MeasuredStreak> noise = made_streaks({.a20 = 0.1}, 5);
  for (MeasuredStreak& streak : noise) {
    for (double& v : streak.values) v = std::exp(3 * normal(random));
  }
  const StreakFit fit = fit_streak(small_request(), noise, {{.a20 = 0.1, .a31 = 0.05}},
                                   {.known_level = false, .polished = 1, .iterations = 1});
  EXPECT_THAT(fit.refusal, testing::HasSubstr("of the streak's brightness pattern; expected at"));
  for (const Estimate& e : fit.values) EXPECT_EQ(e.why, fit.refusal);
}

TEST(StreakInput, LightsAreNamedAsInAShard) {
  EXPECT_EQ(parse_light_name("light_v-70_h010"), (LightDirection{-70, 10}));
  for (const std::string name : {"light_v10_h010", "light_v+91_h010", "light_v+10_h190", "env"}) {
    EXPECT_EQ(message_of([&] { parse_light_name(name); }),
              "light \"" + name + "\"; expected the like of light_v+10_h050");
  }
}

TEST(StreakInput, APictureIsLitByOneLightAndHasALevelOfItsOwn) {
  const TemporaryFolder folder;
  Image image = make_image(8, 5);
  image.at(3, 2) = 0.5f;
  write_png(folder / "streak.png", image);
  const StreakInput input = read_streaks(folder / "streak.png", {"light_v+10_h050"}, 20);
  ASSERT_EQ(input.streaks.size(), 1u);
  EXPECT_GT(input.streaks[0].values[2 * 8 + 3], 0.4);
  EXPECT_EQ(input.view_elevation_deg, 20);
  EXPECT_FALSE(input.known_level);
  EXPECT_THAT(message_of([&] { read_streaks(folder / "streak.png", {}, 20); }),
              testing::HasSubstr("streak.png: a picture, and 0 lights named; expected the one"));
  write_png(folder / "three.png", make_image(8, 5, 3));
  EXPECT_THAT(message_of([&] { read_streaks(folder / "three.png", {"light_v+10_h050"}, 0); }),
              testing::HasSubstr("three.png: 3 channels; expected one"));
}

TEST(StreakInput, AShardGivesTheLightsThatAreNamed) {
  Shard shard{.key = {3200, 3, 20}, .width_px = 2, .height_px = 3, .lights = two_lights};
  for (const float v : {1.0f, 2.0f}) {
    shard.light.push_back({std::vector<float>(6, v), std::vector<float>(6, 0.0f)});
  }
  shard.env = shard.coverage = shard.light[0];
  const TemporaryFolder folder;
  const std::string file = folder / (shard_name(shard.key) + ".exr");
  write_shard(file, shard);
  const StreakInput input = read_streaks(file, {"light_v+50_h110"}, 0);
  ASSERT_EQ(input.streaks.size(), 1u);
  EXPECT_EQ(input.streaks[0].values, std::vector<double>(6, 2.0));
  EXPECT_EQ(input.view_elevation_deg, 20);
  EXPECT_TRUE(input.known_level);
  EXPECT_EQ(read_streaks(file, {}, 0).streaks.size(), 2u);
  EXPECT_THAT(message_of([&] { read_streaks(file, {"light_v+10_h010"}, 0); }),
              testing::HasSubstr(".exr: no part light_v+10_h010; expected one of the shard's"));
}

TEST(StreakFit, StreaksThatHoldNothingAreRefused) {
  const StreakRequest request = small_request();
  const auto size = static_cast<std::size_t>(request.frame.width_px * request.frame.height_px);
  const auto complaint = [&](const std::vector<double>& values) {
    return message_of([&] { fit_streak(request, {{{10, 130}, values}}, streak_starts(false)); });
  };
  EXPECT_EQ(complaint(std::vector<double>(size, 0.0)),
            "light_v+10_h130: black; expected a streak with light in it");
  EXPECT_EQ(complaint(std::vector<double>(3, 1.0)),
            fmt::format("light_v+10_h130: 3 pixels; expected 8 x {}", request.frame.height_px));
  EXPECT_THAT(complaint(std::vector<double>(size, std::nan(""))),
              testing::HasSubstr("pixel value nan; expected a finite number >= 0"));
  EXPECT_THROW(fit_streak(request, {}, streak_starts(false)), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
