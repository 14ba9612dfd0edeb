#include "tests/bench/batch_judge.h"

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

TEST(BatchJudge, FindsAnErrorUnderTwentyTimesItsOwnNoise) {
  // Noise 1, error 0.05, in 16 batches: the square's deviation is 2^(1/2) / 16 / 4000^(1/2) =
  // 0.0014 (error-free pixels) against 0.0025.
  const double expected = 0.05 * 0.05 / mean_square_of_truth();
  const BatchVerdict verdict = judge_picture(off_by(0.05), noisy(16, 1, 1));
  EXPECT_NEAR(verdict.square, expected, 4 * verdict.standard_error);
  // Relative spread of a standard error from 16 values is 1 / 30^(1/2) = 0.18 if they were
  // Gaussian.
  EXPECT_NEAR(verdict.standard_error * mean_square_of_truth(), 0.0014, 0.0014 * 4 * 0.18);
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

TEST(BatchJudge, StandardErrorIsTheSpreadOverManyTrials) {
  // The spread of 100 verdicts is known to 1 / 200^(1/2) = 7 %; the mean of their own standard
  // errors is better known: 4 deviations are 28 %.
  std::vector<double> squares, errors;
  for (int seed = 10; seed < 110; ++seed) {
    const BatchVerdict verdict = judge_picture(off_by(0.05), noisy(8, 0.5, seed));
    squares.push_back(verdict.square);
    errors.push_back(verdict.standard_error);
  }
  const double spread = 10 * mean_and_error(squares).standard_error;
  EXPECT_NEAR(mean_and_error(errors).mean / spread, 1, 0.28);
  // Their mean is known to a tenth of the spread: 4 deviations.
  EXPECT_NEAR(mean_and_error(squares).mean, 0.0025 / mean_square_of_truth(), 0.4 * spread);
}

TEST(BatchJudge, TellsTheBatchesOwnError) {
  // Variance 0.25 from 7 x 4000 degrees of freedom: deviation 2^(1/2) / 28000^(1/2) = 0.85 %.
  const BatchVerdict verdict = judge_picture(off_by(0), noisy(8, 0.5, 3));
  EXPECT_NEAR(verdict.batch_square * mean_square_of_truth(), 0.25, 4 * 0.0085 * 0.25);
  EXPECT_NEAR(verdict.square, 0, 4 * verdict.standard_error);
}

TEST(BatchJudge, SaysNothingWhereThereIsNoLight) {
  const std::vector<std::vector<double>> dark(3, std::vector<double>(4, 0.0));
  const BatchVerdict verdict = judge_picture({1, 2, 3, 4}, dark);
  EXPECT_EQ(verdict.square, 0);
  EXPECT_EQ(verdict.standard_error, 0);
  EXPECT_EQ(verdict.batch_square, 0);
}

TEST(BatchJudge, RowsAndQuantiles) {
  EXPECT_EQ(row_sums({1, 2, 3, 4, 5, 6}, 3), (std::vector<double>{6, 15}));
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.9), 9);
  EXPECT_EQ(quantile({5}, 1), 5);
}

}  // namespace
}  // namespace pluvia
