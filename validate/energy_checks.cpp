#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include "raytrace/drop_intersect.h"
#include "raytrace/embree_drop.h"
#include "raytrace/exit_field.h"
#include "validate/checks.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {

namespace {

constexpr int furnace_order = 20;
constexpr int furnace_instants = 48;
constexpr int furnace_rays = 400;  // per instant over the bounding square

// What becomes of the light of a uniform environment on one oscillating drop.
struct Furnace {
  double returned = 0;  // orders 0 .. furnace_order, share of the light on the silhouette
  double inside = 0;    // still in the drop after furnace_order segments
  double rays = 0;
};

Furnace furnace(const StreakRequest& request) {
  Furnace sums;
  PathOptions options = request.field.paths;
  options.max_order = furnace_order;
  options.min_power = 1e-9;
  const View view = view_from_elevation(request.view_elevation_deg);
  const double reach = 1.6 * request.drop.mean_radius_m;
  std::vector<PathExit> exits;
  for (int k = 0; k < furnace_instants; ++k) {
    const DropInstant drop =
        drop_at(request.drop, request.exposure_s * (k + 0.5) / furnace_instants);
    for (int i = 0; i < furnace_rays; ++i) {
      // Kronecker points, moved on from instant to instant.
      const double n = static_cast<double>(k) * furnace_rays + i;
      const double x = (2 * std::fmod(0.7548776662466927 * n, 1.0) - 1) * reach;
      const double y = (2 * std::fmod(0.5698402909980532 * n, 1.0) - 1) * reach;
      const Eigen::Vector3d origin = x * view.right + y * view.up + 4 * reach * view.to_camera;
      const auto hit = intersect_drop(drop, origin, -view.to_camera, RaySide::outside);
      if (!hit) continue;
      exits.clear();
      const PathRemainder left =
          trace_exits(drop, hit->position, hit->normal, view.to_camera, options, exits);
      for (const PathExit& exit : exits) sums.returned += exit.throughput;
      sums.inside += left.beyond_order;
      ++sums.rays;
    }
  }
  sums.returned /= sums.rays;
  sums.inside /= sums.rays;
  return sums;
}

// Orders 0 .. 3 of the rigid sphere, as its shard gives them: sum of env over sum of coverage.
double sphere_shard_ratio(const Preset& preset) {
  const TracedStreak streak =
      trace_streak(shard_request(preset, {.oscillation = 0, .view_elevation_deg = 0}));
  double env = 0, coverage = 0;
  for (const float v : streak.env.mean) env += v;
  for (const float v : streak.coverage.mean) coverage += v;
  return env / coverage;
}

constexpr std::array<int, 4> mesh_levels = {3, 4, 5, 6};  // 512 .. 32,768 triangles

constexpr int mesh_rays = 4000;

// Median angle between the mesh's and the analytic exit direction of straight refraction (p = 1),
// over one half of the rays.
double mesh_error_rad(const DropInstant& drop, const MeshDrop& mesh, double index, int half) {
  std::vector<double> errors;
  const double r0 = drop.surface.scale;
  const auto refract = [&](const Eigen::Vector3d& d, const Eigen::Vector3d& n, double ratio) {
    const double c = -n.dot(d);
    const double k = 1 - ratio * ratio * (1 - c * c);
    return k < 0 ? Eigen::Vector3d(0, 0, 0)
                 : Eigen::Vector3d(ratio * d + (ratio * c - std::sqrt(k)) * n);
  };
  const auto exit_direction = [&](const auto& enter, const auto& leave, const Eigen::Vector3d& o) {
    const Eigen::Vector3d d = {-1, 0, 0};
    const auto first = enter(o, d);
    if (!first) return Eigen::Vector3d(0, 0, 0);
    const Eigen::Vector3d inner = refract(d, first->normal, 1 / index).normalized();
    const auto second = leave(first->position, inner);
    return second ? refract(inner, -second->normal, index) : Eigen::Vector3d(0, 0, 0);
  };
  for (int i = half; i < mesh_rays; i += 2) {
    const double y = (2 * std::fmod(0.7548776662466927 * i, 1.0) - 1) * 1.2 * r0;
    const double z = (2 * std::fmod(0.5698402909980532 * i, 1.0) - 1) * 1.2 * r0;
    const Eigen::Vector3d o = {4 * r0, y, z};
    const Eigen::Vector3d exact = exit_direction(
        [&](const auto& p, const auto& d) { return intersect_drop(drop, p, d, RaySide::outside); },
        [&](const auto& p, const auto& d) { return intersect_drop(drop, p, d, RaySide::inside); },
        o);
    const Eigen::Vector3d approximate = exit_direction(
        [&](const auto& p, const auto& d) { return mesh.intersect(p, d); },
        [&](const auto& p, const auto& d) { return mesh.intersect(p + 1e-3 * r0 * d, d); }, o);
    if (exact.norm() > 0 && approximate.norm() > 0) {
      errors.push_back(exact.cross(approximate).norm());
    }
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

}  // namespace

void add_energy_check(const Preset& preset, Report& report) {
  const double sphere = sphere_shard_ratio(preset);
  double expected = 0;
  for (int p = 0; p <= 3; ++p) expected += sphere_energy(preset.field.paths.refractive_index, p);
  std::vector<Furnace> furnaces(preset.sets.size());
  tbb::parallel_for(std::size_t{0}, furnaces.size(), [&](std::size_t k) {
    furnaces[k] = furnace(shard_request(preset, {.oscillation = preset.sets[k].index}));
  });
  double worst = std::abs(sphere - expected);
  Table table{"Furnace: what comes back from a uniform environment",
              {"oscillation", "returned, orders 0 to 20", "still inside after 20", "sum - 1"},
              {}};
  for (std::size_t k = 0; k < furnaces.size(); ++k) {
    const Furnace& f = furnaces[k];
    worst = std::max(worst, std::abs(f.returned + f.inside - 1));
    table.rows.push_back({std::to_string(preset.sets[k].index), fmt::format("{:.5f}", f.returned),
                          fmt::format("{:.5f}", f.inside),
                          fmt::format("{:.1e}", f.returned + f.inside - 1)});
  }
  report.tables.push_back(table);
  Check check;
  check.name = "furnace";
  check.value = worst;
  check.bound = 0.0005;
  check.measured = sphere;
  check.expected = expected;
  check.unit = "share of the light";
  check.why =
      "Largest of: rigid sphere's streak, environment over coverage with orders 0 to 3, against "
      "0.99682; and for every oscillation, |returned in orders 0 to 20 + traced as still inside - "
      "1|. An oscillating drop holds light by total reflection: after 20 orders up to several per "
      "cent are still inside (table), so what comes back cannot be 1 by itself. measured and "
      "expected are the sphere's.";
  report.checks.push_back(check);
}

void add_mesh_check(const Preset& preset, Report& report) {
  const StreakRequest request =
      shard_request(preset, {.oscillation = preset.sets.back().index, .view_elevation_deg = 0});
  const DropInstant drop = drop_at(request.drop, 0.3 * request.exposure_s);
  Curve curve{"median error of p = 1", {}, {}, {}};
  std::array<std::vector<double>, 2> halves;
  for (const int level : mesh_levels) {
    const SphereMesh sphere = sphere_mesh(level);
    const MeshDrop mesh(drop, sphere);
    for (int half = 0; half < 2; ++half) {
      halves[static_cast<std::size_t>(half)].push_back(
          mesh_error_rad(drop, mesh, request.field.paths.refractive_index, half));
    }
    curve.x.push_back(static_cast<double>(mesh.triangle_count()));
    curve.y.push_back(0.5 * (halves[0].back() + halves[1].back()));
  }
  const auto order_of = [&](const std::vector<double>& error) {
    return -std::log(error.back() / error.front()) / std::log(curve.x.back() / curve.x.front());
  };
  Check check = deviation(
      "mesh.convergence", order_of(curve.y), 1, 0.15, "order",
      "Exit directions of triangle meshes with smooth normals against the analytic drop, 512 to "
      "32,768 triangles: linear interpolation errs with the square of the edge, so with the number "
      "of triangles to the power -1. The bound leaves room for the sampling noise of the medians "
      "(uncertainty: from two halves of the rays) and for the coarsest mesh.");
  check.uncertainty = 0.5 * std::abs(order_of(halves[0]) - order_of(halves[1]));
  report.checks.push_back(check);
  report.plots.push_back({"Mesh against analytic surface",
                          "triangles",
                          "median error of the exit direction [rad]",
                          true,
                          true,
                          {curve}});
}

}  // namespace pluvia
