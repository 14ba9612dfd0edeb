#include "raytrace/sphere_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "raytrace/sphere_closed_form.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

void require_sane(const SphereTransferOptions& options) {
  if (!(options.refractive_index > 1) || !std::isfinite(options.refractive_index))
    throw std::runtime_error(
        fmt::format("refractive index {}; expected more than 1", options.refractive_index));
  if (options.terms < 1)
    throw std::runtime_error(fmt::format("{} terms; expected 1 or more", options.terms));
}

double throughput(const SphereTransferOptions& options, int order, double incidence) {
  const double b = std::sin(incidence);
  if (!options.averaged_reflectance) return sphere_throughput(options.refractive_index, order, b);
  const double r = sphere_throughput(options.refractive_index, 0, b);
  return order == 0 ? r : (1 - r) * (1 - r) * std::pow(r, order - 1);
}

// integral over the angle of incidence of throughput x weight(i) d(sin^2 i), by Gauss' rule of five
// points on pieces of at most 0.01: throughput is analytic there, and the rule's error below 1e-15.
template <typename Weight>
double integral(const SphereTransferOptions& options, int order, double from, double to,
                Weight weight) {
  constexpr double nodes[] = {0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weights[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const int pieces = std::max(1, static_cast<int>(std::ceil((to - from) / 0.01)));
  const double half = (to - from) / pieces / 2;
  double sum = 0;
  const auto add = [&](double i, double share) {
    sum += share * half * throughput(options, order, i) * std::sin(2 * i) * weight(i);
  };
  for (int k = 0; k < pieces; ++k) {
    const double middle = from + (2 * k + 1) * half;
    add(middle, weights[0]);
    for (const int n : {1, 2}) {
      add(middle - nodes[n] * half, weights[n]);
      add(middle + nodes[n] * half, weights[n]);
    }
  }
  return sum;
}

// Angles of incidence in (0, pi / 2) where the deviation turns, or passes a multiple of pi, with 0
// and pi / 2: between neighbours the folded angle is monotone and D finite.
std::vector<double> folds(double index, int order) {
  std::vector<double> turns = {0, pi / 2};
  // cos^2 i = (n^2 - 1) / (p^2 - 1); none where it is beyond 1.
  const double square = order < 2 ? 2 : (index * index - 1) / (order * order - 1.0);
  if (square < 1) turns.insert(turns.begin() + 1, std::acos(std::sqrt(square)));
  std::vector<double> all = {0};
  for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
    const double from = sphere_deviation_rad(index, order, turns[k]);
    const double to = sphere_deviation_rad(index, order, turns[k + 1]);
    std::vector<double> cuts;
    for (double fold = std::ceil(std::min(from, to) / pi) * pi; fold < std::max(from, to);
         fold += pi) {
      // The ends themselves are multiples of pi: not to be cut again.
      if (std::min(std::abs(fold - from), std::abs(fold - to)) < 1e-9) continue;
      cuts.push_back(sphere_incidence_rad(index, order, fold, turns[k], turns[k + 1]));
    }
    std::sort(cuts.begin(), cuts.end());
    all.insert(all.end(), cuts.begin(), cuts.end());
    all.push_back(turns[k + 1]);
  }
  return all;
}

double folded(double deviation) {
  return std::abs(std::remainder(deviation, 2 * pi));
}

// Rays of one order between two angles of incidence, whose scattering angles go one way.
struct Rays {
  double from = 0, to = 0;   // incidence
  double low = 0, high = 0;  // scattering angle, folded
};

// The angle of incidence at which such rays have a scattering angle of low .. high.
double incidence_of(double index, int order, const Rays& rays, double angle) {
  const double deviation = sphere_deviation_rad(index, order, 0.5 * (rays.from + rays.to));
  const double turn = std::floor(deviation / pi);
  const bool upward = std::fmod(std::abs(turn), 2) == 0;
  return sphere_incidence_rad(index, order, upward ? turn * pi + angle : (turn + 1) * pi - angle,
                              rays.from, rays.to);
}

// The part of the rays with those angles.
Rays between(double index, int order, const Rays& rays, double low, double high) {
  const double a = incidence_of(index, order, rays, low);
  const double b = incidence_of(index, order, rays, high);
  return {std::min(a, b), std::max(a, b), low, high};
}

// All rays of an order, or of those with one angle the one nearest the axis.
std::vector<Rays> rays_of(const SphereTransferOptions& options, int order) {
  const double index = options.refractive_index;
  const std::vector<double> cuts = folds(index, order);
  std::vector<Rays> all;
  double seen_low = 0, seen_high = 0;  // connected, for the angle goes without steps
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double a = folded(sphere_deviation_rad(index, order, cuts[k]));
    const double b = folded(sphere_deviation_rad(index, order, cuts[k + 1]));
    const Rays rays = {cuts[k], cuts[k + 1], std::min(a, b), std::max(a, b)};
    if (k == 0 || !options.single_root) {
      all.push_back(rays);
    } else {
      if (rays.low < seen_low)
        all.push_back(between(index, order, rays, rays.low, std::min(rays.high, seen_low)));
      if (rays.high > seen_high)
        all.push_back(between(index, order, rays, std::max(rays.low, seen_high), rays.high));
    }
    seen_low = k == 0 ? rays.low : std::min(seen_low, rays.low);
    seen_high = k == 0 ? rays.high : std::max(seen_high, rays.high);
  }
  return all;
}

