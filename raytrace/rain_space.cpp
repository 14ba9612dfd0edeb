#include "raytrace/rain_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "raytrace/ray_stretch.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double longest_time_s = 1e7;
constexpr double drops_per_cell = 128;  // a shader's group holds 256: 11 standard deviations more
constexpr double most_drops_per_cell = 500;
constexpr double finest_cell_m = 1e-3;   // their numbers stay integers up to 1e6 m from the origin
constexpr double finest_texel_m = 0.05;  // of the top heights
constexpr double most_texels = 1 << 22;

// The box along an axis of a frame.
Extent box_along(const Rain& rain, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d middle = (rain.box_min_m + rain.box_max_m) / 2;
  const Eigen::Vector3d half = (rain.box_max_m - rain.box_min_m) / 2;
  const double at = middle.dot(axis), reach = axis.cwiseAbs().dot(half);
  return {at - reach, at + reach};
}

// The slab's lower end: around the camera, but inside the box as far as that can be.
double slab_floor_m(double camera_m, double height_m, const Extent& box) {
  return std::clamp(camera_m - height_m / 2, box.low_m, std::max(box.low_m, box.high_m - height_m));
}

struct ViewRays {  // of a camera, with the stretches that lie in the rain's box
  Eigen::Vector3d camera_m = {0, 0, 0};
  std::vector<Eigen::Vector3d> directions = {};
  std::vector<RayStretch> rain = {};
};

void add_ray(const Rain& rain, const Eigen::Vector3d& direction, ViewRays& rays) {
  RayStretch stretch;
  for (int axis = 0; axis < 3; ++axis)
    clip(rays.camera_m[axis], direction[axis], rain.box_min_m[axis], rain.box_max_m[axis], stretch);
  if (!(stretch.from < stretch.to)) return;
  rays.directions.push_back(direction);
  rays.rain.push_back(stretch);
}

// Toward points of a box that is small in the picture; inside_picture: those that it shows alone.
void add_rays_to_box(const Camera& camera, const Rain& rain, bool inside_picture, ViewRays& rays) {
  constexpr int side = 6;
  const CameraFrame frame = camera_frame(camera);
  const double slope_x = camera.width_px / 2.0 / frame.focal_px;
  const double slope_y = camera.height_px / 2.0 / frame.focal_px;
  for (int i = 0; i < side * side * side; ++i) {
    const Eigen::Vector3d share = (Eigen::Vector3d(i % side, i / side % side, i / side / side) +
                                   Eigen::Vector3d::Constant(0.5)) /
                                  side;
    const Eigen::Vector3d to =
        rain.box_min_m + share.cwiseProduct(rain.box_max_m - rain.box_min_m) - camera.position_m;
    const double depth_m = to.dot(frame.forward);
    const bool shown = depth_m > 0 && std::abs(to.dot(frame.right)) < slope_x * depth_m &&
                       std::abs(to.dot(frame.up)) < slope_y * depth_m;
    if ((shown || !inside_picture) && to.norm() > 0) add_ray(rain, to.normalized(), rays);
  }
}

ViewRays view_rays(const Camera& camera, const Rain& rain) {
  constexpr int columns = 32, rows = 18;
  constexpr std::size_t few = 32;  // a share of so few rays is a guess
  const CameraFrame frame = camera_frame(camera);
  ViewRays rays = {.camera_m = camera.position_m};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = ((i + 0.5) / columns - 0.5) * camera.width_px / frame.focal_px;
      const double y = (0.5 - (j + 0.5) / rows) * camera.height_px / frame.focal_px;
      add_ray(rain, (frame.forward + x * frame.right + y * frame.up).normalized(), rays);
    }
  }
  if (rays.directions.size() < few) add_rays_to_box(camera, rain, true, rays);
  if (rays.directions.size() < few) add_rays_to_box(camera, rain, false, rays);
  return rays;
}

// int exp(-sigma s) ds over the stretch, times sigma.
double seen(const RayStretch& stretch, double sigma) {
  if (!(stretch.from < stretch.to)) return 0;
  return std::exp(-sigma * stretch.from) * -std::expm1(-sigma * (stretch.to - stretch.from));
}

struct LossModel {  // of one camera and one direction of fall
  const ViewRays& rays;
  const Rain& rain;
  FallFrame frame;
  double sigma = 0;

  double share(double radius_m, double height_m) const {
    const double camera_z = rays.camera_m.dot(frame.z);
    const double floor = slab_floor_m(camera_z, height_m, box_along(rain, frame.z));
    double kept = 0, all = 0;
    for (std::size_t i = 0; i < rays.directions.size(); ++i) {
      const Eigen::Vector3d& d = rays.directions[i];
      const double across = std::hypot(d.dot(frame.x), d.dot(frame.y));
      RayStretch local = rays.rain[i];
      local.to = std::min(local.to, across > 0 ? radius_m / across : local.to);
      clip(camera_z, d.dot(frame.z), floor, floor + height_m, local);
      kept += seen(local, sigma);
      all += seen(rays.rain[i], sigma);
    }
    return all > 0 ? std::max(0.0, 1 - kept / all) : 0;
  }
};

