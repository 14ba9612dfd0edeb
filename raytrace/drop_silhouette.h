// The outline of a falling drop and what it covers of a picture: geometry alone, without a ray.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "oscillation/drop_shape.h"
#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"

namespace pluvia {

// The projection of the surface as a polygon: `corners` points at equal angles about the projected
// star centre, to the right and up, relative to the drop's origin [m]. The drop is star-shaped, so
// its projection is too, and in image direction a the outline lies at
//   max over b of r(cos b e_a + sin b c) cos b,   e_a in the image, c toward the camera.
// Widened so that a circle keeps its area. corners >= 3.
std::vector<Eigen::Vector2d> drop_outline_m(const DropInstant& drop, const View& view, int corners);

// Distance from the projected star centre to the outline in image direction e (unit, perpendicular
// to to_camera): the maximum above, off by less than 1e-6 of the radius.
double outline_distance_m(const DropInstant& drop, const Eigen::Vector3d& e,
                          const Eigen::Vector3d& to_camera);

// Share of each pixel's area and of the exposure in which the drop is there, 0 .. 1, row by row:
// the `coverage` of a shard (atlas/streak_database.h). Without noise; within about 1e-3 of its
// maximum of the exact one.
std::vector<float> silhouette_coverage(const DropShape& drop, double view_elevation_deg,
                                       double exposure_s, const StreakFrame& frame);

}  // namespace pluvia
