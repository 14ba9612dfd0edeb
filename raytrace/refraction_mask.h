// What a drop does to each line of sight: the mask of model C (Rousseau, Jolivet and Ghazanfarpour,
// "Realistic real-time rain rendering", Computers and Graphics 30, 2006), which holds where the
// straight refraction (p = 1) of a drop points. Here a mask has every order that is kept, its share
// of the light, and comes from the tracer (raytrace/exit_paths.h) for any shape:
//
//   radiance of a pixel = coverage (sum_p weight_p L(direction_p) + tail L(anywhere else))
//
// A mask is a square orthographic picture about the drop's origin: pixel (i, j) is centred at
//   right = ((i + 0.5) / size_px - 0.5) 2 half_width_m,  up = (0.5 - (j + 0.5) / size_px) 2
//   half_width_m.
// Directions are in the view's axes (x right, y up, z onward: away from the camera). A perspective
// camera at distance d sees the drop along lines that differ by up to r0 / d from the mask's: a
// renderer turns the mask to the line to each pixel, and errs in where on the drop that line
// enters, by r0 / (2 d) of r0 at the rim.
//
// A pixel whose centre the outline leaves out has the values of the point on the way to the
// outline's centre that is at rim_share of the outline, so that all pixels are finite and a filter
// across the rim finds no step. Pure functions, same bytes for any number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "oscillation/drop_shape.h"
#include "raytrace/exit_field.h"
#include "raytrace/exit_paths.h"

namespace pluvia {

// Of the distance to the outline; beyond it refraction turns by a degree within a thousandth of it.
constexpr double rim_share = 0.999;

struct MaskGrid {
  int size_px = 48;         // 1 .. 4096
  double half_width_m = 0;  // > 0
};

struct MaskExit {
  Eigen::Vector3d direction = {0, 0, 1};  // toward the light, unit
  double weight = 0;                      // share of unpolarised light, 0 .. 1
};

struct RefractionMask {
  MaskGrid grid = {};
  int max_order = 0;
  std::vector<double> coverage = {};  // share of each pixel's area within the outline; row by row
  std::vector<MaskExit> exits = {};   // order after order, each row by row
  std::vector<double> tail = {};      // of each pixel: 1 - its weights
  // The greatest share of a pixel's light that leaves by a second path of the same order (of a
  // concave drop that the light meets again): it counts, in the direction of the brightest path.
  double astray = 0;

  const MaskExit& exit(int order, int column, int row) const {
    const auto size = static_cast<std::size_t>(grid.size_px);
    return exits[(static_cast<std::size_t>(order) * size + static_cast<std::size_t>(row)) * size +
                 static_cast<std::size_t>(column)];
  }
};

// All orders 0 .. paths.max_order. An order that carries no light from a pixel (total reflection,
// an index of 1) has weight 0 and a finite direction. Throws std::invalid_argument for a grid out
// of range and a drop whose surface does not enclose its origin.
RefractionMask trace_refraction_mask(const DropInstant& drop, const View& view,
                                     const MaskGrid& grid, const PathOptions& paths);

// The same for a round map that is fine where refraction changes fast: pixel centres span q in
// [-1, 1]^2, q at the outline where |q| = 1, and its point of the picture is
//   centre + sin(min(|q|, 1) pi / 2) outline(q) q / |q|,
// so that of a sphere |q| is the angle of incidence, in which directions are smooth up to the rim,
// where the distance from the axis has a square root. Without coverage; grid.half_width_m = 0.
// size_px 2 .. 4096.
RefractionMask trace_round_mask(const DropInstant& drop, const View& view, int size_px,
                                const PathOptions& paths);

// The point of the picture (right, up, from the drop's origin) for which a pixel has its values.
Eigen::Vector2d mask_place_m(const DropInstant& drop, const View& view, const MaskGrid& grid,
                             int column, int row);

// Distance from the drop's origin to its outline at `angles` equal angles from the right toward up.
std::vector<double> outline_from_origin_m(const DropInstant& drop, const View& view, int angles);

}  // namespace pluvia