std::vector<ViewRays> all_view_rays(const Scene& scene) {
  constexpr int cameras_of_a_path = 16;
  std::vector<ViewRays> rays;
  for (const Camera& camera : camera_samples(scene, cameras_of_a_path))
    rays.push_back(view_rays(camera, scene.rain));
  return rays;
}

std::vector<LossModel> loss_models(const Rain& rain, const std::vector<ViewRays>& all_rays) {
  std::vector<LossModel> models;
  // So thin a rain that nothing is dimmed: distance alone counts, and the share has the same limit.
  double sigma = 1e-9;
  for (const RainSize& size : rain.sizes)
    sigma += mean_density(rain.density) * extinction_per_m(size);
  std::vector<FallFrame> frames;  // sizes that fall alike lose alike
  for (const RainSize& size : rain.sizes) {
    const FallFrame frame = fall_frame(size.velocity_m_s);
    const bool known = std::any_of(frames.begin(), frames.end(),
                                   [&](const FallFrame& other) { return same_fall(frame, other); });
    if (!known) frames.push_back(frame);
  }
  for (const ViewRays& rays : all_rays) {
    for (const FallFrame& frame : frames) models.push_back({rays, rain, frame, sigma});
  }
  return models;
}

double greatest_share(const std::vector<LossModel>& models, double radius_m, double height_m) {
  double share = 0;
  for (const LossModel& model : models) share = std::max(share, model.share(radius_m, height_m));
  return share;
}

// The least value in [low, high] that keeps the bound, to a hundredth; high where none does.
template <class Share>
double least_within(double low, double high, double bound, Share share) {
  if (share(low) <= bound) return low;
  for (int i = 0; i < 60 && high > 1.01 * low; ++i) {
    const double middle = std::sqrt(low * high);
    (share(middle) <= bound ? high : low) = middle;
  }
  return high;
}

struct LocalSize {
  double radius_m = 0, height_m = 0;
};

constexpr double least_size_m = 0.05, most_size_m = 1e4;

LocalSize choose_size(const Rain& rain, const std::vector<LossModel>& models) {
  LocalSize best = {rain.culling_radius_m, rain.local_height_m};
  const auto radius_for = [&](double height_m) {
    return least_within(least_size_m, most_size_m, rain.lost_share,
                        [&](double r) { return greatest_share(models, r, height_m); });
  };
  if (best.radius_m > 0 && best.height_m > 0) return best;
  if (best.radius_m > 0) {
    best.height_m = least_within(least_size_m, most_size_m, rain.lost_share, [&](double h) {
      return greatest_share(models, best.radius_m, h);
    });
    return best;
  }
  if (best.height_m > 0) {
    best.radius_m = radius_for(best.height_m);
    return best;
  }
  double least_m3 = std::numeric_limits<double>::infinity();
  for (double height_m = least_size_m; height_m < 2 * most_size_m; height_m *= 1.25) {
    const double radius_m = radius_for(height_m);
    const double volume_m3 = pi * radius_m * radius_m * height_m;
    if (greatest_share(models, radius_m, height_m) > rain.lost_share || volume_m3 >= least_m3)
      continue;
    least_m3 = volume_m3;
    best = {radius_m, height_m};
  }
  // Nothing keeps the bound: as far as can be.
  return best.radius_m > 0 ? best : LocalSize{most_size_m, most_size_m};
}

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

// The mesh in the frame's plane, as far as drops are.
PlaneRect top_rect(const Scene& scene, const FallFrame& frame) {
  if (scene.mesh.positions_m.empty()) return {};
  PlaneRect rect = {1e300, 1e300, -1e300, -1e300};
  for (const Eigen::Vector3f& p : scene.mesh.positions_m) {
    const double x = p.cast<double>().dot(frame.x), y = p.cast<double>().dot(frame.y);
    rect.min_x_m = std::min(rect.min_x_m, x), rect.max_x_m = std::max(rect.max_x_m, x);
    rect.min_y_m = std::min(rect.min_y_m, y), rect.max_y_m = std::max(rect.max_y_m, y);
  }
  if (!scene.drops.empty()) return rect;  // a single drop falls anywhere
  const Extent x = box_along(scene.rain, frame.x), y = box_along(scene.rain, frame.y);
  rect.min_x_m = std::max(rect.min_x_m, x.low_m), rect.max_x_m = std::min(rect.max_x_m, x.high_m);
  rect.min_y_m = std::max(rect.min_y_m, y.low_m), rect.max_y_m = std::min(rect.max_y_m, y.high_m);
  return rect;
}

