// Light from all around a drop, as a lat-long map in the world (atlas/image_io.h: z up, column 0 at
// longitude -180 degrees, longitude from +x towards -y, row 0 at the zenith), seen from the drop
// frame: z against the fall, x the part of drop -> camera across it, y = z x x.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "atlas/image.h"

namespace pluvia {

struct EnvironmentMap {
  Image radiance = {};  // width == 2 * height, finite, >= 0, any number of channels; or empty
  Eigen::Matrix3d world_from_drop = Eigen::Matrix3d::Identity();  // a rotation
};

// Unit world direction of a place in the map; column 0 .. width and row 0 .. height are its edges,
// pixel centres lie at halves.
Eigen::Vector3d map_direction(const Image& map, double column, double row);

// Radiance from a unit direction of the drop frame, bilinear between pixel centres (across the left
// and right edge, and over the poles to the opposite meridian). radiance.size() == channels.
void look_up(const EnvironmentMap& map, const Eigen::Vector3d& direction,
             std::span<double> radiance);

// The map's coefficients in spherical harmonics of the drop frame (raytrace/spherical_harmonics.h),
// one list for each channel: integrals of radiance times Y_lm over the sphere, the radiance of a
// pixel taken as constant over its solid angle. degree in 0 .. highest_harmonic_degree.
std::vector<std::vector<double>> harmonic_coefficients(const EnvironmentMap& map, int degree);

}  // namespace pluvia
