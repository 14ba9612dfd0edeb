// Houses, cars and lamps, for the programs that write the scenes' surfaces.
#pragma once

#include <vector>

#include "data/scenes/street_shapes.h"

namespace street {

struct Building {
  double width_m;
  int floors;
  double set_back_m;
  Surface wall;
  bool shop_below;
};

constexpr double ground_floor_m = 3.6, upper_floor_m = 3.1, depth_m = 10;

// Faces f.out; f.origin is its corner on the pavement at u = 0.
void building(Street& street, const Building& b, Frame f);

// The eaves, the roof and two chimneys of a house whose walls end at top_m.
void roof_of(Street& street, const Building& b, const Frame& f, double top_m);

// One room in three is lit.
Surface pane_of_room(Street& street);

// A row along f until its length is built on.
void row(Street& street, Frame f, const std::vector<Building>& buildings);

void car(Street& street, Surface paint_color, double x, double y);

// Side -1 stands on the west pavement, 1 on the east; the head reaches over the road. Its
// panel, 6.5 m above the road at x = 2.55 side, is what street.toml has its lamps 5 cm below.
void lamp(Street& street, double side, double y, Surface panel);

}  // namespace street
