#include "raytrace/drop_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "oscillation/fall_speed.h"

namespace pluvia {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// (1 - exp(-k t)) / k
double faded_s(double k_1_s, double t_s) {
  const double x = k_1_s * t_s;
  return x < 1e-12 ? t_s : -std::expm1(-x) / k_1_s;
}

// |u| after t of du/dt = g - kappa |u| u by the implicit Euler method: with s = |u + t g|, the
// positive root of kappa t x^2 + x = s.
double implicit_speed_m_s(const Eigen::Vector3d& u, const Eigen::Vector3d& gravity, double kappa,
                          double t_s) {
  const double s = (u + t_s * gravity).norm();
  return 2 * s / (1 + std::sqrt(1 + 4 * kappa * t_s * s));
}

// A way over the grid: from in texels, step in texels over the whole of it.
struct Walk {
  const TopHeight& top;
  Eigen::Vector3d from_m, way_m;
  Eigen::Vector2d from_px = {0, 0}, way_px = {0, 0};
  int cell[2] = {0, 0};
  int crossed = -1;  // the axis whose border was crossed last; -1: none yet

  // The share of the way where it leaves the cell along an axis.
  double leaves_at(int axis) const {
    if (way_px[axis] == 0) return infinity;
    const double border = cell[axis] + (way_px[axis] > 0 ? 1 : 0);
    return (border - from_px[axis]) / way_px[axis];
  }
  std::optional<SurfaceHit> in_cell(double begin, double end) const;
};

std::optional<SurfaceHit> Walk::in_cell(double begin, double end) const {
  if (cell[0] < 0 || cell[1] < 0 || cell[0] >= top.width || cell[1] >= top.height) return {};
  const TopTexel& texel =
      top.texels[static_cast<std::size_t>(cell[1]) * static_cast<std::size_t>(top.width) +
                 static_cast<std::size_t>(cell[0])];
  const Eigen::Vector3d slope(static_cast<double>(texel.slope_x),
                              static_cast<double>(texel.slope_y), 0);
  const auto above_m = [&](double share) {
    const Eigen::Vector2d px = from_px + share * way_px - Eigen::Vector2d(cell[0], cell[1]);
    const double beside = slope.head<2>().dot(px - Eigen::Vector2d(0.5, 0.5)) * top.texel_m;
    return from_m.z() + share * way_m.z() - static_cast<double>(texel.z_m) - beside;
  };
  const Eigen::Vector3d upward = (Eigen::Vector3d(0, 0, 1) - slope).normalized();
  const double first_m = above_m(begin), last_m = above_m(end);
  if (first_m <= 0 && crossed >= 0 && first_m < -top.texel_m) {
    Eigen::Vector3d normal(0, 0, 0);
    normal[crossed] = way_px[crossed] > 0 ? -1 : 1;
    return SurfaceHit{begin, normal};
  }
  if (first_m <= 0) return SurfaceHit{begin, upward};
  if (last_m > 0) return {};
  return SurfaceHit{begin + (end - begin) * first_m / (first_m - last_m), upward};
}

}  // namespace

Eigen::Vector3d dragged_m_s(const Eigen::Vector3d& velocity_m_s, const Eigen::Vector3d& wind_m_s,
                            const Eigen::Vector3d& fall_m_s, double step_s) {
  const Eigen::Vector3d gravity = gravity_m_s2 * fall_m_s.normalized();
  const double kappa = gravity_m_s2 / fall_m_s.squaredNorm();
  const Eigen::Vector3d u = velocity_m_s - wind_m_s;
  const double k = kappa * implicit_speed_m_s(u, gravity, kappa, step_s / 2);
  return wind_m_s + u + faded_s(k, step_s) * (gravity - k * u);
}

std::optional<SurfaceHit> first_hit(const TopHeight& top, const Eigen::Vector3d& from_m,
                                    const Eigen::Vector3d& to_m) {
  Walk walk = {.top = top, .from_m = from_m, .way_m = to_m - from_m};
  walk.from_px = (from_m.head<2>() - Eigen::Vector2d(top.min_x_m, top.min_y_m)) / top.texel_m;
  walk.way_px = walk.way_m.head<2>() / top.texel_m;
  for (int axis = 0; axis < 2; ++axis)
    walk.cell[axis] = static_cast<int>(std::floor(walk.from_px[axis]));
  double begin = 0;
  while (begin < 1) {
    const double along_x = walk.leaves_at(0), along_y = walk.leaves_at(1);
    const double end = std::max(begin, std::min({along_x, along_y, 1.0}));
    if (const auto hit = walk.in_cell(begin, end)) return hit;
    walk.crossed = along_x < along_y ? 0 : 1;
    walk.cell[walk.crossed] += walk.way_px[walk.crossed] > 0 ? 1 : -1;
    begin = end;
  }
  return {};
}

Eigen::Vector3d bounced_m_s(const Eigen::Vector3d& velocity_m_s, const Eigen::Vector3d& normal,
                            double restitution) {
  const double inward = std::min(velocity_m_s.dot(normal), 0.0);
  return velocity_m_s - (1 + restitution) * inward * normal;
}

}  // namespace pluvia
