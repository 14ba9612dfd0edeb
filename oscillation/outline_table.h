// Measured outlines of one drop: CSV with '#' comments, one line of column names, one row a point.
//
//   # source: who measured it, and how                    required: a line that starts like this
//   t_s,theta_deg,r_mm                                    names carry the unit
//   0.0,0,1.62
//
// Columns, in any order: t_s or t_ms; theta_deg or theta_rad (in the picture, from up toward right,
// oscillation/outline.h); r_m, r_mm or r_um (from the drop's centre to the outline); and where
// known sigma_m, sigma_mm or sigma_um (standard error of r), view_elevation_deg, view_azimuth_deg
// (of the camera that saw it, else 0: horizontal, on the drop's +x axis).
#pragma once

#include <string>
#include <vector>

namespace pluvia {

struct OutlinePoint {
  double time_s = 0;
  double theta_rad = 0;
  double radius_m = 0;  // 1e-5 .. 2e-2
  double sigma_m = 0;   // 0: not told
  double view_elevation_rad = 0;
  double view_azimuth_rad = 0;
};

struct Outlines {
  std::string source = {};
  std::vector<OutlinePoint> points = {};
};

// Throws std::runtime_error "FILE:LINE:COL: found; expected" (the column counts characters, from
// 1).
Outlines read_outlines(const std::string& file);

}  // namespace pluvia
