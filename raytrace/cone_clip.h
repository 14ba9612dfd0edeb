// The part of a surface triangle whose light comes from a cone.
//
// A triangle of the exit field has a position in the picture, a throughput and an exit direction at
// each corner, linear in between. In the plane at distance 1 on its axis the cone is the disc of
// radius tan(half angle), here a 16-gon of the same area (a flux error below 2 % of the cone's rim
// only where the field bends within it); its sides are planes through the apex, so that a triangle
// is clipped by linear functions of the direction, however far its corners are from the axis. What
// is left after clipping is measured in the picture, so folds of the map (caustics) need no special
// case: nothing is ever divided by an area in direction space.
#pragma once

#include <array>

#include <Eigen/Core>

namespace pluvia {

constexpr int cone_sides = 16;

struct Cone {
  Eigen::Vector3d axis = {0, 0, 1};
  double half_angle_rad = 0;
  // Of the planes through the apex that bound the 16-gon: inside where inward . direction >= 0.
  std::array<Eigen::Vector3d, cone_sides> inward = {};
};

// half_angle_rad in (0, pi / 2).
Cone make_cone(const Eigen::Vector3d& axis, double half_angle_rad);

// No defaults: polygons are made by the million, and clearing one costs as much as clipping it.
struct ConeVertex {
  double dx, dy, dz;  // direction, of about unit length
  double x, y;        // in the picture
  double throughput;
  double facing;      // of the surface: > 0 where the camera sees it
  double margin;      // of the last interface: > 0 where it lets light through
};

// A convex polygon; a triangle clipped by 16 planes has at most 19 corners, by four more 23.
struct ConePolygon {
  std::array<ConeVertex, 24> vertices;
  int count;
};

// Keeps the part inside the cone.
void clip_to_cone(const Cone& cone, ConePolygon& polygon);

// Keeps the part that the camera sees, none of it with a throughput below zero.
void clip_to_facing(ConePolygon& polygon);

// Keeps the part whose last interface lets light through; at the cut the throughput is 0.
void clip_to_margin(ConePolygon& polygon);

// Keeps the part with low <= x <= high.
void clip_to_columns(ConePolygon& polygon, double low, double high);

// Area in the picture (>= 0 whatever the orientation) and its mean throughput.
struct PolygonFlux {
  double area = 0;
  double throughput = 0;  // area-weighted mean
};
PolygonFlux polygon_flux(const ConePolygon& polygon);

}  // namespace pluvia
