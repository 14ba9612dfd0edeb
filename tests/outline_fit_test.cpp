// Fits of made-up outlines: what made them is found again, and what they do not tell is not told.
#include "oscillation/outline_fit.h"

#include <fstream>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "oscillation/outline_problem.h"
#include "tests/outline_samples.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;
using testing::HasSubstr;

// -log10 of the deviation, relative where the truth is not an angle.
double digits_of_agreement(double found, double truth, double size) {
  return std::min(16.0, -std::log10(std::abs(found - truth) / size + 1e-17));
}

std::vector<std::pair<std::string, double>> truth_of(const DropShape& drop) {
  return {{"r0_mm", 1e3 * drop.mean_radius_m},
          {"A20", drop.modes[0].amplitude},
          {"phase20_deg", drop.modes[0].phase_rad / degree},
          {"A31", drop.modes[1].amplitude},
          {"phase31_deg", drop.modes[1].phase_rad / degree},
          {"phi_drop_deg", drop.phi_drop_rad / degree}};
}

TEST(OutlineFit, WithoutNoiseEightDigitsAgree) {
  const DropShape drop = oscillating_drop();
  const OutlineFit fit = fit_outlines(made_outlines(drop, {.times = 8, .angles = 16}));
  EXPECT_EQ(fit.refusal, "");
  EXPECT_TRUE(fit.converged);
  for (const auto& [name, truth] : truth_of(drop)) {
    const Estimate& found = estimate_of(fit.values, name);
    ASSERT_TRUE(is_identifiable(found)) << name << ": " << found.why;
    const double size = name.ends_with("_deg") ? 1 / degree : std::abs(truth);
    EXPECT_GE(digits_of_agreement(found.value, truth, size), 8) << name;
    EXPECT_GE(digits(found), 8) << name;
  }
  EXPECT_EQ(fit.outliers, 0);
}

// How many of `trials` intervals of every parameter hold the truth.
std::map<std::string, int> coverage(const OutlineSampling& sampling, int trials) {
  const DropShape drop = oscillating_drop();
  std::map<std::string, int> held;
  for (int k = 0; k < trials; ++k) {
    OutlineSampling with_seed = sampling;
    with_seed.seed = 100 + static_cast<std::uint64_t>(k);
    const OutlineFit fit = fit_outlines(made_outlines(drop, with_seed));
    for (const auto& [name, truth] : truth_of(drop)) {
      const Estimate& found = estimate_of(fit.values, name);
      EXPECT_TRUE(is_identifiable(found)) << name << ": " << found.why;
      held[name] += truth >= found.low && truth <= found.high ? 1 : 0;
    }
  }
  return held;
}

TEST(OutlineFit, NineteenOfTwentyIntervalsHoldTheTruth) {
  // Noise of 1 % of r0. Of 16 intervals at 95 %, fewer than 12 hold the truth with probability
  // 9e-4 (binomial).
  for (const auto& [name, held] : coverage({.times = 6, .angles = 10, .noise_m = 16e-6}, 16)) {
    EXPECT_GE(held, 12) << name;
  }
}

TEST(OutlineFit, AFifthOfOutliersIsTolerated) {
  // Cauchy's loss lets a distant outlier pull with at most its width / 2: the intervals still hold.
  // 8 of them: fewer than 5 with probability 4e-4.
  const OutlineSampling sampling = {
      .times = 8, .angles = 12, .noise_m = 16e-6, .outlier_share = 0.2};
  for (const auto& [name, held] : coverage(sampling, 8)) EXPECT_GE(held, 5) << name;
  const Outlines outlines = made_outlines(oscillating_drop(), sampling);
  const Outlines exact = made_outlines(oscillating_drop(), {.times = 8, .angles = 12});
  int far = 0;
  for (std::size_t k = 0; k < exact.points.size(); ++k) {
    far += std::abs(outlines.points[k].radius_m - exact.points[k].radius_m) > 80e-6 ? 1 : 0;
  }
  // The scale is 16 um without outliers and 1.3 times that with (estimate_test), so 4 of it are 64
  // to 90 um; an outlier lies in a given 20 um of its 2 mm with probability 1 %, on either side.
  EXPECT_GT(far, 10);
  EXPECT_NEAR(fit_outlines(outlines).outliers, far, 3);
}

