#include "validate/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

using Color = std::array<double, 3>;

Image uniform(int width, int height, float r, float g, float b) {
  Image image = make_image(width, height, 3);
  for (std::size_t i = 0; i < image.values.size(); i += 3) {
    image.values[i] = r, image.values[i + 1] = g, image.values[i + 2] = b;
  }
  return image;
}

Image noise(int width, int height, unsigned seed) {
  Image image = make_image(width, height, 3);
  std::mt19937 random(seed);
  for (float& v : image.values) v = static_cast<float>(random() % 1000) / 999;
  return image;
}

// The papers written down pixel by pixel: kernels over the square instead of one after the other
// direction, YCxCz with its factors, and the published matrix instead of one from chromaticities.

Color xyz_of_white(const Color& rgb) {
  const auto [r, g, b] = rgb;
  return {(10135552 * r + 8788810 * g + 4435075 * b) / 23359437,
          (2613072 * r + 8788810 * g + 887015 * b) / 12288897,
          (1425312 * r + 8788810 * g + 70074185 * b) / 80288307};
}

Color ycxcz(const Color& rgb) {
  const auto [x, y, z] = xyz_of_white(rgb);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Color rgb_of_ycxcz(const Color& c) {
  const double y = (c[0] + 16) / 116;
  const double X = 0.950428545 * (y + c[1] / 500), Z = 1.088900371 * (y - c[2] / 200);
  return {3.241003275 * X - 1.537398934 * y - 0.498615861 * Z,
          -0.969224334 * X + 1.875930071 * y + 0.041554224 * Z,
          0.055639423 * X - 0.204011202 * y + 1.057148933 * Z};
}

Color hunt(const Color& rgb) {
  Color f = xyz_of_white(rgb);
  for (double& t : f) {
    t = t > 216.0 / 24389 ? std::pow(t, 1.0 / 3) : t * 841 / 108 + 4.0 / 29;
  }
  const double l = 116 * f[1] - 16;
  return {l, 0.01 * l * 500 * (f[0] - f[1]), 0.01 * l * 200 * (f[1] - f[2])};
}

double hyab(const Color& a, const Color& b) {
  return std::abs(a[0] - b[0]) + std::sqrt(std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2));
}

