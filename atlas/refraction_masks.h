// The packed form of refraction masks that a renderer reads (raytrace/refraction_mask.h): for each
// diameter, oscillation set, view elevation and phase of the oscillation a square picture of exit
// directions and weights for each order, and outlines, finer in time than the masks. The pictures
// are round maps (trace_round_mask): of the outline, wherever it is; outlines are in mean radii r0.
//
// A phase k of n stands for the time k / (n - 1) of durations_s, which is what a streak picture of
// the drop shows, a single one for half of it; an instant of the outlines for (k + 0.5) / n.
//
// On disk: DIR/masks.exr, two parts of 32-bit floats, ZIP ("exits": channels X, Y, Z, the direction
// to the right, up and onward, and weight W; masks one below the other, orders side by side;
// "outlines": channel Y, a row for each instant), and DIR/masks.json, written last, with the tables
// and the hash of the other.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

struct RefractionMasks {
  static constexpr int version = 1;
  int size_px = 0;   // of each picture, square
  int orders = 0;    // 0 .. orders - 1
  int phases = 0;    // masks of a drop
  int instants = 0;  // outlines of a drop
  double refractive_index = 0;
  double cone_half_angle_rad = 0;        // of lights without a size of their own, as drops see them
  std::vector<int> diameters_um = {};    // ascending
  std::vector<double> durations_s = {};  // of each: the time that its masks and outlines show
  std::vector<int> oscillations = {};    // ascending
  std::vector<int> view_elevations_deg = {};  // ascending
  Image exits = {};     // 4 channels, orders * size_px wide, mask_count * size_px high
  Image outlines = {};  // 1 channel: distances from the centre, equal angles from the right to up;
                        // mask_count / phases * instants high
};

std::size_t mask_count(const RefractionMasks& masks);
constexpr std::size_t most_masks = 65536;

// Which mask of the pictures; indices into the tables above.
struct MaskPlace {
  std::size_t diameter = 0, oscillation = 0, view = 0, phase = 0;
};
std::size_t mask_index(const RefractionMasks& masks, const MaskPlace& place);

// Direction and weight of a pixel.
std::array<float, 4> mask_texel(const RefractionMasks& masks, std::size_t mask, int order,
                                int column, int row);

// Throws std::runtime_error for a folder or file that cannot be written.
void write_refraction_masks(const std::string& folder, const RefractionMasks& masks);

// Throws std::runtime_error "FILE: found; expected" for what is not there, not whole or of another
// shape.
RefractionMasks read_refraction_masks(const std::string& folder);

}  // namespace pluvia
