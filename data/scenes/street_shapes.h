// Shapes that make_street builds with. Metres, world axes (x east, y north along the street, z up).
// Faces are flat and counter-clockwise from outside.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace street {

using Eigen::Vector3d;

// clang-format off
enum Surface {
  asphalt, patch, paint, kerb, paving, brick, plaster, stone, sooty, trim, roof, door,
  glass, dim_room, lit_room, bright_room, shop, metal, car_red, car_blue, car_grey, tyre,
  lamp_sodium, lamp_white, surfaces
};
// clang-format on

struct Part {  // one surface's triangles, in millimetres of glTF's axes
  std::map<std::array<int, 3>, std::uint16_t> known = {};
  std::vector<float> positions_m = {};
  std::vector<std::uint16_t> indices = {};
};

struct Street {
  std::array<Part, surfaces> parts = {};
  std::mt19937 random{
      20061117};  // the engine's numbers are the same everywhere, distributions are not
};

// A place to build at: u along, w out of the wall, z up, with along x up = out.
struct Frame {
  Vector3d origin = {0, 0, 0};
  Vector3d along = {1, 0, 0};
  Vector3d out = {0, -1, 0};
  Vector3d at(double u, double w, double z) const {
    return origin + u * along + w * out + z * Vector3d::UnitZ();
  }
};

void rectangle(Street& street, Surface surface, const std::array<Vector3d, 4>& corner);

// Walls between two closed outlines of equally many points, counter-clockwise from above; closed
// above.
void loft(Street& street, Surface surface, const std::vector<Vector3d>& low,
          const std::vector<Vector3d>& high);
std::vector<Vector3d> outline(const Frame& f, double u0, double u1, double w0, double w1, double z);

// A block that stands on something: no face below. A ledge's underside is seen too.
void block(Street& street, Surface surface, const Frame& f, double u0, double u1, double w0,
           double w1, double z0, double z1);
void ledge(Street& street, Surface surface, const Frame& f, double u0, double u1, double w0,
           double w1, double z0, double z1);

// Closed at its far end only.
void cylinder(Street& street, Surface surface, const Vector3d& base, const Vector3d& axis,
              double base_radius_m, double top_radius_m, int sides);

struct Opening {
  double u0, u1, z0, z1;  // inside its cell
  double depth;
  Surface pane;
};

// A cell u0 .. u1 x z0 .. z1 of a wall with a recess: wall round it, reveals, pane.
void wall_cell(Street& street, Surface surface, const Frame& f, double u0, double u1, double z0,
               double z1, const Opening& o);

// A glTF 2.0 text file with its buffer inside. False: it cannot be written.
bool write_gltf(const Street& street, const std::string& file);

}  // namespace street
