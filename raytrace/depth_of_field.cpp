#include "raytrace/depth_of_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "raytrace/streak_placement.h"

namespace pluvia {

double aperture_of_f_number_m(double f_number, double vertical_fov_deg) {
  return 0.012 / std::tan(vertical_fov_deg * std::numbers::pi / 360) / f_number;
}

double circle_scale_px_m(const Camera& camera) {
  if (!camera.depth_of_field) return 0;
  return camera_frame(camera).focal_px * camera.depth_of_field->aperture_m / 2;
}

double circle_px(const Camera& camera, double depth_m) {
  if (!camera.depth_of_field) return 0;
  return circle_scale_px_m(camera) * std::abs(1 / camera.depth_of_field->focus_m - 1 / depth_m);
}

double beside_view_m(const Camera& camera, double depth_m) {
  if (!camera.depth_of_field) return 0;
  const DepthOfField& lens = *camera.depth_of_field;
  return lens.aperture_m / 2 * (1 + depth_m / lens.focus_m);
}

double largest_circle_px(const Camera& camera) {
  return circle_scale_px_m(camera) / std::min(nearest_depth_m, nearest_focus_m);
}

}  // namespace pluvia
