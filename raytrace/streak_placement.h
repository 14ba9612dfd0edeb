// Where a drop's streak lies in a picture and how it is lit: the one rule that the real-time
// renderer (in GLSL, tested against this) and every composite in C++ follow.
//
// The streak picture has columns u in [0, cell width] and rows r in [0, top + path_rows + bottom],
// in units of the database's pixel (pixel_m), r = top where the drop's centre is at shutter-open
// and r = top + path_rows at shutter-close. On screen it is the parallelogram
// origin + u column + r row.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "raytrace/drop_field.h"
#include "raytrace/scene.h"

namespace pluvia {

struct StreakGeometry {  // the few numbers of an atlas that placement needs
  double pixel_m = 0;
  double cell_width_px = 0;
  double exposure_s = 0;
  double path_top_row = 0;  // the same for all views of a database
};

struct LitStreak {
  double light_elevation_deg = 0;  // above the plane perpendicular to the fall
  double light_azimuth_deg = 0;    // -180 .. 180, from the camera's side toward image right
  Eigen::Vector3d irradiance_lux = {0, 0, 0};  // on a plane facing the light, at mid path: I / r^2
};

struct StreakPlacement {
  Eigen::Vector2d origin_px = {0,
                               0};  // screen position of (u, r) = (0, 0); screen x right, y down,
  Eigen::Vector2d column_px = {1, 0};  // pixel (i, j) covers [i, i+1] x [j, j+1]
  Eigen::Vector2d row_px = {0, 1};
  double path_rows = 0;  // exposure * speed * cos(view elevation) / pixel_m
  double clip_row = 0;   // rows beyond are not drawn: the drop has hit the ground there;
                         // infinity when it does not
  double depth_m = 0;    // of mid path, along the camera's axis
  double view_elevation_deg = 0;
  std::vector<LitStreak> lights = {};  // in order of scene.lights
};

// With P0, P1 the centre at shutter-open and -close, M their middle, z = -velocity/|velocity|, D =
// toward the camera from M: view elevation = asin(D.z); x = the part of D perpendicular to z,
// normalised; y = z cross x (image right); light elevation asin(L.z), azimuth atan2(L.y, L.x), L
// toward the light from M. On screen, with J the derivative of the perspective projection at M:
//   row_px    = (proj(P1) - proj(P0)) / path_rows where path_rows >= 1; below that J (-up) pixel_m,
//               up = (z - (z.D) D) normalised
//   column_px = J y pixel_m
//   origin_px = proj(P0) - path_top_row row_px - cell_width_px / 2 column_px
// The picture's up is -sin(view elevation) x + cos(view elevation) z: the same up as above, also
// where D is parallel to z to 1e-6. There, x is the camera's backward axis made perpendicular to z,
// or, where the camera looks along z too, its up axis (looking up) or the opposite (looking down).
// Nothing (nullopt) for a drop that has hit before shutter-open, or with P0 or P1 nearer to the
// camera plane than 0.1 m. Throws std::runtime_error where M lies nearer to a lamp than
// r0.
std::optional<StreakPlacement> place_streak(const Scene& scene, const Drop& drop,
                                            const StreakGeometry& geometry);

// The row of a cell (view i: path_i rows, the same top) that belongs to row r of a placement with
// path_rows: r above the path, top + (r - top) path_i / path_rows on it, r - path_rows + path_i
// below. Flux between two rows is the difference of the cell's cumulative sums at the mapped rows,
// so the flux of a streak does not depend on the stretch.
double cell_row(double row, double path_top_row, double path_rows, double cell_path_rows);

}  // namespace pluvia
