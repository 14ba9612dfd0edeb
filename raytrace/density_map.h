// Where rain falls: a grey picture over a rectangle of the ground, white for all of the rain, black
// for none. It lies at the height of the top of the rain's box, and a drop takes the value of the
// texel through which its fall leads.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace pluvia {

struct DensityMap {  // no texels: rain everywhere
  int width = 0, height = 0;
  std::vector<float> share = {};   // 0 .. 1, row by row; row 0 is the north edge
  Eigen::Vector2d min_m = {0, 0};  // of the rectangle: west, south
  Eigen::Vector2d max_m = {0, 0};  // east, north
  double height_m = 0;
  std::vector<double> sums = {};  // (width + 1) x (height + 1): of all texels above and to the left
};

// Any picture that stb_image reads, 8 or 16 bits; all channels alike. Throws std::runtime_error
// "FILE: what was found; expected ..".
DensityMap read_density_map(const std::string& file, const Eigen::Vector2d& min_m,
                            const Eigen::Vector2d& max_m, double height_m);

// Fills `sums` from `share`.
void sum_density(DensityMap& map);

// Over the map; 1 without one.
double mean_density(const DensityMap& map);

// Texel coordinates (column, row) of a place of the plane.
Eigen::Vector2d density_texel(const DensityMap& map, const Eigen::Vector2d& place_m);

// The texel that contains texel coordinates; 0 outside the map. There is a map.
double density_of_texel(const DensityMap& map, const Eigen::Vector2d& at);

// The sum of all texels that a rectangle of texel coordinates touches: 0 only where no rain falls
// in it. There is a map.
double density_sum(const DensityMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

// The same over how many they are; 0 for none.
double density_mean(const DensityMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

}  // namespace pluvia
