// Depth of field of a thin lens: a point at depth z (along the camera's axis) that is not at the
// distance of focus s shows as a disc, evenly bright, of radius
//   R = f (A / 2) |1 / s - 1 / z|  pixels,
// f the focal length in pixels (CameraFrame), A the aperture's diameter (Potmesil and Chakravarty,
// "A lens and aperture camera model for synthetic image generation", SIGGRAPH 1981). It is what the
// picture of a pinhole becomes, averaged over pinholes all over the aperture, each turned so that
// what is at s stays where it is.
//
// A streak has one circle, that of the middle of its path, and the same look from all over the
// aperture; surfaces stay sharp. Where a sharp surface hides part of a streak, it does so pixel by
// pixel.
#pragma once

#include "raytrace/scene.h"

namespace pluvia {

constexpr double nearest_focus_m = 0.1, farthest_focus_m = 1e6;  // or infinity

// Of a lens whose picture is 24 mm high, focused far away: 12 mm / tan(fov / 2) / f_number.
double aperture_of_f_number_m(double f_number, double vertical_fov_deg);

// R as above, depth_m > 0; 0 without depth of field.
double circle_px(const Camera& camera, double depth_m);

// f A / 2: what R is for a focus at infinity and a depth of 1 m.
double circle_scale_px_m(const Camera& camera);

// How far beside a pinhole's view a point at a depth may be and still show: R depth_m / f at most,
// and linear in the depth. m.
double beside_view_m(const Camera& camera, double depth_m);

// The largest circle of any streak that may be drawn, from nearest_depth_m on, whatever the focus.
double largest_circle_px(const Camera& camera);

}  // namespace pluvia