TEST(OutlineFit, OutlinesThatAreAllOutliersAreNoDrop) {
  const OutlineFit fit = fit_outlines(
      made_outlines(oscillating_drop(), {.times = 8, .angles = 16, .outlier_share = 1}));
  EXPECT_THAT(fit.refusal, HasSubstr("of r0 about the best drop; expected at most 10 %"));
  for (const Estimate& value : fit.values) EXPECT_EQ(value.why, fit.refusal) << value.name;
}

TEST(OutlineFit, OneOutlineLeavesAmplitudesAndPhasesFree) {
  // At one instant a sin wt + b cos wt is one number. r0 is the outline's size.
  const OutlineFit fit =
      fit_outlines(made_outlines(oscillating_drop(), {.times = 1, .angles = 60}));
  for (const std::string name : {"A20", "phase20_deg", "A31", "phase31_deg"}) {
    EXPECT_EQ(estimate_of(fit.values, name).why, left_free) << name;
  }
}

TEST(OutlineFit, CollinearDataLeaveFreeWhatTheyDoNotShow) {
  // One angle in the picture, up, of a level camera: P31 vanishes at the pole, so that phi_drop and
  // A31 leave no trace there.
  OutlineSampling sampling = {.times = 40, .angles = 1, .view_elevation_rad = 0};
  DropShape drop = oscillating_drop();
  drop.modes[1].amplitude = 0;
  const OutlineFit fit = fit_outlines(made_outlines(drop, sampling));
  for (const std::string name : {"A31", "phase31_deg", "phi_drop_deg"}) {
    EXPECT_FALSE(is_identifiable(estimate_of(fit.values, name))) << name;
  }
}

TEST(OutlineFit, ThePhaseOfAnAmplitudeOfZeroIsNotDetermined) {
  for (const double noise_m : {0.0, 16e-6}) {
    DropShape drop = oscillating_drop();
    drop.modes[0].amplitude = 0;
    const OutlineFit fit =
        fit_outlines(made_outlines(drop, {.times = 8, .angles = 16, .noise_m = noise_m}));
    const Estimate& amplitude = estimate_of(fit.values, "A20");
    ASSERT_TRUE(is_identifiable(amplitude)) << amplitude.why;
    EXPECT_EQ(amplitude.low, 0);
    // 128 points of 1 %: a standard error near 0.01 / sqrt(128 <P20^2> / 2) = 0.003.
    EXPECT_LT(amplitude.high, noise_m > 0 ? 0.015 : 1e-8);
    EXPECT_EQ(estimate_of(fit.values, "phase20_deg").why, "the amplitude cannot be told from zero");
    EXPECT_TRUE(is_identifiable(estimate_of(fit.values, "phase31_deg")));
  }
}

TEST(OutlineFit, WithoutTransverseModesThereIsNoDirectionOfTheDrop) {
  DropShape drop = oscillating_drop();
  drop.modes[1].amplitude = 0;
  const Outlines outlines = made_outlines(drop, {.times = 8, .angles = 16, .noise_m = 16e-6});
  EXPECT_EQ(estimate_of(fit_outlines(outlines).values, "phi_drop_deg").why,
            "no amplitude of a mode with m > 0 can be told from zero");
  const OutlineFit fit = fit_outlines(outlines, {.modes = {{2, 0}}});
  EXPECT_EQ(estimate_of(fit.values, "phi_drop_deg").why, "no mode has m > 0");
  EXPECT_NEAR(estimate_of(fit.values, "A20").value, 0.11, 0.01);
}

