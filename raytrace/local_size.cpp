#include "raytrace/local_size.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "raytrace/ray_stretch.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

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
  FallFrame frame;
  Extent box_z;  // the rain's box along the fall
  double sigma = 0;
  double all = 0;  // what the rays see of all rain

  double share(double radius_m, double height_m) const {
    const double camera_z = rays.camera_m.dot(frame.z);
    const double floor = slab_floor_m(camera_z, height_m, box_z);
    double kept = 0;
    for (std::size_t i = 0; i < rays.directions.size(); ++i) {
      const Eigen::Vector3d& d = rays.directions[i];
      const double across = std::hypot(d.dot(frame.x), d.dot(frame.y));
      RayStretch local = rays.rain[i];
      local.to = std::min(local.to, across > 0 ? radius_m / across : local.to);
      clip(camera_z, d.dot(frame.z), floor, floor + height_m, local);
      kept += seen(local, sigma);
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
  std::vector<Eigen::Vector3d> velocities;
  for (const RainSize& size : rain.sizes) velocities.push_back(size.velocity_m_s);
  const std::vector<FallFrame> frames = distinct_falls(velocities);  // what falls alike loses alike
  for (const ViewRays& rays : all_rays) {
    double all = 0;
    for (const RayStretch& stretch : rays.rain) all += seen(stretch, sigma);
    for (const FallFrame& frame : frames)
      models.push_back({rays, frame, box_along(rain, frame.z), sigma, all});
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

}  // namespace

Extent box_along(const Rain& rain, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d middle = (rain.box_min_m + rain.box_max_m) / 2;
  const Eigen::Vector3d half = (rain.box_max_m - rain.box_min_m) / 2;
  const double at = middle.dot(axis), reach = axis.cwiseAbs().dot(half);
  return {at - reach, at + reach};
}

double slab_floor_m(double camera_m, double height_m, const Extent& box) {
  return std::clamp(camera_m - height_m / 2, box.low_m, std::max(box.low_m, box.high_m - height_m));
}

std::vector<FallFrame> distinct_falls(const std::vector<Eigen::Vector3d>& velocities) {
  std::vector<FallFrame> falls;
  for (const Eigen::Vector3d& velocity : velocities) {
    const FallFrame frame = fall_frame(velocity);
    const bool known = std::any_of(falls.begin(), falls.end(),
                                   [&](const FallFrame& other) { return same_fall(frame, other); });
    if (!known) falls.push_back(frame);
  }
  return falls;
}

double lost_share(const Scene& scene, double culling_radius_m, double local_height_m) {
  const std::vector<ViewRays> rays = all_view_rays(scene);
  return greatest_share(loss_models(scene.rain, rays), culling_radius_m, local_height_m);
}

LocalSize choose_local_size(const Scene& scene) {
  const std::vector<ViewRays> rays = all_view_rays(scene);
  const std::vector<LossModel> models = loss_models(scene.rain, rays);
  LocalSize size = choose_size(scene.rain, models);
  size.lost_share = greatest_share(models, size.radius_m, size.height_m);
  return size;
}

}  // namespace pluvia
