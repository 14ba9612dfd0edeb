// Mattes and background of clips whose rain is known (tests/rain_clip.h).
#include "validate/rain_mattes.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <Eigen/Dense>

#include "tests/rain_clip.h"
#include "tests/temporary_folder.h"
#include "validate/fall_direction.h"
#include "validate/matte_systems.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

RainMattes found(const std::vector<Image>& frames, const MatteSettings& settings = {}) {
  return rain_mattes(frames, settings, [](const std::string&, double) {});
}

double psnr_db(const Image& picture, const Image& truth) {
  return peak_error(picture, truth, 1).psnr_db.value_or(std::numeric_limits<double>::infinity());
}

double matte_rms(const std::vector<Image>& mattes, const std::vector<Image>& truth) {
  double squares = 0;
  for (std::size_t k = 0; k < truth.size(); ++k)
    squares += std::pow(peak_error(mattes[k], truth[k], 1).rms_over_peak, 2);
  return std::sqrt(squares / static_cast<double>(truth.size()));
}

// What the median alone says of the mattes: the rise above it, over that to the rain's true colour.
std::vector<Image> mattes_over(const Image& behind, const RainClip& clip,
                               const RainClipSpec& spec) {
  std::vector<Image> mattes = clip.mattes;
  for (std::size_t k = 0; k < mattes.size(); ++k) {
    for (std::size_t i = 0; i < mattes[k].values.size(); ++i) {
      double rise = 0, whole = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double away = spec.colour[c] - behind.values[3 * i + c];
        rise += away * (clip.frames[k].values[3 * i + c] - behind.values[3 * i + c]);
        whole += away * away;
      }
      mattes[k].values[i] = static_cast<float>(std::clamp(rise / whole, 0.0, 1.0));
    }
  }
  return mattes;
}

TEST(RainMattes, ShowWhatIsBehindRainThatCoversEachPixelInHalfOfTheFrames) {
  for (const RainClipSpec& spec :
       {RainClipSpec{}, RainClipSpec{.even = true}, RainClipSpec{.noise = 0.02},
        RainClipSpec{.strongest = 0.3}, RainClipSpec{.lean_deg = 60},
        RainClipSpec{.lean_deg = -27, .noise = 0.01, .seed = 3}}) {
    const RainClip clip = rain_clip(spec);
    ASSERT_EQ(clip.frames.size(), 20u);
    for (std::size_t pixel = 0; pixel < clip.mattes[0].values.size(); ++pixel)
      ASSERT_GE(covered_frames(clip.mattes, pixel), 10u) << "pixel " << pixel;
    const Image median = temporal_median(clip.frames);
    const RainMattes mattes = found(clip.frames);
    const double of_median = psnr_db(median, clip.background);
    const double of_mattes = psnr_db(mattes.background, clip.background);
    const double rms = matte_rms(mattes.mattes, clip.mattes);
    const double median_rms = matte_rms(mattes_over(median, clip, spec), clip.mattes);
    fmt::print("{:.1f} dB, median {:.1f}; mattes {:.3f}, from the median {:.3f}; {:.1f} degrees\n",
               of_mattes, of_median, rms, median_rms, mattes.lean_deg);  // docs/mattes.md
    // Required: 3 dB. Noise of 0.02 in 20 frames, of which 7 are free of rain, is 42 dB by itself.
    EXPECT_GE(of_mattes, of_median + 15) << of_median;
    // The median's mattes are given the rain's true colour. Measured: 0.11 to 0.48 of their error;
    // 0.60 at 60 degrees, where colours are found 30 % too bright and all mattes so too small.
    EXPECT_LE(rms, median_rms * (spec.lean_deg > 45 ? 0.7 : 0.5)) << spec.lean_deg;
    // Streaks lean by up to a degree to either side.
    EXPECT_NEAR(mattes.lean_deg, spec.lean_deg, 1);
  }
}