TEST(OutlineFit, ALevelCameraCannotTellFrontFromBackAndASecondOneCan) {
  // Mirrored about the picture plane, phi_drop becomes pi - phi_drop, and the outline stays.
  const DropShape drop = oscillating_drop();
  const OutlineSampling level = {.times = 8, .angles = 16, .view_elevation_rad = 0};
  Outlines outlines = made_outlines(drop, level);
  const OutlineFit fit = fit_outlines(outlines);
  ASSERT_EQ(fit.alternatives.size(), 1u);
  const double sum = fit.drop.phi_drop_rad + fit.alternatives[0].phi_drop_rad;
  EXPECT_NEAR(sum, pi, 1e-7);
  OutlineSampling side = level;
  side.view_azimuth_rad = 0.5;
  const Outlines more = made_outlines(drop, side);
  outlines.points.insert(outlines.points.end(), more.points.begin(), more.points.end());
  const OutlineFit both = fit_outlines(outlines);
  EXPECT_TRUE(both.alternatives.empty());
  EXPECT_NEAR(both.drop.phi_drop_rad, drop.phi_drop_rad, 1e-8);
}

TEST(OutlineFit, FindsTheRadiusAlsoWhereAWrongOneWouldBeManyTurnsOff) {
  // 0.4 s of a 1.6 mm drop are 46 periods of mode 3: a radius that is 1 % off is 4.4 rad off at the
  // end. From the median alone the fit settles beside the frequency; noise of 2 % hides it.
  DropShape drop;
  drop.mean_radius_m = 1.2e-3;
  drop.equilibrium_cos = {0, 0, -0.05};
  drop.modes = {{.n = 2, .m = 0, .amplitude = 0.2, .phase_rad = 1.0},
                {.n = 3, .m = 1, .amplitude = 0.06, .phase_rad = -2.0}};
  drop.phi_drop_rad = 1.2;
  const OutlineFit fit = fit_outlines(
      made_outlines(drop, {.times = 16, .angles = 6, .duration_s = 0.3, .noise_m = 24e-6}),
      {.equilibrium_cos = drop.equilibrium_cos});
  // A radian of phase at the end is 0.1 % of r0 in a film of 0.3 s (w3 = 1130 rad/s).
  EXPECT_NEAR(estimate_of(fit.values, "r0_mm").value, 1.2, 0.0012);
  EXPECT_NEAR(estimate_of(fit.values, "A20").value, 0.2, 0.02);
}

TEST(OutlineFit, ATurnOfThePeriodGivesTheSameDropWithTheSignsThatBelongToIt) {
  // Of modes with m = 1 and 2 the period is 180 degrees, of m = 2 and 4 it is 90.
  for (const auto& modes : {std::vector<OutlineModel::Mode>{{3, 1}, {2, 2}, {2, 0}},
                            std::vector<OutlineModel::Mode>{{2, 2}, {4, 4}}}) {
    const OutlineModel model = {.modes = modes};
    const OutlineTask task =
        make_outline_task(made_outlines(oscillating_drop(), {.times = 2, .angles = 8}), model);
    for (const double phi : {-4.0, -0.02, 1.0, 2.5, 9.0}) {
      OutlineParameters x = {1, phi, 0.05, 0.02, -0.03, 0.04};
      if (modes.size() > 2) x.insert(x.end(), {0.01, 0.02});
      OutlineParameters turned = x;
      make_canonical(task, turned);
      EXPECT_TRUE(turned[1] >= 0 && turned[1] < task.period_rad) << phi;
      // The surface at the instant when the sines are 1 and the cosines 0.
      const auto height = [&](const OutlineParameters& p) {
        HarmonicSurface<double> surface;
        for (std::size_t i = 0; i < modes.size(); ++i) {
          add_mode(surface, modes[i].n, modes[i].m, p[first_outline_mode + 2 * i], p[1]);
        }
        return evaluate(surface, Eigen::Vector3d(0.48, 0.6, 0.64)).h;
      };
      // Rounding of a turn by 9 rad: 1e-15.
      EXPECT_NEAR(height(turned), height(x), 1e-14) << phi;
    }
  }
}

