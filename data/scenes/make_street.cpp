// Writes the street of street.toml: make_street OUT.gltf.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "data/scenes/street_buildings.h"

namespace street {
namespace {

constexpr double south_m = -4;  // where the ground begins; slabs of 4 m
constexpr int slabs = 23;

void road(Street& street) {
  const Frame f = {{0, south_m, 0}, {0, 1, 0}, {1, 0, 0}};  // u north, w east
  for (int i = 0; i < slabs; ++i) {  // a few of them mended; a camber of 6 cm
    const double u0 = i * 4.0, u1 = u0 + 4;
    for (double side : {-1.0, 1.0}) {
      const Surface surface = street.random() % 5 == 0 ? patch : asphalt;
      const double w0 = side < 0 ? -3.5 : 0, w1 = w0 + 3.5;
      const double z0 = side < 0 ? -0.06 : 0, z1 = -0.06 - z0;
      rectangle(street, surface,
                {f.at(u0, w1, z1), f.at(u1, w1, z1), f.at(u1, w0, z0), f.at(u0, w0, z0)});
    }
    block(street, paint, f, u0 + 1, u0 + 3, -0.06, 0.06, -0.01, 0.004);
  }
}

// Kerb stones and slabs with open joints over their bed.
void pavement(Street& street, double side) {
  const Frame f = {{0, south_m, 0}, {0, 1, 0}, {1, 0, 0}};
  const auto strip = [&](Surface surface, double u0, double u1, double near, double far, double z) {
    const double w = side * near, v = side * far;
    block(street, surface, f, u0, u1, std::min(w, v), std::max(w, v), -0.1, z);
  };
  for (int i = 0; i < slabs; ++i) {
    const double u0 = i * 4.0 + 0.01, u1 = u0 + 3.98;
    strip(kerb, u0, u1, 3.5, 3.68, 0.10);
    strip(paving, u0, u1, 3.69, 6.5, 0.09);
  }
  strip(patch, 0, slabs * 4.0, 3.6, 9, 0.07);
}

void buildings(Street& street) {
  // West: along north x up = east. East: the row runs south.
  row(street, {{-6.5, 1, 0}, {0, 1, 0}, {1, 0, 0}},
      {{9, 2, 0, plaster, false},
       {12, 3, 0.3, stone, true},
       {8, 4, 0, sooty, false},
       {13, 3, 0, brick, false},
       {10, 2, 0.6, plaster, true},
       {12, 4, 0, stone, false},
       {10, 3, 0, brick, true}});
  row(street, {{6.5, 76, 0}, {0, -1, 0}, {-1, 0, 0}},
      {{12, 3, 0, plaster, false},
       {9, 4, 0.3, brick, true},
       {13, 2, 0, stone, false},
       {10, 3, 0, sooty, true},
       {9, 4, 0.5, plaster, true},
       {12, 3, 0, brick, false},
       {10, 2, 0, stone, true}});
  // The street ends at a crossing: its far side closes the view.
  row(street, {{-14, 84, 0}, {1, 0, 0}, {0, -1, 0}},
      {{12, 4, 0, plaster, true}, {16, 3, 0.4, stone, true}});
}

void furniture(Street& street) {
  for (int i = 0; i < 6; ++i)
    lamp(street, i % 2 ? 1 : -1, 6 + 12 * i, i % 2 ? lamp_white : lamp_sodium);
  const double west[] = {9, 15, 26.5, 38, 57}, east[] = {3.5, 12.5, 24, 31, 46, 62};
  int i = 0;
  for (double y : west) car(street, i++ % 2 ? car_grey : car_blue, -2.5, y);
  for (double y : east) car(street, i++ % 3 ? car_red : car_grey, 2.5, y);
  for (int k = 0; k < 12; ++k)
    cylinder(street, metal, {k % 2 ? 3.95 : -3.95, 4.0 + 3.7 * k, 0.05}, {0, 0, 0.95}, 0.08, 0.06,
             8);
  for (double y : {9.6, 30.2, 43.1, 53.0})  // rainwater pipes
    for (double side : {-1.0, 1.0})
      cylinder(street, sooty, {6.42 * side, y, 0.05}, {0, 0, 9.5}, 0.05, 0.05, 6);
}

}  // namespace

static Street night_street() {
  Street street;
  road(street);
  for (double side : {-1.0, 1.0}) pavement(street, side);
  buildings(street);
  furniture(street);
  return street;
}

}  // namespace street

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("make_street: expected one argument: make_street OUT.gltf\n", stderr);
    return 2;
  }
  if (street::write_gltf(street::night_street(), argv[1])) return 0;
  std::fprintf(stderr, "make_street: %s: cannot write; expected a writable path\n", argv[1]);
  return 1;
}