Color at(const Image& image, int x, int y) {
  x = std::clamp(x, 0, image.width - 1), y = std::clamp(y, 0, image.height - 1);
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

using Weight = std::function<double(int, int)>;

// sum of weight * channel of YCxCz around (x, y), positive and negative weights over their own
// sums.
double weighted(const Image& image, int x, int y, std::size_t channel, int radius,
                const Weight& weight) {
  double plus = 0, minus = 0, of_plus = 0, of_minus = 0;
  for (int v = -radius; v <= radius; ++v) {
    for (int u = -radius; u <= radius; ++u) {
      const double w = weight(u, v), value = ycxcz(at(image, x + u, y + v))[channel];
      (w > 0 ? plus : minus) += w * value;
      (w > 0 ? of_plus : of_minus) += std::abs(w);
    }
  }
  return plus / of_plus + (of_minus > 0 ? minus / of_minus : 0);
}

Color blurred_color(const Image& image, int x, int y, double ppd) {
  const double pi = std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
  const auto term = [&](double a, double b, int u, int v) {
    return a * std::sqrt(pi / b) * std::exp(-pi * pi * (u * u + v * v) / (ppd * ppd * b));
  };
  const Weight eye[3] = {
      [&](int u, int v) { return term(1, 0.0047, u, v); },
      [&](int u, int v) { return term(1, 0.0053, u, v); },
      [&](int u, int v) { return term(34.1, 0.04, u, v) + term(13.5, 0.025, u, v); }};
  Color c = {};
  for (std::size_t i = 0; i < 3; ++i) c[i] = weighted(image, x, y, i, radius, eye[i]);
  c = rgb_of_ycxcz(c);
  for (double& v : c) v = std::clamp(v, 0.0, 1.0);
  return hunt(c);
}

double feature(const Image& image, int x, int y, double ppd, bool point) {
  const double s = 0.5 * 0.082 * ppd;
  const Weight across = [&](int u, int v) {
    return (point ? u * u / (s * s) - 1 : -u) * std::exp(-(u * u + v * v) / (2 * s * s));
  };
  const int radius = static_cast<int>(std::ceil(3 * s));
  // Over luminance (Y + 16) / 116; the offset falls out of weights that sum to zero.
  const double gx = weighted(image, x, y, 0, radius, across) / 116;
  const double gy =
      weighted(image, x, y, 0, radius, [&](int u, int v) { return across(v, u); }) / 116;
  return std::sqrt(gx * gx + gy * gy);
}

double flip_at(const Image& a, const Image& b, int x, int y, double ppd) {
  const double most = std::pow(hyab(hunt({0, 1, 0}), hunt({0, 0, 1})), 0.7);
  const double e = std::pow(hyab(blurred_color(a, x, y, ppd), blurred_color(b, x, y, ppd)), 0.7);
  const double color =
      e < 0.4 * most ? 0.95 / (0.4 * most) * e : 0.95 + 0.05 * (e - 0.4 * most) / (0.6 * most);
  double f = 0;
  for (const bool point : {false, true}) {
    f = std::max(f, std::abs(feature(a, x, y, ppd, point) - feature(b, x, y, ppd, point)));
  }
  return std::pow(color, 1 - std::sqrt(f / std::sqrt(2.0)));
}

TEST(Flip, IsThePapersFormulasPixelByPixel) {
  // The published inverse matrix has nine digits, the power 0.7 and cube roots do not enlarge that
  // by more than a thousand for errors of this size; the map is float (6e-8).
  for (const double ppd : {20.0, 45.0}) {
    for (const auto& [width, height] : {std::pair{14, 11}, {1, 1}, {1, 9}, {9, 1}, {2, 3}}) {
      const Image a = noise(width, height, 1), b = noise(width, height, 2);
      const FlipError error = ldr_flip(a, b, {.pixels_per_degree = ppd});
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          EXPECT_NEAR(error.map.at(x, y), flip_at(a, b, x, y, ppd), 1e-6)
              << x << ' ' << y << " of " << width << " x " << height << " at " << ppd;
        }
      }
    }
  }
}

TEST(Flip, OfPlainColorsIsTheirDistance) {
  const auto between = [](const Image& a, const Image& b) { return ldr_flip(a, b).mean; };
  const Image black = uniform(8, 5, 0, 0, 0), white = uniform(8, 5, 1, 1, 1);
  const Image green = uniform(8, 5, 0, 1, 0), blue = uniform(8, 5, 0, 0, 1);
  // Green and blue are the farthest pair by definition. Black to white: a distance of 100 in L*,
  // 100^0.7 = 25.119 of 41.27 = 203.3^0.7 (green to blue): 0.95 + 0.05 (25.119 - 16.51) / 24.76.
  // Published to three digits: 0.967 and 1.
  EXPECT_NEAR(between(green, blue), 1, 1e-12);
  EXPECT_NEAR(between(black, white), 0.9674, 5e-5);
  EXPECT_EQ(between(white, white), 0);
}

TEST(Flip, OfAPictureWithItselfIsZeroAndOtherwiseSymmetric) {
  const Image a = noise(40, 30, 3), b = noise(40, 30, 4);
  const FlipError none = ldr_flip(a, a), error = ldr_flip(a, b);
  EXPECT_EQ(none.largest, 0);
  EXPECT_EQ(none.weighted_median, 0);
  EXPECT_EQ(error.map.values, ldr_flip(b, a).map.values);
  EXPECT_GT(error.mean, 0.01);
}