TEST(OutlineFit, ADropOfOtherModesAndAFlattenedOneAreFoundToo) {
  DropShape drop;
  drop.mean_radius_m = 1e-3;
  drop.equilibrium_cos = {-0.013, 0.01, -0.04};
  drop.modes = {{.n = 2, .m = 1, .amplitude = 0.05, .phase_rad = 1.5},
                {.n = 2, .m = 2, .amplitude = 0.03, .phase_rad = -2},
                {.n = 4, .m = 0, .amplitude = 0.04, .phase_rad = 3}};
  drop.phi_drop_rad = 2.5;
  OutlineModel model = {.modes = {{2, 1}, {2, 2}, {4, 0}}, .equilibrium_cos = drop.equilibrium_cos};
  const OutlineFit fit =
      fit_outlines(made_outlines(drop, {.times = 12, .angles = 16, .duration_s = 5e-3}), model);
  EXPECT_NEAR(fit.drop.mean_radius_m, 1e-3, 1e-11);
  EXPECT_NEAR(fit.drop.phi_drop_rad, 2.5, 1e-8);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(fit.drop.modes[k].amplitude, drop.modes[k].amplitude, 1e-9);
    EXPECT_NEAR(fit.drop.modes[k].phase_rad, drop.modes[k].phase_rad, 1e-7);
  }
}

// data/outlines/synthetic.csv, made anew: the drop and the noise that its head tells, radii rounded
// to 0.1 um.
std::string synthetic_table() {
  std::string text =
      "# source: made up by tests/outline_fit_test.cpp, TheExampleIsWhatItsHeadTells\n"
      "# A drop of r0 = 1.6 mm, A20 = 0.11, phase20 = 22.9 deg, A31 = 0.08, phase31 = -63.0 deg,\n"
      "# phi_drop = 40.1 deg, seen from 0.5 rad above; normal noise of 10 um, every tenth point "
      "an\n"
      "# outlier. Times in s, angles in degrees, radii in mm.\n"
      "t_s,theta_deg,r_mm,view_elevation_deg\n";
  const OutlineSampling sampling = {
      .times = 10, .angles = 24, .noise_m = 10e-6, .outlier_share = 0.1, .seed = 2006};
  for (const OutlinePoint& p : made_outlines(oscillating_drop(), sampling).points) {
    text += fmt::format("{:.6f},{:.0f},{:.4f},{:.4f}\n", p.time_s, p.theta_rad / degree,
                        1e3 * p.radius_m, p.view_elevation_rad / degree);
  }
  return text;
}

TEST(OutlineFit, TheExampleIsWhatItsHeadTells) {
  const std::string file = PLUVIA_SOURCE_DIR "/data/outlines/synthetic.csv";
  const std::string fresh = synthetic_table();
  std::ostringstream there;
  there << std::ifstream(file).rdbuf();
  if (there.str() != fresh) {
    const std::string copy = testing::TempDir() + "synthetic.csv";
    std::ofstream(copy) << fresh;
    FAIL() << file << " differs from what makes it; see " << copy;
  }
  const OutlineFit fit = fit_outlines(read_outlines(file));
  for (const auto& [name, truth] : truth_of(oscillating_drop())) {
    // Six intervals of 95 %: one may miss, by less than as much again (1e-4).
    const Estimate& found = estimate_of(fit.values, name);
    EXPECT_NEAR(found.value, truth, found.high - found.low) << name;
  }
}

TEST(OutlineFit, WhatCannotBeFittedIsRefused) {
  Outlines few = made_outlines(oscillating_drop(), {.times = 1, .angles = 6});
  EXPECT_EQ(message_of([&] { fit_outlines(few); }), "6 points; expected more than the 6 unknowns");
  const Outlines enough = made_outlines(oscillating_drop(), {.times = 2, .angles = 6});
  EXPECT_THROW(fit_outlines(enough, {.modes = {{1, 0}}}), std::invalid_argument);
  EXPECT_THROW(fit_outlines(enough, {.modes = {{2, 3}}}), std::invalid_argument);
  EXPECT_THROW(fit_outlines(enough, {.modes = {{2, 0}, {2, 0}}}), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
