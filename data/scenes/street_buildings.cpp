#include "data/scenes/street_buildings.h"

#include <algorithm>

namespace street {

Surface pane_of_room(Street& street) {
  const auto draw = street.random() % 32;
  if (draw < 5) return dim_room;
  if (draw < 9) return lit_room;
  return draw < 11 ? bright_room : glass;
}

namespace {

void ground_floor(Street& street, const Building& b, const Frame& f, int columns, double height_m) {
  const double cell = b.width_m / columns;
  const int door_column = static_cast<int>(street.random() % static_cast<unsigned>(columns));
  const Surface shop_pane = street.random() % 3 ? shop : glass;
  for (int i = 0; i < columns; ++i) {
    const double u = i * cell, middle = u + cell / 2;
    Opening o = {middle - 0.55, middle + 0.55, 0.95, 2.6, 0.2, pane_of_room(street)};
    if (b.shop_below) o = {u + 0.2, u + cell - 0.2, 0.5, 2.75, 0.35, shop_pane};
    if (i == door_column) o = {middle - 0.55, middle + 0.55, 0.12, 2.45, 0.4, door};
    wall_cell(street, b.wall, f, u, u + cell, 0, height_m, o);
    if (i == door_column) block(street, stone, f, middle - 0.8, middle + 0.8, 0, 0.35, 0, 0.14);
  }
  if (b.shop_below) ledge(street, trim, f, 0.1, b.width_m - 0.1, 0, 0.25, 2.95, 3.3);
}

}  // namespace

void roof_of(Street& street, const Building& b, const Frame& f, double top_m) {
  ledge(street, trim, f, -0.1, b.width_m + 0.1, -0.4, 0.32, top_m - 0.1, top_m + 0.25);
  const double ridge_m = top_m + 0.25 + 1.6;
  loft(street, roof, outline(f, 0, b.width_m, -9.6, 0, top_m + 0.25),
       outline(f, 0, b.width_m, -6, -4, ridge_m));
  for (double u : {0.12, 0.78})
    block(street, brick, f, u * b.width_m, u * b.width_m + 0.9, -4.6, -4, top_m, ridge_m + 1.3);
}

void building(Street& street, const Building& b, Frame f) {
  f.origin -= b.set_back_m * f.out;
  const int columns = std::max(2, static_cast<int>(b.width_m / 2.3));
  const double cell = b.width_m / columns, top_m = ground_floor_m + b.floors * upper_floor_m;
  ground_floor(street, b, f, columns, ground_floor_m);
  for (int floor = 0; floor < b.floors; ++floor) {
    const double z = ground_floor_m + floor * upper_floor_m;
    ledge(street, trim, f, 0, b.width_m, 0, 0.1, z - 0.08, z + 0.1);
    for (int i = 0; i < columns; ++i) {
      const double middle = (i + 0.5) * cell;
      const Opening o = {middle - 0.5, middle + 0.5, z + 0.75,
                         z + 2.45,     0.18,         pane_of_room(street)};
      wall_cell(street, b.wall, f, i * cell, (i + 1) * cell, z, z + upper_floor_m, o);
      block(street, trim, f, o.u0 - 0.12, o.u1 + 0.12, 0, 0.14, o.z0 - 0.1, o.z0);
      if (b.wall == brick)
        block(street, stone, f, o.u0 - 0.15, o.u1 + 0.15, 0, 0.05, o.z1, o.z1 + 0.22);
    }
  }
  block(street, b.wall, f, 0, b.width_m, -depth_m, -0.5, 0, top_m);
  // The facade's thickness, seen where a neighbour stands back.
  rectangle(street, b.wall,
            {f.at(0, -0.5, 0), f.at(0, 0, 0), f.at(0, 0, top_m), f.at(0, -0.5, top_m)});
  rectangle(street, b.wall,
            {f.at(b.width_m, 0, 0), f.at(b.width_m, -0.5, 0), f.at(b.width_m, -0.5, top_m),
             f.at(b.width_m, 0, top_m)});
  roof_of(street, b, f, top_m);
}

void row(Street& street, Frame f, const std::vector<Building>& buildings) {
  for (const Building& b : buildings) {
    building(street, b, f);
    f.origin += b.width_m * f.along;
  }
}

void car(Street& street, Surface paint_color, double x, double y) {
  const Frame f = {{x, y, 0}, {0, 1, 0}, {1, 0, 0}};  // u along the car, 4.3 m x 1.76 m x 1.45 m
  const auto shape = [&](double u0, double u1, double w, double z) {
    return outline(f, u0, u1, -w, w, z);
  };
  loft(street, paint_color, shape(0.05, 4.25, 0.84, 0.22), shape(0, 4.3, 0.88, 0.45));
  loft(street, paint_color, shape(0, 4.3, 0.88, 0.45), shape(0.06, 4.25, 0.87, 0.72));
  loft(street, paint_color, shape(0.06, 4.25, 0.87, 0.72), shape(0.2, 4.05, 0.8, 0.88));
  loft(street, glass, shape(0.45, 3.05, 0.76, 0.88), shape(0.95, 2.45, 0.62, 1.36));
  loft(street, paint_color, shape(0.93, 2.47, 0.63, 1.36), shape(1.05, 2.35, 0.56, 1.45));
  for (double u : {0.85, 3.4})
    for (double side : {-1.0, 1.0})
      cylinder(street, tyre, f.at(u, side * 0.72, 0.27), f.out * (side * 0.18), 0.31, 0.29, 8);
  for (double side : {-1.0, 1.0}) {
    ledge(street, paint, f, 4.2, 4.29, side * 0.62 - 0.14, side * 0.62 + 0.14, 0.56, 0.68);
    ledge(street, car_red, f, 0.0, 0.06, side * 0.64 - 0.14, side * 0.64 + 0.14, 0.56, 0.7);
  }
}

void lamp(Street& street, double side, double y, Surface panel) {
  const double x = 4.1 * side;
  cylinder(street, metal, {x, y, 0.05}, {0, 0, 0.9}, 0.13, 0.11, 8);
  cylinder(street, metal, {x, y, 0.95}, {0, 0, 5.55}, 0.075, 0.05, 8);
  cylinder(street, metal, {x, y, 6.4}, {-1.2 * side, 0, 0.18}, 0.04, 0.035, 6);
  const Frame f = {{2.55 * side, y, 0}, {1, 0, 0}, {0, -1, 0}};
  loft(street, metal, outline(f, -0.42, 0.42, -0.17, 0.17, 6.5),
       outline(f, -0.36, 0.36, -0.11, 0.11, 6.66));
  rectangle(street, metal,
            {f.at(-0.42, -0.17, 6.505), f.at(0.42, -0.17, 6.505), f.at(0.42, 0.17, 6.505),
             f.at(-0.42, 0.17, 6.505)});
  rectangle(street, panel,
            {f.at(-0.34, -0.13, 6.5), f.at(0.34, -0.13, 6.5), f.at(0.34, 0.13, 6.5),
             f.at(-0.34, 0.13, 6.5)});
}

}  // namespace street
