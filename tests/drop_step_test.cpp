// Drag and the way of one drop (raytrace/drop_step.h).
#include "raytrace/drop_step.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "oscillation/fall_speed.h"

namespace pluvia {
namespace {

const Eigen::Vector3d still(0, 0, 0);

Eigen::Vector3d after(Eigen::Vector3d v, const Eigen::Vector3d& wind, const Eigen::Vector3d& fall,
                      double time_s, int steps) {
  for (int i = 0; i < steps; ++i) v = dragged_m_s(v, wind, fall, time_s / steps);
  return v;
}

TEST(DropDrag, FromRestADropFallsByTheHyperbolicTangent) {
  // dw/dt = g - g w^2 / v^2, w(0) = 0: w = v tanh(g t / v).
  for (const double speed : {0.5, 2.0, 4.03, 9.1}) {
    const Eigen::Vector3d fall(0, 0, -speed);
    const double exact = speed * std::tanh(gravity_m_s2 * 0.3 / speed);
    const double coarse = std::abs(after(still, still, fall, 0.3, 16).z() + exact);
    const double fine = std::abs(after(still, still, fall, 0.3, 64).z() + exact);
    EXPECT_LT(fine, 1e-3 * speed);
    if (coarse > 1e-7) {
      EXPECT_NEAR(std::log(coarse / fine) / std::log(4), 2, 0.25) << speed;
    }
  }
}

TEST(DropDrag, TerminalSpeedIsKeptInAnyStep) {
  for (const double speed : {0.1, 4.03, 9.1}) {
    for (const double step_s : {1e-3, 1.0 / 120, 0.1, 10.0}) {
      const Eigen::Vector3d fall(0, 0, -speed), wind(7, -3, 1);
      EXPECT_LT((dragged_m_s(wind + fall, wind, fall, step_s) - wind - fall).norm(), 1e-13 * 10);
    }
  }
}

TEST(DropDrag, InAnEvenWindADropReachesTheWindAndItsTerminalFall) {
  for (const double speed : {2.0, 6.5, 9.1}) {
    const Eigen::Vector3d fall(0, 0, -speed), wind(10, 4, 0);
    // Near the end u - fall fades with g / v across the fall (and twice as fast along it): 8 s
    // leave exp(-8.6) of at most 11 m/s, for the slowest 1e-16 of it.
    const double left = 11 * std::exp(-gravity_m_s2 / speed * 8) * 3 + 1e-12;
    EXPECT_LT((after(fall, wind, fall, 8, 960) - wind - fall).norm(), left) << speed;
    EXPECT_LT((after(fall, wind, fall, 8, 80) - wind - fall).norm(), 2 * left) << speed;
  }
}

// The classical method of Runge and Kutta, 20,000 steps.
Eigen::Vector3d reference(Eigen::Vector3d v, const Eigen::Vector3d& wind,
                          const Eigen::Vector3d& fall, double time_s) {
  const auto change = [&](const Eigen::Vector3d& at) -> Eigen::Vector3d {
    const Eigen::Vector3d u = at - wind;
    return gravity_m_s2 * (fall.normalized() - u.norm() * u / fall.squaredNorm());
  };
  const double h = time_s / 20000;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d a = change(v), b = change(v + h / 2 * a), c = change(v + h / 2 * b);
    v += h / 6 * (a + 2 * b + 2 * c + change(v + h * c));
  }
  return v;
}

TEST(DropDrag, ItsErrorFallsWithTheSquareOfTheStep) {
  const Eigen::Vector3d fall(0, 0, -6.5), wind(15, -4, 3), begin(-2, 1, -5);
  const Eigen::Vector3d exact = reference(begin, wind, fall, 0.5);
  const double coarse = (after(begin, wind, fall, 0.5, 50) - exact).norm();
  const double fine = (after(begin, wind, fall, 0.5, 100) - exact).norm();
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
}

TEST(DropDrag, ItIsStableInAnyGust) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(-1, 1);
  for (const double speed : {0.25, 1.0, 4.0, 9.1}) {
    for (const double step_s : {1.0 / 120, 0.1}) {
      const Eigen::Vector3d fall(0, 0, -speed);
      Eigen::Vector3d v = fall;
      for (int i = 0; i < 20000; ++i) {
        Eigen::Vector3d wind(share(random), share(random), share(random));
        wind *= 60 / wind.norm();  // another way each step
        const double before = (v - wind).norm();
        v = dragged_m_s(v, wind, fall, step_s);
        ASSERT_LE((v - wind).norm(), before + gravity_m_s2 * step_s + 1e-9) << speed;
        // Relative to the air never faster than the change of wind and what it had.
        ASSERT_LT(v.norm(), 200) << speed;
      }
    }
  }
}

