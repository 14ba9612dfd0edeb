#include "validate/ssim.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

Image uniform(int width, int height, float value) {
  Image image = make_image(width, height);
  for (float& v : image.values) v = value;
  return image;
}

Image noise(int width, int height, unsigned seed) {
  Image image = make_image(width, height);
  std::mt19937 random(seed);
  for (float& v : image.values) v = static_cast<float>(random() % 1000) / 999;
  return image;
}

struct Terms {
  double l = 0, cs = 0;
};

// The paper written down: one square of weights, moments about the means.
Terms terms_at(const Image& a, const Image& b, int x, int y) {
  double weights = 0, m_a = 0, m_b = 0, s_a = 0, s_b = 0, s_ab = 0;
  const auto each = [&](const auto& add) {
    for (int v = -5; v <= 5; ++v) {
      for (int u = -5; u <= 5; ++u) {
        const int i = std::clamp(x + u, 0, a.width - 1), j = std::clamp(y + v, 0, a.height - 1);
        add(std::exp(-(u * u + v * v) / 4.5), a.at(i, j), b.at(i, j));
      }
    }
  };
  each([&](double w, double p, double q) { weights += w, m_a += w * p, m_b += w * q; });
  m_a /= weights, m_b /= weights;
  each([&](double w, double p, double q) {
    s_a += w / weights * (p - m_a) * (p - m_a);
    s_b += w / weights * (q - m_b) * (q - m_b);
    s_ab += w / weights * (p - m_a) * (q - m_b);
  });
  return {(2 * m_a * m_b + 1e-4) / (m_a * m_a + m_b * m_b + 1e-4),
          (2 * s_ab + 9e-4) / (s_a + s_b + 9e-4)};
}

double ssim_at(const Image& a, const Image& b, int x, int y) {
  const Terms terms = terms_at(a, b, x, y);
  return terms.l * terms.cs;
}

Image halved(const Image& image) {
  Image half = make_image(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      half.at(x, y) = (image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) +
                       image.at(2 * x, 2 * y + 1) + image.at(2 * x + 1, 2 * y + 1)) /
                      4;
    }
  }
  return half;
}

TEST(Ssim, OverScalesIsThePapersProduct) {
  Image a = noise(181, 176, 6), b = noise(181, 176, 7);
  for (std::size_t i = 0; i < b.values.size(); ++i) {  // alike, the less the finer
    b.values[i] = 0.7f * a.values[i] + 0.3f * b.values[i];
  }
  const double found = *ssim(a, b, 1).ms_ssim;
  double product = 1;
  for (const double weight : {0.0448, 0.2856, 0.3001, 0.2363, 0.1333}) {
    Terms mean;
    const double count = (a.width - 10) * (a.height - 10);
    for (int y = 5; y < a.height - 5; ++y) {
      for (int x = 5; x < a.width - 5; ++x) {
        const Terms terms = terms_at(a, b, x, y);
        mean.l += terms.l / count, mean.cs += terms.cs / count;
      }
    }
    product *= std::pow(mean.cs * (a.height < 12 ? mean.l : 1), weight);
    a = halved(a), b = halved(b);
  }
  EXPECT_LT(product, 0.95);
  EXPECT_NEAR(found, product, 1e-6);  // here the halves are floats
}

TEST(Ssim, IsThePapersFormulaPixelByPixel) {
  const Image a = noise(17, 13, 1), b = noise(17, 13, 2);
  const Ssim result = ssim(a, b, 1);
  double inside = 0;
  for (int y = 0; y < 13; ++y) {
    for (int x = 0; x < 17; ++x) {
      // The map is of floats about 1.
      EXPECT_NEAR(1 - result.map.at(x, y), ssim_at(a, b, x, y), 2e-7) << x << ' ' << y;
      if (x >= 5 && x < 12 && y >= 5 && y < 8) inside += ssim_at(a, b, x, y) / 21;
    }
  }
  EXPECT_NEAR(result.mean, inside, 2e-7);
  EXPECT_EQ(ssim(b, a, 1).map.values, result.map.values);
}

TEST(Ssim, OfAPictureWithItselfIsOne) {
  const Image a = noise(200, 180, 3);
  const Ssim result = ssim(a, a, 1);
  EXPECT_EQ(result.error.largest, 0);
  EXPECT_EQ(result.mean, 1);
  ASSERT_TRUE(result.ms_ssim.has_value());
  EXPECT_NEAR(*result.ms_ssim, 1, 1e-12);
}

TEST(Ssim, OfPlainPicturesIsTheirLuminanceTerm) {
  const double a = 0.2, b = 0.7, l = (2 * a * b + 1e-4) / (a * a + b * b + 1e-4);
  const Ssim result = ssim(uniform(176, 176, 0.2f), uniform(176, 176, 0.7f), 1);
  EXPECT_NEAR(result.mean, l, 1e-7);
  EXPECT_NEAR(*result.ms_ssim, std::pow(l, 0.1333), 1e-7);
  // Values and range times 255: the same.
  const Ssim bytes = ssim(uniform(176, 176, 51), uniform(176, 176, 178.5f), 255);
  EXPECT_NEAR(bytes.mean, l, 1e-7);
}

TEST(Ssim, OfABoardAgainstItsMeanLosesTheFinestScaleAlone) {
  // One-pixel squares of 0.5 +- 0.3: under the window their mean is 0.5 (the Gaussian leaves 2e-10
  // of the finest wave, its cut at 3.3 sigma 1e-3, squared), their variance 0.09, the covariance
  // with grey 0. Halved, both pictures are grey.
  Image board = make_image(192, 180);
  for (int y = 0; y < 180; ++y) {
    for (int x = 0; x < 192; ++x) board.at(x, y) = (x + y) % 2 == 0 ? 0.8f : 0.2f;
  }
  const Ssim result = ssim(board, uniform(192, 180, 0.5f), 1);
  const double cs = 9e-4 / (0.09 + 9e-4);
  EXPECT_NEAR(result.mean, cs, 1e-5);
  EXPECT_NEAR(*result.ms_ssim, std::pow(cs, 0.0448), 1e-4);
}

TEST(Ssim, OfANegativeIsBelowZeroAndOverScalesZero) {
  const Image a = noise(176, 180, 5);
  Image b = a;
  for (float& v : b.values) v = 1 - v;
  const Ssim result = ssim(a, b, 1);
  EXPECT_LT(result.mean, -0.9);
  EXPECT_EQ(*result.ms_ssim, 0);
}

TEST(Ssim, HasNoScalesForASmallPictureAndRefusesOneWithoutAWindow) {
  EXPECT_FALSE(ssim(noise(175, 300, 1), noise(175, 300, 2), 1).ms_ssim.has_value());
  EXPECT_THROW(ssim(noise(10, 30, 1), noise(10, 30, 1), 1), std::runtime_error);
  EXPECT_THROW(ssim(noise(30, 30, 1), noise(30, 31, 1), 1), std::runtime_error);
  EXPECT_THROW(ssim(noise(30, 30, 1), noise(30, 30, 1), 0), std::runtime_error);
  EXPECT_THROW(ssim(make_image(30, 30, 4), make_image(30, 30, 4), 1), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
