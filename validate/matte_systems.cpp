#include "validate/matte_systems.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/IterativeLinearSolvers>

namespace pluvia {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

// D'D of the differences in the rows of D.
SparseMatrix squared(const Triplets& entries, int differences, int pixels) {
  SparseMatrix d(differences, pixels);
  d.setFromTriplets(entries.begin(), entries.end());
  return SparseMatrix(d.transpose() * d);
}

// Rows and columns of values that are held become those of the identity.
SparseMatrix without(const SparseMatrix& a, const std::vector<bool>& held) {
  SparseMatrix rest = a;
  for (Eigen::Index row = 0; row < rest.outerSize(); ++row) {
    for (SparseMatrix::InnerIterator entry(rest, row); entry; ++entry) {
      const bool cut =
          held[static_cast<std::size_t>(row)] || held[static_cast<std::size_t>(entry.col())];
      if (cut) entry.valueRef() = entry.row() == entry.col() ? 1 : 0;
    }
  }
  return rest;
}

// The gradient with 0 where a value lies on a bound and would leave it.
Eigen::VectorXd free_gradient(const Eigen::VectorXd& gradient, const Eigen::VectorXd& x,
                              const MatteBounds& bounds, std::vector<bool>& held) {
  Eigen::VectorXd free = gradient;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const bool leaves =
        (x[i] <= bounds.low && gradient[i] > 0) || (x[i] >= bounds.high && gradient[i] < 0);
    held[static_cast<std::size_t>(i)] = leaves;
    if (leaves) free[i] = 0;
  }
  return free;
}

// One step; false where q does not fall.
bool step_down(const SparseMatrix& a, const Eigen::VectorXd& b, const MatteBounds& bounds,
               Eigen::VectorXd& x) {
  const Eigen::VectorXd gradient = a * x - b;
  std::vector<bool> held(static_cast<std::size_t>(x.size()));
  const Eigen::VectorXd free = free_gradient(gradient, x, bounds, held);
  if (free.squaredNorm() == 0) return false;
  const SparseMatrix system = without(a, held);
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(1e-3);
  solver.setMaxIterations(100);
  const Eigen::VectorXd direction = solver.compute(system).solve(-free);
  if (!direction.allFinite()) return false;
  for (double length = 1; length > 1e-6; length /= 2) {
    const Eigen::VectorXd there =
        (x + length * direction).cwiseMax(bounds.low).cwiseMin(bounds.high);
    const Eigen::VectorXd moved = there - x;
    const double promised = gradient.dot(moved);
    if (promised + moved.dot(a * moved) / 2 > 1e-4 * promised || promised >= 0) continue;
    x = there;
    return true;
  }
  return false;
}

}  // namespace

SparseMatrix gradient_energy(int width, int height) {
  Triplets entries;
  int row = 0;
  const auto add = [&](int from, int to) {
    entries.emplace_back(row, from, -1.0);
    entries.emplace_back(row++, to, 1.0);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width) add(y * width + x, y * width + x + 1);
      if (y + 1 < height) add(y * width + x, (y + 1) * width + x);
    }
  }
  return squared(entries, row, width * height);
}

SparseMatrix fall_energy(int width, int height, double lean_deg) {
  const double across = std::sin(lean_deg * std::numbers::pi / 180);
  const double down = std::cos(lean_deg * std::numbers::pi / 180);
  const bool by_rows = down >= std::abs(across);
  // Steps of one pixel along the fall's longer part; the way back is as good as the way there.
  const double per_px = by_rows ? down : std::abs(across);
  const double drift = by_rows ? across / down : down / across;
  // The cosine of 90 degrees is no 0: what rounding leaves would cost the last row or column.
  const int whole = static_cast<int>(std::floor(drift + 1e-9));
  const double part = drift - whole > 1e-9 ? drift - whole : 0;
  Triplets entries;
  int row = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int x1 = by_rows ? x + whole : x + 1, y1 = by_rows ? y + 1 : y + whole;
      const int x2 = by_rows ? x1 + 1 : x1, y2 = by_rows ? y1 : y1 + 1;
      const bool inside = x1 >= 0 && y1 >= 0 && x1 < width && y1 < height;
      if (!inside || (part > 0 && (x2 >= width || y2 >= height))) continue;
      entries.emplace_back(row, y * width + x, -per_px);
      entries.emplace_back(row, y1 * width + x1, per_px * (1 - part));
      if (part > 0) entries.emplace_back(row, y2 * width + x2, per_px * part);
      ++row;
    }
  }
  return squared(entries, row, width * height);
}

double quadratic(const SparseMatrix& m, const Eigen::VectorXd& x) {
  return x.dot(m * x);
}

void descend(const SparseMatrix& a, const Eigen::VectorXd& b, const MatteBounds& bounds, int steps,
             Eigen::VectorXd& x) {
  for (int step = 0; step < steps; ++step) {
    if (!step_down(a, b, bounds, x)) return;
  }
}

}  // namespace pluvia
