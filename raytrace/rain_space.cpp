#include "raytrace/rain_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "raytrace/drop_motion.h"
#include "raytrace/local_size.h"
#include "raytrace/scene_tops.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double longest_time_s = 1e7;
constexpr double drops_per_cell = 128;  // a shader's group holds 256: 11 standard deviations more
constexpr double most_drops_per_cell = 500;
constexpr double farthest_m = 1e5;      // from any camera to any drop of a box
constexpr double finest_cell_m = 1e-3;  // their numbers stay integers up to 1e6 m from the origin

// Poisson's distribution function, up to where 2^-33 is left.
std::vector<double> poisson(double mean) {
  std::vector<double> result;
  double term = std::exp(-mean), sum = term;
  for (int n = 1; sum < 1 - 1e-10 && n < 1000; ++n) {
    result.push_back(sum);
    term *= mean / n;
    sum += term;
  }
  result.push_back(1);
  return result;
}

// Where a fall through a place of the frame's plane leads through the density map: linear in x and
// y.
void set_density(const DensityMap& map, RainSizeSpace& size) {
  if (map.share.empty()) return;
  const FallFrame& frame = size.frame;
  const auto through = [&](double x, double y) -> Eigen::Vector2d {
    const Eigen::Vector3d across = x * frame.x + y * frame.y;
    const Eigen::Vector3d at = across + (map.height_m - across.z()) / frame.z.z() * frame.z;
    return density_texel(map, at.head<2>());
  };
  size.density_origin = through(0, 0);
  size.density_axes.col(0) = through(1, 0) - size.density_origin;
  size.density_axes.col(1) = through(0, 1) - size.density_origin;
}

int top_for(const Scene& scene, const FallFrame& frame, RainSpace& space) {
  for (const RainSizeSpace& other : space.sizes) {
    if (same_fall(other.frame, frame)) return other.top;
  }
  space.tops.push_back(scene_top(scene, frame));
  return static_cast<int>(space.tops.size()) - 1;
}

void add_size(const Scene& scene, const RainSize& drops, const FallFrame& frame, RainSpace& space) {
  const auto index = static_cast<std::uint32_t>(space.sizes.size());
  const std::uint64_t seed = scene.rain.seed;
  RainSizeSpace size;
  size.drops = drops;
  size.frame = frame;
  size.speed_m_s = drops.velocity_m_s.norm();
  size.stream =
      rain_hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), index);
  size.top = top_for(scene, size.frame, space);
  if (drops.drops_per_m3 > 0) set_density(scene.rain.density, size);
  size.box_x = box_along(scene.rain, size.frame.x);
  size.box_y = box_along(scene.rain, size.frame.y);
  size.box_z = box_along(scene.rain, size.frame.z);
  if (drops.drops_per_m3 > 0) {
    const double per_m2 = drops.drops_per_m3 * space.local_height_m;
    // Cells much wider than the prism would make it larger than asked for.
    size.cell_m = std::clamp(std::sqrt(drops_per_cell / per_m2), finest_cell_m,
                             std::max(finest_cell_m, space.culling_radius_m / 4));
    if (per_m2 * size.cell_m * size.cell_m > most_drops_per_cell)
      throw std::runtime_error(
          fmt::format("rain: {:.3g} drops over a square metre; expected at most {:.3g}", per_m2,
                      most_drops_per_cell / (finest_cell_m * finest_cell_m)));
    size.count_at_most = poisson(per_m2 * size.cell_m * size.cell_m);
  }
  space.sizes.push_back(size);
}

void add_single_drops(const Scene& scene, RainSpace& space) {
  for (const SingleDrop& drop : scene.drops) {
    const auto same = std::find_if(space.sizes.begin(), space.sizes.end(), [&](const auto& size) {
      return size.drops.r0_m == drop.r0_m && size.drops.velocity_m_s == drop.velocity_m_s &&
             same_fall(size.frame, fall_frame(drop.velocity_m_s));
    });
    space.single_sizes.push_back(static_cast<int>(same - space.sizes.begin()));
    if (same == space.sizes.end())
      add_size(scene, {.r0_m = drop.r0_m, .velocity_m_s = drop.velocity_m_s},
               fall_frame(drop.velocity_m_s), space);
  }
}

}  // namespace

