// Where a drop's streak lies in a picture and how it is lit: the one rule that the real-time
// renderer (in GLSL, tested against this) and every composite in C++ follow.
//
// The streak picture has columns u in [0, cell width] and rows r in [0, top + path_rows + bottom],
// in units of the database's pixel (pixel_m), r = top where the drop's centre is at shutter-open
// and r = top + path_rows at shutter-close. On screen it is the parallelogram
// origin + u column + r row.
//
// A picture shows the drop for which it was traced, for the exposure that it was traced with. A
// drop of another radius is the same picture made larger or smaller, and oscillates in a time that
// goes with the radius to the power 3/2: the picture lasts
//   T = exposure_s (r0 / mean_radius_m)^1.5
// of its fall. A camera's longer exposure shows several of them one after the other (segments, at
// most most_segments: beyond that each is stretched), a shorter one the first part of it. Flux is
// kept: a segment counts T / camera exposure. What is wrong then: the flattening of the drop at
// rest stays that of the traced one, and oscillations of order above 2 do not close after a
// segment. Pictures that have the shape of strokes (atlas/stroke_coverage.h) show no oscillation:
// one is the whole streak, T is the camera's exposure.
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
  double path_top_row = 0;        // the same for all views of a database
  double mean_radius_m = 1.6e-3;  // of the drop that it shows
  bool any_exposure = false;      // one picture is all of a streak, whatever exposure and radius
};

constexpr double nearest_depth_m = 0.1;  // of a drop that is drawn, along the camera's axis

constexpr int most_segments = 64;

// How the exposure of a camera falls into segments for drops of a radius.
struct SegmentTimes {
  int count = 1;
  double each_s = 0;  // T, the last one may be cut short
};
SegmentTimes segment_times(double camera_exposure_s, double r0_m, const StreakGeometry& geometry);

struct LitStreak {
  double light_elevation_deg = 0;  // above the plane perpendicular to the fall
  double light_azimuth_deg = 0;    // -180 .. 180, from the camera's side toward image right
  Eigen::Vector3d irradiance_lux = {
      0, 0, 0};  // on a plane facing the light, at mid path (raytrace/light.h)
};

struct StreakPlacement {
  Eigen::Vector2d origin_px = {0,
                               0};  // screen position of (u, r) = (0, 0); screen x right, y down,
  Eigen::Vector2d column_px = {1, 0};  // pixel (i, j) covers [i, i+1] x [j, j+1]
  Eigen::Vector2d row_px = {0, 1};
  double path_rows = 0;  // T * speed * cos(view elevation) / (pixel_m r0 / mean_radius_m), at least
                         // 0.01: else all flux of a drop seen along its fall lies at one row, and
                         // on the border of two pixels rounding may give it to both or to none
  double clip_row = 0;   // rows beyond are not drawn: the drop has hit the ground there, or the
                         // shutter has closed; infinity when neither happens in the segment
  double time_share = 1;  // T / camera exposure: what the picture's values count
  double depth_m = 0;     // of mid path, along the camera's axis
  double distance_m = 0;  // of mid path
  double view_elevation_deg = 0;
  Eigen::Matrix3d world_from_drop = Eigen::Matrix3d::Identity();  // columns x, y, z as below
  std::vector<LitStreak> lights = {};                             // in order of scene.lights
};

// A segment of a drop's streak. pixel = pixel_m r0 / mean_radius_m. With P0, P1 the centre at the
// segment's start and after T, M their middle, z = -velocity/|velocity|, D =
// toward the camera from M: view elevation = asin(D.z); x = the part of D perpendicular to z,
// normalised; y = z cross x (image right); light elevation asin(L.z), azimuth atan2(L.y, L.x), L
// toward the light from M. On screen, with J the derivative of the perspective projection at M:
//   row_px    = (proj(P1) - proj(P0)) / path_rows where path_rows >= 1; below that J (-up) pixel,
//               up = (z - (z.D) D) normalised
//   column_px = J y pixel
//   origin_px = proj(P0) - path_top_row row_px - cell_width_px / 2 column_px
// The picture's up is -sin(view elevation) x + cos(view elevation) z: the same up as above, also
// where D is parallel to z to 1e-6. There, x is the camera's backward axis made perpendicular to z,
// or, where the camera looks along z too, its up axis (looking up) or the opposite (looking down).
// Nothing (nullopt) for a drop that has hit before the segment, or with P0 or P1 nearer to the
// camera plane than 0.1 m, or with M inside a lamp.
std::optional<StreakPlacement> place_streak(const Scene& scene, const Drop& drop,
                                            const StreakGeometry& geometry, int segment = 0);

// Columns x, y, z of the frame above for a drop of that velocity (not zero) seen along
// toward_camera (unit): what its transverse modes are turned by.
Eigen::Matrix3d drop_axes(const CameraFrame& camera, const Eigen::Vector3d& velocity,
                          const Eigen::Vector3d& toward_camera);

// The row of a cell (view i: path_i rows, the same top) that belongs to row r of a placement with
// path_rows: r above the path, top + (r - top) path_i / path_rows on it, r - path_rows + path_i
// below. Flux between two rows is the difference of the cell's cumulative sums at the mapped rows,
// so the flux of a streak does not depend on the stretch.
double cell_row(double row, double path_top_row, double path_rows, double cell_path_rows);

}  // namespace pluvia