TEST(Flip, OfAThinLineMovedByAPixelIsSmallButSeen) {
  const auto line = [](int column) {
    Image image = uniform(64, 48, 0.2f, 0.2f, 0.2f);
    for (int y = 0; y < 48; ++y) {
      for (int c = 0; c < 3; ++c) image.at(column, y, c) = 0.8f;
    }
    return image;
  };
  const Image none = uniform(64, 48, 0.2f, 0.2f, 0.2f);
  const FlipError moved = ldr_flip(line(32), line(33)), gone = ldr_flip(line(32), none);
  const FlipError far = ldr_flip(line(32), line(52));
  EXPECT_GT(moved.mean, 0.001);
  // Two lines apart are two lines missing; side by side they are less than one.
  EXPECT_LT(moved.mean, gone.mean);
  EXPECT_NEAR(far.mean, 2 * gone.mean, 0.01 * gone.mean);
  // Rows are alike, and beyond the reach of the filters, 10 pixels, nothing is seen.
  EXPECT_EQ(moved.map.at(0, 20), 0);
  EXPECT_EQ(moved.map.at(32, 3), moved.map.at(32, 40));
}

TEST(Flip, PercentilesAreWeightedByTheErrors) {
  const FlipError error = ldr_flip(noise(31, 17, 5), noise(31, 17, 6), {.pixels_per_degree = 3});
  double sum = 0;
  for (const float v : error.map.values) sum += v;
  EXPECT_NEAR(error.mean, sum / (31 * 17), 1e-7);
  const auto [least, largest] =
      std::minmax_element(error.map.values.begin(), error.map.values.end());
  EXPECT_FLOAT_EQ(static_cast<float>(error.least), *least);
  EXPECT_FLOAT_EQ(static_cast<float>(error.largest), *largest);
  for (const auto& [p, value] : {std::pair{0.25, error.weighted_first_quartile},
                                 {0.5, error.weighted_median},
                                 {0.75, error.weighted_third_quartile}}) {
    double up_to = 0;
    for (const float v : error.map.values) up_to += v <= static_cast<float>(value) ? v : 0;
    // The sum passes p within the one pixel that is the percentile.
    EXPECT_GE(up_to, (p - 1e-6) * sum);
    EXPECT_LE(up_to - value, (p + 1e-6) * sum);
  }
}

Image scaled(Image image, float factor) {
  for (float& v : image.values) v *= factor;
  return image;
}

// 0.001 .. 30 cd/m^2 in smooth steps.
Image bright_noise(unsigned seed) {
  Image image = noise(24, 18, seed);
  for (float& v : image.values) v = 0.001f * std::pow(30000.0f, v);
  return image;
}

TEST(HdrFlip, DoesNotHangOnACommonExposure) {
  const Image a = bright_noise(7), b = bright_noise(8);
  const HdrFlipError one = hdr_flip(a, b);
  EXPECT_GT(one.error.mean, 0.1);
  for (const float factor : {1.0f / 1024, 4096.0f}) {  // powers of two: pictures scale exactly
    const HdrFlipError other = hdr_flip(scaled(a, factor), scaled(b, factor));
    EXPECT_NEAR(other.error.mean, one.error.mean, 1e-9);
    EXPECT_NEAR(other.start_exposure_stops + std::log2(factor), one.start_exposure_stops, 1e-9);
    EXPECT_EQ(other.exposures, one.exposures);
  }
}

TEST(HdrFlip, SpansFromTheBrightestPixelToTheMedian) {
  // Luminances 1 (eleven pixels), 4 (nine) and 64 (one): start = stop - 6; x at 0.85 of the curve.
  Image a = uniform(7, 3, 1, 1, 1);
  for (int i = 0; i < 10; ++i) {
    for (int c = 0; c < 3; ++c) a.at(i % 7, i / 7, c) = i == 0 ? 64.0f : 4.0f;
  }
  const HdrFlipError error = hdr_flip(a, a);
  EXPECT_NEAR(error.stop_exposure_stops - error.start_exposure_stops, 6, 1e-12);
  EXPECT_EQ(error.exposures, 6);
  EXPECT_EQ(error.error.largest, 0);
  const double x = 0.6 * std::exp2(error.stop_exposure_stops);
  EXPECT_NEAR(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.85, 1e-12);
}

