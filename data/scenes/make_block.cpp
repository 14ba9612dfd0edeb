// Writes the courtyard of courtyard.toml and passages.toml: make_block OUT.gltf. Four rows of
// houses around a court of 16 x 12 m, x east and y north, two passages through them and an arcade:
// all that a drop must not be seen under.
#include <cstdio>

#include "data/scenes/street_buildings.h"

namespace street {
namespace {

constexpr double court_x_m = 8, court_y_m = 6;  // half of its sides
constexpr double gate_m = 3.2;                  // width of a passage

// Upper floors alone, over a passage that is as wide: f.origin is its corner in the court.
void gate(Street& street, const Building& b, const Frame& f) {
  const double top_m = ground_floor_m + b.floors * upper_floor_m;
  ledge(street, b.wall, f, 0, b.width_m, -depth_m, -0.5, ground_floor_m, top_m);
  ledge(street, b.wall, f, 0, b.width_m, -0.5, -0.3, ground_floor_m, ground_floor_m + 0.3);
  for (int floor = 0; floor < b.floors; ++floor) {
    const double z = ground_floor_m + floor * upper_floor_m, middle = b.width_m / 2;
    wall_cell(street, b.wall, f, 0, b.width_m, z, z + upper_floor_m,
              {middle - 0.5, middle + 0.5, z + 0.75, z + 2.45, 0.18, pane_of_room(street)});
    ledge(street, trim, f, 0, b.width_m, 0, 0.1, z - 0.08, z + 0.1);
  }
  // The arch's soffit between the wall's face and the houses behind.
  ledge(street, stone, f, 0, b.width_m, -0.5, 0, ground_floor_m - 0.25, ground_floor_m);
  roof_of(street, b, f, top_m);
}

// Two houses with a passage between them.
void gated_row(Street& street, Frame f, const Building& left, const Building& right) {
  building(street, left, f);
  f.origin += left.width_m * f.along;
  gate(street, {gate_m, left.floors, 0, left.wall, false}, f);
  f.origin += gate_m * f.along;
  building(street, right, f);
}

// A roof on posts along a wall.
void arcade(Street& street, const Frame& f, double length_m) {
  ledge(street, stone, f, 0, length_m, 0, 2.6, 3.0, 3.3);
  for (int i = 0; i <= 4; ++i) {
    const double u = 0.2 + i * (length_m - 0.4) / 4;
    cylinder(street, stone, f.at(u, 2.35, 0), {0, 0, 3.0}, 0.16, 0.14, 10);
  }
}

void ground(Street& street) {
  // Slabs of 2 m with open joints over their bed.
  const Frame f = {{-court_x_m - depth_m, -court_y_m - depth_m, 0}, {1, 0, 0}, {0, 1, 0}};
  const int across = static_cast<int>(court_x_m + depth_m),
            along = static_cast<int>(court_y_m + depth_m);
  for (int j = 0; j < along; ++j) {
    for (int i = 0; i < across; ++i) {
      const Surface slab = street.random() % 6 == 0 ? patch : paving;
      const double u = 2 * i, w = 2 * j;
      rectangle(street, slab,
                {f.at(u + 0.01, w + 0.01, 0), f.at(u + 1.99, w + 0.01, 0),
                 f.at(u + 1.99, w + 1.99, 0), f.at(u + 0.01, w + 1.99, 0)});
    }
  }
  rectangle(street, kerb,
            {f.at(0, 0, -0.02), f.at(2 * across, 0, -0.02), f.at(2 * across, 2 * along, -0.02),
             f.at(0, 2 * along, -0.02)});
}

Street block_of_houses() {
  Street street;
  ground(street);
  const double side_m = court_x_m - gate_m / 2;
  gated_row(street, {{-court_x_m, court_y_m, 0}, {1, 0, 0}, {0, -1, 0}},
            {side_m, 2, 0, plaster, false}, {side_m, 2, 0, brick, false});
  gated_row(street, {{court_x_m, -court_y_m, 0}, {-1, 0, 0}, {0, 1, 0}},
            {side_m, 3, 0, stone, false}, {side_m, 2, 0, plaster, false});
  row(street, {{-court_x_m, -court_y_m, 0}, {0, 1, 0}, {1, 0, 0}},
      {{6, 3, 0, brick, false}, {6, 3, 0, sooty, false}});
  row(street, {{court_x_m, court_y_m, 0}, {0, -1, 0}, {-1, 0, 0}}, {{12, 2, 0, stone, true}});
  arcade(street, {{court_x_m, court_y_m, 0}, {0, -1, 0}, {-1, 0, 0}}, 2 * court_y_m);
  car(street, car_red, -5.6, -3.8);
  for (const double x : {-2.4, 2.4})
    cylinder(street, sooty, {x, court_y_m - 0.1, 0.05}, {0, 0, 8}, 0.05, 0.05, 6);
  return street;
}

}  // namespace
}  // namespace street

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("make_block: expected one argument: make_block OUT.gltf\n", stderr);
    return 2;
  }
  if (street::write_gltf(street::block_of_houses(), argv[1])) return 0;
  std::fprintf(stderr, "make_block: %s: cannot write; expected a writable path\n", argv[1]);
  return 1;
}
