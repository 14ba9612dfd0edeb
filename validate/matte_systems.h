// The linear systems behind streak mattes (validate/rain_mattes.h): differences of neighbouring
// pixels as sparse matrices, and quadratic forms brought down within bounds.
//
// Pixels are numbered row by row: y width + x.
#pragma once

#include <Eigen/SparseCore>

namespace pluvia {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// |grad s|^2 summed over the picture, as s' M s: squares of the differences of all neighbours in a
// row and in a column. Beyond the border there are none.
SparseMatrix gradient_energy(int width, int height);

// (grad a . d)^2 summed over the picture, as a' M a, along a fall that leans by lean_deg from the
// vertical, -90 .. 90, positive with its lower end to the right. The difference is taken between a
// pixel and where the fall from its centre meets the next row (the next column where the fall is
// flatter than 45 degrees), linearly between the two pixels there, and divided by the way; falls
// that leave the picture have none.
SparseMatrix fall_energy(int width, int height, double lean_deg);

// x' M x.
double quadratic(const SparseMatrix& m, const Eigen::VectorXd& x);

struct MatteBounds {
  double low = 0, high = 0;  // low <= high; may be infinite
};

// Brings q(x) = x' A x / 2 - b' x down from an x within the bounds, to one that is, by at most
// `steps` projected Newton steps (Bertsekas, "Projected Newton Methods for Optimization Problems
// with Simple Constraints", SIAM J. Control 20(2), 1982): values that lie on a bound and would
// leave it are held, the others go along the solution of their system (conjugate gradients,
// Jacobi's preconditioner, to 1e-3 of the gradient), cut to the bounds, and half as far until q
// falls by 1e-4 of what the gradient promises. q never rises; where no step makes it fall, x stays.
// A: symmetric, positive semidefinite.
void descend(const SparseMatrix& a, const Eigen::VectorXd& b, const MatteBounds& bounds, int steps,
             Eigen::VectorXd& x);

}  // namespace pluvia