// Adds the energy of the rays to the rings of angle.
void add_rays(const SphereTransferOptions& options, int order, const Rays& rays,
              std::vector<double>& energy) {
  const double width = pi / static_cast<double>(energy.size());
  const auto ring_of = [&](double angle) {
    return std::min(energy.size() - 1, static_cast<std::size_t>(angle / width));
  };
  const double index = options.refractive_index;
  double at = incidence_of(index, order, rays, rays.low);
  for (std::size_t ring = ring_of(rays.low); ring <= ring_of(rays.high); ++ring) {
    const double edge = std::min(rays.high, width * static_cast<double>(ring + 1));
    const double next = incidence_of(index, order, rays, edge);
    energy[ring] += integral(options, order, std::min(at, next), std::max(at, next),
                             [](double) { return 1.0; });
    at = next;
  }
}

}  // namespace

std::vector<double> sphere_transfer(const SphereTransferOptions& options, int bins) {
  require_sane(options);
  if (bins < 1) throw std::runtime_error(fmt::format("{} rings; expected 1 or more", bins));
  std::vector<double> rings(static_cast<std::size_t>(bins), 0.0);
  for (int order = 0; order < options.terms; ++order) {
    for (const Rays& rays : rays_of(options, order)) add_rays(options, order, rays, rings);
  }
  const double width = pi / bins;
  for (int k = 0; k < bins; ++k)  // cos a - cos b without the loss of digits that it has near 0
    rings[static_cast<std::size_t>(k)] /=
        4 * pi * std::sin((k + 0.5) * width) * std::sin(width / 2);
  return rings;
}

double transfer_at(const std::vector<double>& table, double angle_rad) {
  const double last = static_cast<double>(table.size()) - 1;
  const double at = std::clamp(angle_rad / pi * (last + 1) - 0.5, 0.0, last);
  const auto low = static_cast<std::size_t>(at);
  const auto high = std::min(low + 1, table.size() - 1);
  const double share = at - static_cast<double>(low);
  return (1 - share) * table[low] + share * table[high];
}

std::vector<double> transfer_harmonics(const SphereTransferOptions& options, int degree) {
  require_sane(options);
  std::vector<double> harmonics(static_cast<std::size_t>(degree) + 1, 0.0);
  for (int order = 0; order < options.terms; ++order) {
    for (const Rays& rays : rays_of(options, order)) {
      for (std::size_t l = 0; l < harmonics.size(); ++l)
        harmonics[l] += integral(options, order, rays.from, rays.to, [&](double i) {
          const double angle = sphere_deviation_rad(options.refractive_index, order, i);
          return std::legendre(static_cast<unsigned>(l), std::cos(angle));
        });
    }
  }
  return harmonics;
}

Eigen::VectorXd transfer_seen_from(const std::vector<double>& harmonics,
                                   const Eigen::Vector3d& to_eye) {
  const int degree = static_cast<int>(harmonics.size()) - 1;
  std::vector<double> values(harmonic_count(degree));
  real_harmonics(degree, -to_eye, values);
  for (int l = 0; l <= degree; ++l) {
    for (int m = -l; m <= l; ++m)
      values[harmonic_index(l, m)] *= harmonics[static_cast<std::size_t>(l)];
  }
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace pluvia
