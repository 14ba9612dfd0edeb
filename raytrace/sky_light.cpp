#include "raytrace/sky_light.h"

#include <cmath>
#include <numbers>

#include "atlas/environment_clip.h"
#include "atlas/image_io.h"
#include "raytrace/environment_map.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {
namespace {

const double sphere_norm = std::sqrt(4 * std::numbers::pi);  // 1 / Y_00

SkyLight uniform_sky(const Eigen::Vector3d& radiance_cd_m2, bool changes) {
  return {.coefficients = sphere_norm * radiance_cd_m2.transpose(), .changes = changes};
}

// The degree without what cannot be told from nothing.
int degree_that_counts(const SkyLight& sky) {
  int degree = degree_of(sky);
  const double least = 1e-4 * sky.coefficients.row(0).maxCoeff();
  const auto rows = [](int l) { return static_cast<Eigen::Index>(harmonic_count(l)); };
  while (degree > 0 &&
         sky.coefficients.middleRows(rows(degree - 1), 2 * degree + 1).cwiseAbs().maxCoeff() <=
             least)
    --degree;
  return degree;
}

}  // namespace

std::optional<Image> posed_map(const EnvironmentLight& environment) {
  if (environment.map_file.empty()) return {};
  if (environment.frames_per_s == 0) return read_environment_map(environment.map_file);
  return EnvironmentClip(environment.map_file).at(environment.picture);
}

int degree_of(const SkyLight& sky) {
  return static_cast<int>(std::lround(std::sqrt(static_cast<double>(sky.coefficients.rows())))) - 1;
}

Eigen::Vector3d mean_radiance(const SkyLight& sky) {
  return sky.coefficients.row(0).transpose() / sphere_norm;
}

SkyLight sky_light(const EnvironmentLight& environment, const Image* map, int most_degree) {
  if (!map) return uniform_sky(environment.uniform_cd_m2, false);
  const bool changes = environment.frames_per_s > 0;
  if (most_degree == 0) {
    const std::vector<double> mean = mean_over_sphere(*map);
    return uniform_sky(environment.scale_cd_m2 * Eigen::Vector3d(mean[0], mean[1], mean[2]),
                       changes);
  }
  const auto lists = harmonic_coefficients({.radiance = *map}, most_degree);
  SkyLight sky = {.changes = changes};
  sky.coefficients.resize(static_cast<Eigen::Index>(harmonic_count(most_degree)), 3);
  for (Eigen::Index c = 0; c < 3; ++c) {
    const std::vector<double>& list = lists[static_cast<std::size_t>(c)];
    sky.coefficients.col(c) =
        environment.scale_cd_m2 *
        Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
  }
  if (changes) return sky;
  const auto kept = static_cast<Eigen::Index>(harmonic_count(degree_that_counts(sky)));
  sky.coefficients.conservativeResize(kept, 3);
  return sky;
}

SkyLight seen_from(const SkyLight& sky, const Eigen::Matrix3d& world_from_frame) {
  return {.coefficients =
              turning_matrix(degree_of(sky), world_from_frame.transpose()) * sky.coefficients,
          .changes = sky.changes};
}

SkyLight turned_over(SkyLight sky) {
  for (int l = 0; l <= degree_of(sky); ++l) {
    for (int m = -l; m <= l; ++m) {  // Y_lm(x, y, -z) = (-1)^(l + m) Y_lm(x, y, z)
      if ((l + m) % 2 != 0)
        sky.coefficients.row(static_cast<Eigen::Index>(harmonic_index(l, m))) *= -1;
    }
  }
  return sky;
}

}  // namespace pluvia
