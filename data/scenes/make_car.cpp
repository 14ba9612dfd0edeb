// Writes the car that drives through car.toml: make_car OUT.gltf. The car of the street, its middle
// at the origin and its bonnet to the north, with its head lamps lit and the floor that the parked
// ones lack: it is seen from everywhere.
#include <cstdio>

#include "data/scenes/street_buildings.h"

namespace street {
namespace {

Street moving_car() {
  Street street;
  constexpr double rear_m = -2.15;
  car(street, car_blue, 0, rear_m);
  const Frame f = {{0, rear_m, 0}, {0, 1, 0}, {1, 0, 0}};
  rectangle(street, sooty,
            {f.at(0.05, 0.84, 0.22), f.at(4.25, 0.84, 0.22), f.at(4.25, -0.84, 0.22),
             f.at(0.05, -0.84, 0.22)});
  for (const double side : {-0.62, 0.62})
    rectangle(street, lamp_white,
              {f.at(4.3, side + 0.13, 0.57), f.at(4.3, side - 0.13, 0.57),
               f.at(4.3, side - 0.13, 0.67), f.at(4.3, side + 0.13, 0.67)});
  return street;
}

}  // namespace
}  // namespace street

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("make_car: expected one argument: make_car OUT.gltf\n", stderr);
    return 2;
  }
  if (street::write_gltf(street::moving_car(), argv[1])) return 0;
  std::fprintf(stderr, "make_car: %s: cannot write; expected a writable path\n", argv[1]);
  return 1;
}