TEST(RainMattes, NoStepRaisesTheEnergy) {
  const RainClip rain = rain_clip({.width = 48, .height = 40, .noise = 0.01});
  for (const MatteSettings& settings : {MatteSettings{}, MatteSettings{.lambda = 0, .mu = 0},
                                        MatteSettings{.lambda = 1, .mu = 4}}) {
    const RainMattes mattes = found(rain.frames, settings);
    // Sums of 20 x 3 x 1,920 terms >= 0 are off by less than so many times 2^-53 of themselves.
    const double rounding = 1 + 120000 * std::ldexp(1.0, -53);
    double before = mattes.start.total();
    for (const MatteIteration& step : mattes.iterations) {
      for (const MatteEnergy& energy :
           {step.mattes, step.direction, step.background, step.colours}) {
        EXPECT_LE(energy.total(), before * rounding) << "lambda " << settings.lambda;
        before = energy.total();
      }
    }
    EXPECT_LT(before, mattes.start.total() / 20);
  }
}

double directly_summed(const std::vector<Image>& frames, const RainMattes& mattes) {
  double sum = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (std::size_t i = 0; i < frames[k].values.size(); ++i) {
      const double a = mattes.mattes[k].values[i / 3];
      const double shown = (1 - a) * mattes.background.values[i] + a * mattes.colours[k][i % 3];
      sum += std::pow(frames[k].values[i] - shown, 2);
    }
  }
  return sum;
}

TEST(RainMattes, ReportTheEnergyOfWhatTheyReturn) {
  const RainClip rain = rain_clip({.width = 40, .height = 48});
  const RainMattes mattes = found(rain.frames);
  // Floats are off by 2^-25 of themselves, residuals of some 0.01 so by 1e-5 of them.
  const double data = mattes.iterations.back().colours.data;
  EXPECT_NEAR(directly_summed(rain.frames, mattes), data, 1e-4 * data);
  double background = 0;
  const auto squared = [&](int x0, int y0, int x1, int y1, int c) {
    const Image& s = mattes.background;
    if (x1 < s.width && y1 < s.height) background += std::pow(s.at(x1, y1, c) - s.at(x0, y0, c), 2);
  };
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (int c = 0; c < 3; ++c) squared(x, y, x + 1, y, c), squared(x, y, x, y + 1, c);
    }
  }
  const double reported = mattes.iterations.back().colours.background;
  EXPECT_NEAR(background / 20, reported, 1e-4 * reported);
}

TEST(RainMattes, AreTheSameBytesForAnyNumberOfThreads) {
  const RainClip rain = rain_clip({.width = 40, .height = 48});
  const RainMattes many = found(rain.frames, {.iterations = 3});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const RainMattes single = found(rain.frames, {.iterations = 3});
  EXPECT_EQ(many.background.values, single.background.values);
  for (std::size_t k = 0; k < many.mattes.size(); ++k)
    EXPECT_EQ(many.mattes[k].values, single.mattes[k].values) << "frame " << k;
}

TEST(RainMattes, DoNotHangOnTheUnitOfLight) {
  const RainClip rain = rain_clip({.width = 40, .height = 48});
  const RainMattes plain = found(rain.frames, {.iterations = 4});
  for (const double unit : {std::ldexp(1.0, 120), std::ldexp(1.0, -100)}) {
    std::vector<Image> frames = rain.frames;
    for (Image& frame : frames) {
      for (float& value : frame.values) value = static_cast<float>(value * unit);
    }
    const RainMattes scaled = found(frames, {.iterations = 4, .white = unit});
    EXPECT_EQ(scaled.lean_deg, plain.lean_deg);  // powers of 2: not a bit of a matte changes
    for (std::size_t k = 0; k < frames.size(); ++k)
      EXPECT_EQ(scaled.mattes[k].values, plain.mattes[k].values) << unit << " frame " << k;
  }
}

std::vector<Image> repeated(const Image& picture) {
  return std::vector<Image>(5, picture);
}