TEST(HdrFlip, IsTheLargestFlipOfTheToneMappedPictures) {
  const Image a = bright_noise(9), b = bright_noise(10);
  Image largest = make_image(24, 18);
  for (const double stops : {-4.0, -1.5, 1.0}) {
    Image mapped[2] = {a, b};
    for (Image& image : mapped) {
      for (float& v : image.values) {
        const double x = 0.6 * std::exp2(stops) * v;
        const double curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
        v = static_cast<float>(std::min(1.0, curve));
      }
    }
    const Image map = ldr_flip(mapped[0], mapped[1]).map;
    for (std::size_t i = 0; i < map.values.size(); ++i) {
      largest.values[i] = std::max(largest.values[i], map.values[i]);
    }
  }
  // From -4 to 1 are 5 stops: five exposures, 1.25 apart; -1.5 is the third.
  const HdrFlipError error = hdr_flip(a, b, {.start_exposure_stops = -4, .stop_exposure_stops = 1});
  EXPECT_EQ(error.exposures, 5);
  double more = 0;
  for (std::size_t i = 0; i < largest.values.size(); ++i) {
    EXPECT_GE(error.error.map.values[i], largest.values[i] - 1e-5f);  // pictures in float: 6e-8^0.7
    more += error.error.map.values[i] - largest.values[i];
  }
  EXPECT_GT(more, 0);
  const HdrFlipError turned =
      hdr_flip(b, a, {.start_exposure_stops = -4, .stop_exposure_stops = 1});
  EXPECT_EQ(turned.error.map.values, error.error.map.values);
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "nothing was thrown";
}

TEST(Flip, RefusesWhatHasNoAnswerInOneLine) {
  const Image white = uniform(4, 3, 1, 1, 1), black = uniform(4, 3, 0, 0, 0);
  EXPECT_EQ(refusal([&] { ldr_flip(white, uniform(3, 4, 1, 1, 1)); }),
            "ldr_flip: pictures of 4 x 3 x 3 and 3 x 4 x 3; expected equal sizes > 0, 3 channels");
  EXPECT_EQ(refusal([&] { hdr_flip({}, {}); }),
            "hdr_flip: pictures of 0 x 0 x 1 and 0 x 0 x 1; expected equal sizes > 0, 3 channels");
  EXPECT_EQ(refusal([&] { ldr_flip(white, uniform(4, 3, 1, 1.5f, 1)); }),
            "ldr_flip: value 1.5; expected 0 .. 1");
  EXPECT_EQ(refusal([&] { hdr_flip(white, uniform(4, 3, -1, 1, 1)); }),
            "hdr_flip: value -1; expected 0 .. 3.4028235e+38");
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_THROW(ldr_flip(white, uniform(4, 3, 1, bad, 1)), std::runtime_error);
    EXPECT_THROW(hdr_flip(uniform(4, 3, 1, bad, 1), white), std::runtime_error);
  }
  EXPECT_EQ(refusal([&] { ldr_flip(white, white, {.pixels_per_degree = 0.5}); }),
            "ldr_flip: pixels_per_degree = 0.5; expected 1 .. 1000");
  EXPECT_EQ(refusal([&] { hdr_flip(black, white); }),
            "hdr_flip: the reference's largest luminance is 0; expected > 0, or given exposures");
  EXPECT_EQ(refusal([&] {
              hdr_flip(white, white, {.start_exposure_stops = 3, .stop_exposure_stops = 1});
            }),
            "hdr_flip: exposures from 3 to 1 stops; expected start <= stop within -300 .. 300");
}

}  // namespace
}  // namespace pluvia
