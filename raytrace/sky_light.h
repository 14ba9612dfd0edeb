// The light around the rain, for whoever lights streaks with it: radiance L = sum c_lm Y_lm in real
// spherical harmonics (raytrace/spherical_harmonics.h). A streak under it is sum c_lm transfer_lm,
// c in the drop's frame (atlas/transfer.h): L is projected once, in the world, and turned from
// there. After Sloan, Kautz and Snyder, "Precomputed Radiance Transfer", SIGGRAPH 2002.
//
// A cut-off sum may be negative in places, and so may a streak that sees such a place. What it
// stands for is not: whoever adds up a streak's light in a pixel cuts the sum at 0, which brings it
// nearer to the truth wherever it acts.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "atlas/image.h"
#include "raytrace/scene.h"

namespace pluvia {

// The environment's map, or the map of its clip that it is posed at; nothing where it has none.
// Throws std::runtime_error as read_environment_map and EnvironmentClip do.
std::optional<Image> posed_map(const EnvironmentLight& environment);

struct SkyLight {
  // One row for each harmonic, by l^2 + l + m, as many as harmonic_count(degree); one column for
  // each Rec.709 channel; cd/m^2.
  Eigen::Matrix<double, Eigen::Dynamic, 3> coefficients =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(1, 3);
  bool changes = false;  // a clip's: other maps of it may be brighter, or less even
};

int degree_of(const SkyLight& sky);                  // 0: the same from everywhere
Eigen::Vector3d mean_radiance(const SkyLight& sky);  // over the sphere, cd/m^2

// In the world. map: as read_environment_map has it, nullptr where the scene names none. At most
// that degree, 0 .. 8: from the top, degrees that hold less than 1e-4 of the mean are left out, for
// the projection errs by up to 6e-5 (raytrace/environment_map.h) and a grey map is no more than
// uniform. Of a clip all are kept, so that each of its maps has as many.
SkyLight sky_light(const EnvironmentLight& environment, const Image* map, int most_degree);

// In a frame with these axes (columns, a rotation).
SkyLight seen_from(const SkyLight& sky, const Eigen::Matrix3d& world_from_frame);

// Turned over at the plane z = 0: for views from below that are served by those from above
// (ViewsBelow::flipped of atlas/atlas_lookup.h).
SkyLight turned_over(SkyLight sky);

}  // namespace pluvia