void expect_finite(const RainMattes& mattes, const char* what) {
  for (const float value : mattes.background.values) ASSERT_TRUE(std::isfinite(value)) << what;
  for (const Image& matte : mattes.mattes) {
    for (const float a : matte.values) ASSERT_TRUE(a >= 0 && a <= 1) << what << ": " << a;
  }
  for (const MatteIteration& step : mattes.iterations)
    ASSERT_TRUE(std::isfinite(step.colours.total())) << what;
}

TEST(RainMattes, OfClipsWithoutRainAreEmpty) {
  Image even = make_image(24, 20, 3), black = even;
  std::fill(even.values.begin(), even.values.end(), 0.4f);
  for (const Image& picture : {black, even}) {
    const RainMattes mattes = found(repeated(picture));
    expect_finite(mattes, "even");
    EXPECT_EQ(mattes.background.values, picture.values);
    for (const Image& matte : mattes.mattes) EXPECT_EQ(matte_rms({matte}, {make_image(24, 20)}), 0);
    EXPECT_EQ(mattes.lean_deg, 0);
  }
  // lambda smooths edges of 0.2 by up to 4 lambda / (5 frames + ..) = 4 % of them, 0.008 there.
  const Image texture = textured_background(48, 48, false);
  const RainMattes mattes = found(repeated(texture));
  expect_finite(mattes, "texture");
  EXPECT_GE(psnr_db(mattes.background, texture), -20 * std::log10(0.008));
}

TEST(RainMattes, OfSaturatedHugeAndGreyRainAreFiniteAndWithinTheirBounds) {
  const RainClip rain = rain_clip({.width = 32, .height = 32});
  std::vector<Image> white = rain.frames, huge = rain.frames, grey;
  for (Image& frame : white) {
    for (float& value : frame.values) value = value > 0.5f ? 1.0f : value;
  }
  for (Image& frame : huge) {
    for (float& value : frame.values) value = value > 0.5f ? 3e38f : value * 1e38f;
  }
  for (const Image& matte : rain.mattes) grey.push_back(matte);
  expect_finite(found(white), "saturated");
  expect_finite(found(huge), "huge, in units of 1");
  expect_finite(found(grey), "grey");
  expect_finite(found(rain.frames, {.lambda = 0, .mu = 0}), "nothing but data");
  expect_finite(found(repeated(rain.frames[0])), "rain that stands still");
}

TEST(RainMattes, RefuseWhatIsNoClip) {
  const auto message = [](const std::vector<Image>& frames, const MatteSettings& settings = {}) {
    return message_of([&] { found(frames, settings); });
  };
  const std::vector<Image> good(3, make_image(16, 16));
  EXPECT_EQ(message({good[0], good[1]}),
            "rain_mattes: 2 frames; expected at least 3, for a median");
  EXPECT_EQ(message(std::vector<Image>(3, make_image(15, 16, 3))),
            "rain_mattes: 15 x 16 pixels of 3 channels; expected at least 16 x 16 of 1 or 3");
  EXPECT_EQ(message({good[0], good[1], make_image(16, 17)}),
            "rain_mattes: frame 2 has 16 x 17 pixels of 1 channels; expected those of the first");
  std::vector<Image> bad = good;
  for (const float value : {std::nanf(""), -1.0f, std::numeric_limits<float>::infinity()}) {
    bad[1].values[7] = value;
    EXPECT_NE(message(bad).find("frame 1 has a value"), std::string::npos) << value;
  }
  EXPECT_EQ(message(good, {.lambda = -1}), "rain_mattes: lambda = -1; expected a number >= 0");
  EXPECT_EQ(message(good, {.mu = std::nan("")}), "rain_mattes: mu = nan; expected a number >= 0");
  EXPECT_EQ(message(good, {.iterations = 0}), "rain_mattes: iterations = 0; expected at least 1");
  EXPECT_EQ(message(good, {.white = 0}), "rain_mattes: white = 0; expected a number > 0");
}

