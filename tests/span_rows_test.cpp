#include "atlas/span_rows.h"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

const ShardRecord record = {.path_top_row = 16, .path_bottom_row = 1016};

TEST(SpanRows, AnExposureIsItsShareOfThePath) {
  const SpanRows whole = span_rows(record, 0.05, 0, 0.05);
  EXPECT_EQ(whole.first_row, 16);
  EXPECT_DOUBLE_EQ(whole.last_row, 1016);
  EXPECT_EQ(whole.gain, 1);
  const SpanRows part = span_rows(record, 0.05, 0.01, 0.02);
  EXPECT_DOUBLE_EQ(part.first_row, 216);
  EXPECT_DOUBLE_EQ(part.last_row, 616);
  EXPECT_DOUBLE_EQ(part.gain, 2.5);
}

TEST(SpanRows, FluxOfAllExposuresOfASpanIsThatOfTheSpan) {
  // Rows of a picture of constant brightness 1: every exposure's mean times its time adds up.
  double flux = 0;
  for (int i = 0; i < 7; ++i) {
    const SpanRows rows = span_rows(record, 1, i / 7.0, 1 / 7.0);
    flux += (rows.last_row - rows.first_row) * rows.gain / 7;
  }
  EXPECT_NEAR(flux, 1000, 1e-9);
}

TEST(SpanRows, TheShortestAndLongestExposuresAreServed) {
  const SpanRows instant = span_rows(record, 1, 0.5, 1e-6);
  EXPECT_NEAR(instant.last_row - instant.first_row, 1e-3, 1e-9);
  EXPECT_DOUBLE_EQ(instant.gain, 1e6);
  EXPECT_DOUBLE_EQ(span_rows(record, 1, 0, 1).last_row, 1016);
  EXPECT_NO_THROW(span_rows(record, 0.05, 0.05 - 1.0 / 60, 1.0 / 60));  // rounding of the sum
}

TEST(SpanRows, WhatTheSpanDoesNotHoldIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double wrong[][3] = {{0.05, -0.01, 0.02}, {0.05, 0.04, 0.02}, {0.05, 0, 0},
                             {0.05, 0, -1},       {0, 0, 0.01},       {0.05, nan, 0.01},
                             {0.05, 0, nan},      {nan, 0, 0.01}};
  for (const auto& [span, t0, exposure] : wrong) {
    EXPECT_THROW(span_rows(record, span, t0, exposure), std::invalid_argument)
        << span << ", " << t0 << ", " << exposure;
  }
}

}  // namespace
}  // namespace pluvia
