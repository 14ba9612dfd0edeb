#include "validate/batch_judge.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

constexpr std::size_t pixels = 4000;

std::vector<double> truth() {
  std::vector<double> values;
  for (std::size_t i = 0; i < pixels; ++i) {
    values.push_back(2 + std::sin(0.01 * static_cast<double>(i)));
  }
  return values;
}

// Truth plus Gaussian noise of this deviation, independent in every pixel and batch.
std::vector<std::vector<double>> noisy(std::size_t count, double deviation, int seed) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  std::normal_distribution<double> noise(0, deviation);
  std::vector<std::vector<double>> batches(count, truth());
  for (auto& batch : batches) {
    for (double& v : batch) v += noise(random);
  }
  return batches;
}

// Truth off by this much, up in one pixel and down in the next.
std::vector<double> off_by(double error) {
  std::vector<double> values = truth();
  for (std::size_t i = 0; i < pixels; ++i) values[i] += i % 2 == 0 ? error : -error;
  return values;
}

double mean_square_of_truth() {
  double sum = 0;
  for (const double v : truth()) sum += v * v / pixels;
  return sum;
}

TEST(BatchJudge, FindsAnErrorUnderTenTimesItsOwnNoise) {
  // Noise 0.5, error 0.05, 16 batches: without error the square's deviation would be 0.25 (2 / (16
  // 15) / 4000)^(1/2) = 0.00036 against 0.0025.
  const double expected = 0.05 * 0.05 / mean_square_of_truth();
  const BatchVerdict verdict = judge_picture(off_by(0.05), noisy(16, 0.5, 1));
  EXPECT_NEAR(verdict.square, expected, 4 * verdict.standard_error);
  EXPECT_LT(4 * verdict.standard_error, expected) << "the comparison is too blunt";
}

TEST(BatchJudge, AgreesWithTheMeanLessItsVariance) {
  // sum ((f - b)^2 - var b) / sum (b^2 - var b), algebraically the same: to rounding.
  const auto batches = noisy(5, 0.3, 2);
  const std::vector<double> picture = off_by(0.1);
  double error = 0, size = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    std::vector<double> values;
    for (const auto& batch : batches) values.push_back(batch[i]);
    const MeanAndError b = mean_and_error(values);
    const double variance = b.standard_error * b.standard_error;
    error += std::pow(picture[i] - b.mean, 2) - variance;
    size += b.mean * b.mean - variance;
  }
  EXPECT_NEAR(judge_picture(picture, batches).square, error / size, 1e-12);
}

TEST(BatchJudge, StandardErrorIsTheJackknife) {
  // By leaving out each of 5 batches in turn: to rounding.
  const auto batches = noisy(5, 0.3, 4);
  std::vector<double> squares;
  for (std::size_t k = 0; k < batches.size(); ++k) {
    auto rest = batches;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
    squares.push_back(judge_picture(off_by(0.1), rest).square);
  }
  EXPECT_NEAR(judge_picture(off_by(0.1), batches).standard_error,
              4 * mean_and_error(squares).standard_error, 1e-12);
}

// Mean of the verdicts' own standard errors over the spread of 100 verdicts, each of 8 batches.
double claimed_over_true_error(double error, double noise) {
  std::vector<double> squares, errors;
  for (int seed = 10; seed < 110; ++seed) {
    const BatchVerdict verdict = judge_picture(off_by(error), noisy(8, noise, seed));
    squares.push_back(verdict.square);
    errors.push_back(verdict.standard_error);
  }
  // Their mean is known to a tenth of their spread: 4 deviations.
  const double spread = 10 * mean_and_error(squares).standard_error;
  EXPECT_NEAR(mean_and_error(squares).mean, error * error / mean_square_of_truth(), 0.4 * spread);
  return mean_and_error(errors).mean / spread;
}

TEST(BatchJudge, StandardErrorIsTheSpreadOverManyTrials) {
  // The spread is known to 1 / 200^(1/2) = 7 %; the mean of the standard errors is better known,
  // but lies below their root mean square, by 1 / (4 7) = 3.6 %: 4 deviations are 28 %, and that.
  EXPECT_NEAR(claimed_over_true_error(1, 0.1), 1, 0.32);
  // Nothing but noise: too large by (2 7 / 6)^(1/2) = 1.53.
  EXPECT_NEAR(claimed_over_true_error(0, 1) / 1.53, 1, 0.32);
}

TEST(BatchJudge, TellsTheBatchesOwnError) {
  // Variance 0.25 from 7 x 4000 degrees of freedom: deviation 2^(1/2) / 28000^(1/2) = 0.85 %.
  for (const double error : {0.0, 1.0}) {
    const BatchVerdict verdict = judge_picture(off_by(error), noisy(8, 0.5, 3));
    EXPECT_NEAR(verdict.batch_square * mean_square_of_truth(), 0.25, 4 * 0.0085 * 0.25)
        << "of a picture off by " << error;
  }
}

TEST(BatchJudge, SaysNothingOfALightTheBatchesDoNotShare) {
  const std::vector<std::vector<double>> dark(4, std::vector<double>(4, 0.0));
  std::vector<std::vector<double>> apart = dark;
  for (std::size_t k = 0; k < 4; ++k) apart[k][k] = 0.1 + 0.7 * static_cast<double>(k);
  for (const auto& batches : {dark, apart}) {
    const BatchVerdict verdict = judge_picture({1, 2, 3, 4}, batches);
    EXPECT_EQ(verdict.square, 0);
    EXPECT_EQ(verdict.standard_error, 0);
    EXPECT_EQ(verdict.batch_square, 0);
  }
}

TEST(BatchJudge, RowsAndQuantiles) {
  EXPECT_EQ(row_sums({1, 2, 3, 4, 5, 6}, 3), (std::vector<double>{6, 15}));
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.9), 9);
  EXPECT_EQ(quantile({5}, 1), 5);
}

}  // namespace
}  // namespace pluvia