// a = p x + q y.
Eigen::VectorXd ramp(int width, int height, double p, double q) {
  Eigen::VectorXd values(width * height);
  for (int i = 0; i < width * height; ++i) values[i] = p * (i % width) + q * (i / width);
  return values;
}

TEST(MatteSystems, MeasureTheSlopesOfARamp) {
  constexpr int w = 9, h = 7;
  const double p = 0.3, q = -0.2;
  const Eigen::VectorXd a = ramp(w, h, p, q);
  EXPECT_NEAR(quadratic(gradient_energy(w, h), a), p * p * (w - 1) * h + q * q * w * (h - 1),
              1e-12);
  for (const double lean_deg : {0.0, 20.0, -20.0, 44.0, 46.0, 75.0, -75.0, 90.0, -90.0}) {
    // Steps of a row leave out the last row, and a column at the side to which the fall drifts.
    const double lean = lean_deg * std::numbers::pi / 180;
    const bool by_rows = std::abs(lean_deg) < 45;
    const bool straight = lean_deg == 0 || std::abs(lean_deg) == 90;
    const double drift = straight ? 0 : 1;
    const double steps = by_rows ? (w - drift) * (h - 1) : (w - 1) * (h - drift);
    const double slope = p * std::sin(lean) + q * std::cos(lean);
    EXPECT_NEAR(quadratic(fall_energy(w, h, lean_deg), a), slope * slope * steps, 1e-12)
        << lean_deg << " deg";
  }
}

TEST(MatteSystems, DescendToWhereNoFreeValueHasASlope) {
  std::mt19937 random(5);
  constexpr int n = 30;
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(
        n, n, [&](Eigen::Index, Eigen::Index) { return uniform(random, -1, 1); });
    const SparseMatrix a = Eigen::MatrixXd(m.transpose() * m / n).sparseView();
    const Eigen::VectorXd b =
        Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index) { return uniform(random, -1, 1); });
    Eigen::VectorXd x = Eigen::VectorXd::Constant(n, 0.5);
    descend(a, b, {0, 1}, 200, x);
    const Eigen::VectorXd slope = a * x - b;
    for (int i = 0; i < n; ++i) {
      ASSERT_TRUE(x[i] >= 0 && x[i] <= 1);
      // Steps end at 1e-3 of the gradient; 200 of them leave what rounding does.
      EXPECT_TRUE(x[i] == 0 || slope[i] < 1e-8) << "trial " << trial << ", value " << i;
      EXPECT_TRUE(x[i] == 1 || slope[i] > -1e-8) << "trial " << trial << ", value " << i;
    }
  }
}

TEST(FallDirection, IsThatOfTheStreaks) {
  for (const double lean_deg : {0.0, 7.0, -14.0, 30.0, -44.0, 60.0, 85.0}) {
    std::mt19937 random(9);
    Image picture = make_image(96, 80);
    for (int i = 0; i < 12; ++i)
      lay_streak(picture, uniform(random, 15, 80), uniform(random, 15, 65), lean_deg, {}, random);
    const std::optional<double> lean = fall_lean_deg({picture});
    ASSERT_TRUE(lean) << lean_deg;
    // A streak of 2 x 17 px spreads its power over +- 1 / 34 cycles per pixel about the line, 6
    // degrees at 0.3; twelve of them give the middle to a third of that.
    EXPECT_NEAR(*lean, lean_deg, 2);
  }
}

TEST(FallDirection, IsNoneWhereNothingLeans) {
  Image even = make_image(32, 32), noise = even;
  std::mt19937 random(2);
  for (float& value : noise.values) value = static_cast<float>(uniform(random, 0, 1));
  EXPECT_FALSE(fall_lean_deg({even}));
  EXPECT_FALSE(fall_lean_deg({noise, noise}));
}

}  // namespace
}  // namespace pluvia