TopHeight blocks(std::mt19937& random, bool sloped) {
  std::uniform_real_distribution<float> height(0, 3), slope(-0.5f, 0.5f);
  TopHeight top = {.min_x_m = -2, .min_y_m = -1, .texel_m = 0.25, .width = 16, .height = 12};
  for (int i = 0; i < 16 * 12; ++i) {
    TopTexel texel = {.z_m = height(random)};
    if (sloped) texel.slope_x = slope(random), texel.slope_y = slope(random);
    if (i % 3 == 0) texel = {};
    top.texels.push_back(texel);
  }
  return top;
}

TEST(FirstHit, IsWhereTheWayFirstGoesBelowTheHeights) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(-3, 3), y(-2, 3), z(0, 4);
  int hits = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const TopHeight top = blocks(random, trial % 2 == 0);
    const Eigen::Vector3d from(x(random), y(random), 4), to(x(random), y(random), z(random) - 1);
    double expected = 2;
    constexpr int samples = 20000;
    for (int i = 0; i <= samples && expected > 1; ++i) {
      const Eigen::Vector3d at = from + static_cast<double>(i) / samples * (to - from);
      if (at.z() <= height_at(top, at.x(), at.y())) expected = static_cast<double>(i) / samples;
    }
    const auto hit = first_hit(top, from, to);
    if (!hit) {
      EXPECT_EQ(expected, 2) << from.transpose() << " to " << to.transpose();
      continue;
    }
    ++hits;
    // The samples may step over the corner of a texel.
    EXPECT_LE(hit->share, expected + 1e-9);
    const Eigen::Vector3d at = from + (hit->share + 1e-7) * (to - from);
    const double above = at.z() - height_at(top, at.x(), at.y());
    EXPECT_LE(above, 1e-6) << "it is a place of the surface";
    EXPECT_LT(hit->normal.dot(to - from), 0);
  }
  EXPECT_GT(hits, 200);
}

TEST(FirstHit, AnUprightWallThrowsBackSidewaysAndALongWayDoesNotPassIt) {
  TopHeight top = {.min_x_m = 0, .min_y_m = -5, .texel_m = 0.1, .width = 1, .height = 100};
  top.texels.assign(100, {.z_m = 3});
  for (const double side : {-1.0, 1.0}) {
    const auto hit = first_hit(top, {0.05 + 50 * side, 0, 2}, {0.05 - 50 * side, 0, 2.5});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->share, (50 - 0.05) / 100, 1e-12);
    EXPECT_EQ(hit->normal, Eigen::Vector3d(side, 0, 0));
  }
  EXPECT_FALSE(first_hit(top, {-50, 0, 3.1}, {50, 0, 3.1})) << "over it";
}

TEST(DropBounce, KeepsWhatGoesAlongAndTurnsWhatGoesIn) {
  const Eigen::Vector3d off = bounced_m_s({3, 1, -8}, {0, 0, 1}, 0.25);
  EXPECT_EQ(off, Eigen::Vector3d(3, 1, 2));
  EXPECT_EQ(bounced_m_s({3, 1, 8}, {0, 0, 1}, 0.25), Eigen::Vector3d(3, 1, 8)) << "it leaves";
}

}  // namespace
}  // namespace pluvia