std::array<std::uint32_t, 3> rain_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::array<std::uint32_t, 3> v = {a, b, c};
  const auto mix = [&v] {
    v[0] += v[1] * v[2];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
  };
  for (std::uint32_t& word : v) word = word * 1664525u + 1013904223u;
  mix();
  for (std::uint32_t& word : v) word ^= word >> 16;
  mix();
  return v;
}

double extinction_per_m(const RainSize& size) {
  return size.drops_per_m3 * pi * size.r0_m * size.r0_m;
}

namespace {

// Around the camera where it has the most.
double expected_drops(const Scene& scene, const RainSpace& space) {
  constexpr int cameras_of_a_path = 16;
  double most = 0;
  for (const Camera& camera : camera_samples(scene, cameras_of_a_path)) {
    double sum = 0;
    for (std::size_t i = 0; i < scene.rain.sizes.size(); ++i) {
      const RainSizeSpace& size = space.sizes[i];
      const int index = static_cast<int>(i);
      const LocalSpace local = local_space(space, index, camera.position_m, 0);
      const CellRange cells = local_cells(space, index, local);
      if (cells.x0 >= cells.x1 || cells.y0 >= cells.y1) continue;
      const double area_m2 = std::min(pi * space.culling_radius_m * space.culling_radius_m,
                                      rain_area_m2(scene.rain, size, cells));
      const double height_m = std::min(space.local_height_m, size.box_z.high_m - size.box_z.low_m);
      sum += size.drops.drops_per_m3 * area_m2 * height_m;
    }
    most = std::max(most, sum);
  }
  return most;
}

// Drops that move by steps are drawn wherever they are.
LocalSize whole_box(const Rain& rain) {
  return {.radius_m = farthest_m, .height_m = rain.box_max_m.z() - rain.box_min_m.z()};
}

}  // namespace

RainSpace make_rain_space(const Scene& scene) {
  RainSpace space;
  const bool by_steps = needs_motion(scene.rain);
  if (!scene.rain.sizes.empty()) {
    const LocalSize size = by_steps ? whole_box(scene.rain) : choose_local_size(scene);
    space.culling_radius_m = size.radius_m;
    space.local_height_m = size.height_m;
    space.lost_share = size.lost_share;
  }
  for (const RainSize& size : scene.rain.sizes)
    add_size(scene, size, by_steps ? FallFrame() : fall_frame(size.velocity_m_s), space);
  space.expected_drops = expected_drops(scene, space);
  if (space.expected_drops > most_local_drops)
    throw std::runtime_error(fmt::format(
        "rain: {:.3g} drops within {:.3g} m of the camera and a height of {:.3g} m; expected at "
        "most {:.0f}: a smaller box, culling_radius_m or local_height_m, or a greater lost_share",
        space.expected_drops, space.culling_radius_m, space.local_height_m, most_local_drops));
  add_single_drops(scene, space);
  return space;
}

LocalSpace local_space(const RainSpace& space, int size_index, const Eigen::Vector3d& camera_m,
                       double time_s) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const double floor_m = slab_floor_m(camera_m.dot(size.frame.z), space.local_height_m, size.box_z);
  return local_space_at(space, size_index, camera_m, floor_m, time_s);
}

