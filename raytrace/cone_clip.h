// The part of a surface triangle whose light comes from a cone.
//
// A triangle of the exit field has a position in the picture, a throughput and an exit direction at
// each corner. About the cone's axis the directions are gnomonic coordinates (u, v), linear in
// between; the cone is there the disc |(u, v)| <= tan(half angle), here a 16-gon of the same area
// (a flux error below 2 % of the cone's rim only where the field bends within it). What is left
// after clipping is measured in the picture, so folds of the map (caustics) need no special case:
// nothing is ever divided by an area in direction space.
#pragma once

#include <array>

#include <Eigen/Core>

namespace pluvia {

struct Cone {
  Eigen::Vector3d axis = {0, 0, 1};
  Eigen::Vector3d across1 = {1, 0, 0}, across2 = {0, 1, 0};
  double half_angle_rad = 0;
  double circumradius = 0;  // of the 16-gon of the disc's area
};

Cone make_cone(const Eigen::Vector3d& axis, double half_angle_rad);

// No defaults: polygons are made by the million, and clearing one costs as much as clipping it.
struct ConeVertex {
  double u, v;  // gnomonic
  double x, y;  // in the picture
  double throughput;
};

// A convex polygon; a triangle clipped by 16 lines has at most 19 corners, by two more 21.
struct ConePolygon {
  std::array<ConeVertex, 24> vertices;
  int count;
};

// Gnomonic coordinates of a direction. False (and untouched) when it is more than 78 degrees off
// the axis, where the map is useless.
bool gnomonic(const Cone& cone, const Eigen::Vector3d& direction, ConeVertex& vertex);

// Keeps the part inside the cone.
void clip_to_cone(const Cone& cone, ConePolygon& polygon);

// Keeps the part with low <= x <= high.
void clip_to_columns(ConePolygon& polygon, double low, double high);

// Area in the picture (>= 0 whatever the orientation) and its mean throughput.
struct PolygonFlux {
  double area = 0;
  double throughput = 0;  // area-weighted mean
};
PolygonFlux polygon_flux(const ConePolygon& polygon);

}  // namespace pluvia
