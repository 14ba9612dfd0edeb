#include "raytrace/brute_force.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include "raytrace/ray_follower.h"
#include "raytrace/wide_intersect.h"
#include "raytrace/wide_paths.h"

namespace pluvia {

namespace {

// Sums of one replicate: planes of pixels (lights, environment, coverage).
struct Replicate {
  std::vector<double> pixels = {};
  double rays = 0;
};

// Along the view, and where its light goes.
struct CameraRay {
  Eigen::Vector3d from_m = {0, 0, 0};
  std::size_t pixel = 0;
};

struct BruteJob {
  const StreakRequest& request;
  const BruteOptions& options;
  const EmbreeDrop& embree;
  SphereMesh sphere = {};  // of mesh and polished_mesh
  double half_side_m = 0;
  double weight = 0;  // of a ray: the area that it stands for [px], over the number of them
  double cone_cosine = 0, cone_radiance = 0;
  std::vector<Eigen::Vector3d> lights = {};

  std::size_t plane_size() const {
    return static_cast<std::size_t>(request.frame.width_px) *
           static_cast<std::size_t>(request.frame.height_px);
  }

  Replicate run(int index) const {
    std::mt19937_64 random(options.seed * 1000003 + static_cast<std::uint64_t>(index));
    std::uniform_real_distribution<double> uniform(0, 1);
    Replicate sums;
    sums.pixels.assign(plane_size() * (lights.size() + 2), 0.0);
    for (int k = 0; k < options.instants; ++k) {
      const double share = (k + uniform(random)) / options.instants;
      const double shift_x = uniform(random), shift_y = uniform(random);
      trace_instant(share, shift_x, shift_y, sums);
    }
    return sums;
  }

  void trace_instant(double share, double shift_x, double shift_y, Replicate& sums) const {
    const DropInstant drop = drop_at(request.drop, share * request.exposure_s);
    const View view = view_from_elevation(request.view_elevation_deg);
    std::vector<CameraRay> rays;
    // Kronecker sequence of the plastic number (Roberts): low discrepancy in two dimensions.
    constexpr double a1 = 0.7548776662466927, a2 = 0.5698402909980532;
    for (int i = 0; i < options.rays_per_instant; ++i) {
      const double sx = std::fmod(shift_x + a1 * i, 1.0), sy = std::fmod(shift_y + a2 * i, 1.0);
      const double x = (2 * sx - 1) * half_side_m, y = (2 * sy - 1) * half_side_m;
      const Eigen::Vector3d from = x * view.right + y * view.up + 4 * half_side_m * view.to_camera;
      if (const auto pixel = pixel_of(share, x, y)) rays.push_back({from, *pixel});
    }
    if (options.follower == RayFollower::wide) {
      follow_wide(drop, view, rays, sums);
    } else if (options.follower == RayFollower::independent) {
      follow_each(AnalyticSurface{drop, embree}, view, rays, sums);
    } else {
      const MeshDrop triangles(drop, sphere);
      const bool polished = options.follower == RayFollower::polished_mesh;
      follow_each(MeshSurface{drop, triangles, sphere.gap, polished}, view, rays, sums);
    }
  }

  template <typename Surface>
  void follow_each(const Surface& surface, const View& view, const std::vector<CameraRay>& rays,
                   Replicate& sums) const {
    for (const CameraRay& ray : rays) follow_one(surface, view, ray, sums);
  }

  std::optional<std::size_t> pixel_of(double share, double x_m, double y_m) const {
    const StreakFrame& frame = request.frame;
    const double column = frame.centre_column + x_m / frame.pixel_m;
    const double row = frame.path_top_row + frame.path_rows * share - y_m / frame.pixel_m;
    const int c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
    if (c < 0 || c >= frame.width_px || r < 0 || r >= frame.height_px) return std::nullopt;
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(frame.width_px) +
           static_cast<std::size_t>(c);
  }

  template <typename Surface>
  void follow_one(const Surface& surface, const View& view, const CameraRay& camera_ray,
                  Replicate& sums) const {
    const auto hit = surface.meet(camera_ray.from_m, -view.to_camera, RaySide::outside);
    if (!hit) return;
    add_hit(camera_ray.pixel, sums);
    const StokesRay ray = {hit->position, -view.to_camera, view.right, {1, 0, 0, 0}};
    Follower<Surface>{surface, request.field.paths, options.polarised}.follow(
        ray, hit->normal, [&](const Eigen::Vector3d& direction, double power) {
          add_exit(camera_ray.pixel, direction, power, sums);
        });
  }