LocalSpace local_space_at(const RainSpace& space, int size_index, const Eigen::Vector3d& camera_m,
                          double floor_m, double time_s) {
  if (!(time_s >= 0 && time_s <= longest_time_s))
    throw std::runtime_error(
        fmt::format("rain at time {} s; expected 0 .. {} s", time_s, longest_time_s));
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const double height_m = space.local_height_m;
  LocalSpace local;
  local.centre_m = {camera_m.dot(size.frame.x), camera_m.dot(size.frame.y)};
  if (size.cell_m == 0) return local;
  local.floor_m = floor_m;
  const double run_m = time_s * size.speed_m_s + local.floor_m;
  double offset_m = std::fmod(run_m, height_m);  // exact
  if (offset_m < 0) offset_m += height_m;
  if (offset_m >= height_m) offset_m = 0;  // what rounds to a whole height
  const double rounds = std::round((run_m - offset_m) / height_m);
  local.phase = static_cast<std::uint32_t>(std::ldexp(offset_m / height_m, 32));
  local.round = static_cast<std::uint32_t>(static_cast<std::int64_t>(rounds));
  return local;
}

RainCell rain_cell(const RainSizeSpace& size, int x, int y) {
  const auto ux = static_cast<std::uint32_t>(x), uy = static_cast<std::uint32_t>(y);
  const double at = std::ldexp(rain_hash(size.stream[1], ux, uy)[0] + 0.5, -32);
  const auto& table = size.count_at_most;
  const auto found = std::lower_bound(table.begin(), table.end(), at);
  return {x, y, static_cast<std::uint32_t>(found - table.begin()),
          rain_hash(size.stream[0], ux, uy)};
}

CellRange local_cells(const RainSpace& space, int size_index, const LocalSpace& local) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const double reach_m = space.culling_radius_m;
  const auto index = [&](double at_m) { return static_cast<int>(std::floor(at_m / size.cell_m)); };
  const auto between = [&](double centre_m, const Extent& box, int& first, int& end) {
    first = index(std::max(centre_m - reach_m, box.low_m));
    end = index(std::min(centre_m + reach_m, box.high_m)) + 1;
  };
  CellRange cells;
  between(local.centre_m.x(), size.box_x, cells.x0, cells.x1);
  between(local.centre_m.y(), size.box_y, cells.y0, cells.y1);
  return cells;
}

namespace {

struct TexelRectangle {
  Eigen::Vector2d low = {1e300, 1e300}, high = {-1e300, -1e300};
};

TexelRectangle density_texels(const RainSizeSpace& size, const CellRange& cells) {
  TexelRectangle texels;
  for (const int x : {cells.x0, cells.x1}) {
    for (const int y : {cells.y0, cells.y1}) {
      const Eigen::Vector2d at =
          size.density_origin + size.density_axes * (size.cell_m * Eigen::Vector2d(x, y));
      texels.low = texels.low.cwiseMin(at);
      texels.high = texels.high.cwiseMax(at);
    }
  }
  return texels;
}

}  // namespace

double rain_area_m2(const Rain& rain, const RainSizeSpace& size, const CellRange& cells) {
  if (rain.density.share.empty())
    return size.cell_m * size.cell_m * static_cast<double>(cells.x1 - cells.x0) *
           static_cast<double>(cells.y1 - cells.y0);
  const TexelRectangle texels = density_texels(size, cells);
  const double texel_m2 = 1 / std::abs(size.density_axes.determinant());
  return texel_m2 * density_sum(rain.density, texels.low, texels.high);
}

double rain_share(const Rain& rain, const RainSizeSpace& size, const CellRange& cells) {
  if (rain.density.share.empty()) return 1;
  const TexelRectangle texels = density_texels(size, cells);
  return density_mean(rain.density, texels.low, texels.high);
}

bool in_prism(const RainSpace& space, int size_index, const LocalSpace& local, int x, int y) {
  const double cell_m = space.sizes[static_cast<std::size_t>(size_index)].cell_m;
  const Eigen::Vector2d centre((x + 0.5) * cell_m, (y + 0.5) * cell_m);
  return (centre - local.centre_m).norm() <= space.culling_radius_m;
}

}  // namespace pluvia