// All directions of fall share one budget of texels.
std::size_t count_falls(const Scene& scene) {
  std::vector<FallFrame> falls;
  const auto add = [&](const Eigen::Vector3d& velocity) {
    const FallFrame frame = fall_frame(velocity);
    for (const FallFrame& other : falls) {
      if (same_fall(frame, other)) return;
    }
    falls.push_back(frame);
  };
  for (const RainSize& size : scene.rain.sizes) add(size.velocity_m_s);
  for (const SingleDrop& drop : scene.drops) add(drop.velocity_m_s);
  return falls.size();
}

int top_for(const Scene& scene, const FallFrame& frame, RainSpace& space) {
  for (const RainSizeSpace& other : space.sizes) {
    if (same_fall(other.frame, frame)) return other.top;
  }
  const PlaneRect rect = top_rect(scene, frame);
  const double width = std::max(0.0, rect.max_x_m - rect.min_x_m);
  const double height = std::max(0.0, rect.max_y_m - rect.min_y_m);
  const double most = most_texels / static_cast<double>(count_falls(scene));
  const double texel_m = std::max(finest_texel_m, std::sqrt(width * height / most));
  space.tops.push_back(top_height(scene.mesh, frame, rect, texel_m));
  return static_cast<int>(space.tops.size()) - 1;
}

void add_size(const Scene& scene, const RainSize& drops, RainSpace& space) {
  const auto index = static_cast<std::uint32_t>(space.sizes.size());
  const std::uint64_t seed = scene.rain.seed;
  RainSizeSpace size;
  size.drops = drops;
  size.frame = fall_frame(drops.velocity_m_s);
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
      return size.drops.r0_m == drop.r0_m && size.drops.velocity_m_s == drop.velocity_m_s;
    });
    space.single_sizes.push_back(static_cast<int>(same - space.sizes.begin()));
    if (same == space.sizes.end())
      add_size(scene, {.r0_m = drop.r0_m, .velocity_m_s = drop.velocity_m_s}, space);
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

double lost_share(const Scene& scene, double culling_radius_m, double local_height_m) {
  const std::vector<ViewRays> rays = all_view_rays(scene);
  return greatest_share(loss_models(scene.rain, rays), culling_radius_m, local_height_m);
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

}  // namespace

RainSpace make_rain_space(const Scene& scene) {
  RainSpace space;
  if (!scene.rain.sizes.empty()) {
    const std::vector<ViewRays> rays = all_view_rays(scene);
    const std::vector<LossModel> models = loss_models(scene.rain, rays);
    const LocalSize size = choose_size(scene.rain, models);
    space.culling_radius_m = size.radius_m;
    space.local_height_m = size.height_m;
    space.lost_share = greatest_share(models, size.radius_m, size.height_m);
  }
  for (const RainSize& size : scene.rain.sizes) add_size(scene, size, space);
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
  if (!(time_s >= 0 && time_s <= longest_time_s))
    throw std::runtime_error(
        fmt::format("rain at time {} s; expected 0 .. {} s", time_s, longest_time_s));
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const double height_m = space.local_height_m;
  LocalSpace local;
  local.centre_m = {camera_m.dot(size.frame.x), camera_m.dot(size.frame.y)};
  if (size.cell_m == 0) return local;
  local.floor_m = slab_floor_m(camera_m.dot(size.frame.z), height_m, size.box_z);
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

double rain_area_m2(const Rain& rain, const RainSizeSpace& size, const CellRange& cells) {
  const double cell_m = size.cell_m;
  const double area_m2 = cell_m * cell_m * static_cast<double>(cells.x1 - cells.x0) *
                         static_cast<double>(cells.y1 - cells.y0);
  const DensityMap& map = rain.density;
  if (map.share.empty()) return area_m2;
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const int x : {cells.x0, cells.x1}) {
    for (const int y : {cells.y0, cells.y1}) {
      const Eigen::Vector2d at =
          size.density_origin + size.density_axes * (cell_m * Eigen::Vector2d(x, y));
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  }
  const double texel_m2 = 1 / std::abs(size.density_axes.determinant());
  return texel_m2 * density_sum(map, low, high);
}

bool in_prism(const RainSpace& space, int size_index, const LocalSpace& local, int x, int y) {
  const double cell_m = space.sizes[static_cast<std::size_t>(size_index)].cell_m;
  const Eigen::Vector2d centre((x + 0.5) * cell_m, (y + 0.5) * cell_m);
  return (centre - local.centre_m).norm() <= space.culling_radius_m;
}

}  // namespace pluvia