  void follow_wide(const DropInstant& drop, const View& view, const std::vector<CameraRay>& rays,
                   Replicate& sums) const {
    const Isa isa = request.field.isa;
    std::vector<DropRay> starts;
    for (const CameraRay& ray : rays) starts.push_back({ray.from_m, -view.to_camera});
    const auto met = intersect_drop_of(drop, starts, RaySide::outside, isa);
    std::vector<CameraHit> hits;
    std::vector<std::size_t> pixels;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      if (!met[k]) continue;
      add_hit(rays[k].pixel, sums);
      if (met[k]->normal.dot(view.to_camera) <= 0) continue;  // grazes: as follow() has it
      hits.push_back({met[k]->position, met[k]->normal});
      pixels.push_back(rays[k].pixel);
    }
    const HitExits traced = trace_exits_of(drop, hits, view.to_camera, request.field.paths, isa);
    for (std::size_t k = 0; k < hits.size(); ++k) {
      for (std::uint32_t e = traced.first_exit[k]; e < traced.first_exit[k + 1]; ++e) {
        add_exit(pixels[k], traced.exits[e].direction, traced.exits[e].throughput, sums);
      }
    }
  }

  void add_hit(std::size_t pixel, Replicate& sums) const {
    ++sums.rays;
    sums.pixels[(lights.size() + 1) * plane_size() + pixel] += weight;
  }

  void add_exit(std::size_t pixel, const Eigen::Vector3d& direction, double power,
                Replicate& sums) const {
    const double value = weight * power;
    sums.pixels[lights.size() * plane_size() + pixel] += value;
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (lights[k].dot(direction) < cone_cosine) continue;
      sums.pixels[k * plane_size() + pixel] += value * cone_radiance;
    }
  }
};

ReplicateMean estimate(const std::vector<double>& values) {
  ReplicateMean e;
  const double n = static_cast<double>(values.size());
  for (const double v : values) e.mean += v / n;
  double square = 0;
  for (const double v : values) square += (v - e.mean) * (v - e.mean);
  e.standard_error = std::sqrt(square / (n * (n - 1)));
  return e;
}

// One plane of all replicates: its picture, and the estimate of its sum.
ReplicateMean collect(const std::vector<Replicate>& replicates, std::size_t plane, std::size_t size,
                      StreakImage& image) {
  std::vector<double> fluxes(replicates.size(), 0.0), values(replicates.size());
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t r = 0; r < replicates.size(); ++r) {
      values[r] = replicates[r].pixels[plane * size + i];
      fluxes[r] += values[r];
    }
    const ReplicateMean e = estimate(values);
    image.mean.push_back(static_cast<float>(e.mean));
    image.variance.push_back(static_cast<float>(e.standard_error * e.standard_error));
  }
  return estimate(fluxes);
}

}  // namespace

BruteStreak brute_force_streak(const StreakRequest& request, const BruteOptions& options,
                               const std::function<void(double)>& progress) {
  assert(options.replicates >= 2 && options.instants >= 1 && options.rays_per_instant >= 1);
  if (request.cone_half_angle_rad == 0) {
    throw std::invalid_argument("cone_half_angle_rad = 0; expected a cone: no ray meets a point");
  }
  if (!options.polarised && options.follower == RayFollower::wide)
    throw std::invalid_argument("polarised = false; expected the independent follower");
  double bound = 1;  // over all instants, relative to r0
  for (int k = 0; k <= 64; ++k) {
    const DropInstant drop = drop_at(request.drop, request.exposure_s * k / 64);
    bound = std::max(bound, drop.bound_h * drop.surface.scale / request.drop.mean_radius_m +
                                drop.origin_m.norm() / request.drop.mean_radius_m);
  }
  const double radius = 1.02 * bound * request.drop.mean_radius_m;
  const EmbreeDrop embree(radius);
  const bool is_mesh =
      options.follower == RayFollower::mesh || options.follower == RayFollower::polished_mesh;
  BruteJob job{request, options, embree, is_mesh ? sphere_mesh(options.mesh_levels) : SphereMesh(),
               radius};
  job.weight = std::pow(2 * radius / request.frame.pixel_m, 2) /
               (static_cast<double>(options.rays_per_instant) * options.instants);
  const double sine = std::sin(request.cone_half_angle_rad);
  job.cone_cosine = std::cos(request.cone_half_angle_rad);
  job.cone_radiance = 1 / (std::numbers::pi * sine * sine);
  for (const LightDirection& l : request.lights) {
    job.lights.push_back(light_direction(l.elevation_deg, l.azimuth_deg));
  }
  std::vector<Replicate> replicates(static_cast<std::size_t>(options.replicates));
  std::mutex progress_mutex;
  int done = 0;
  tbb::parallel_for(0, options.replicates, [&](int r) {
    replicates[static_cast<std::size_t>(r)] = job.run(r);
    const std::lock_guard lock(progress_mutex);
    ++done;
    if (progress) progress(static_cast<double>(done) / options.replicates);
  });
  BruteStreak streak;
  const std::size_t size = job.plane_size();
  for (std::size_t k = 0; k < request.lights.size(); ++k) {
    streak.flux.push_back(collect(replicates, k, size, streak.light.emplace_back()));
  }
  streak.env_flux = collect(replicates, request.lights.size(), size, streak.env);
  streak.coverage_flux = collect(replicates, request.lights.size() + 1, size, streak.coverage);
  for (const Replicate& r : replicates) streak.rays += r.rays;
  return streak;
}

}  // namespace pluvia
