#include <functional>

#include <fmt/format.h>

#include "raytrace/brute_force.h"
#include "raytrace/preset.h"
#include "validate/batch_judge.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_streaks.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

constexpr int batches = 8;
constexpr double exposure_share = 0.1;

struct Surface {
  SweepPoint point = {};
  RayFollower follower = RayFollower::independent;
  int levels = 0;
  PictureBatches rows = {};  // [batch]: sums of rows of pixels, one light after the other
};

std::vector<Surface> surfaces_of(bool quick) {
  std::vector<Surface> surfaces = {{.point = {.series = "analytic", .setting = "analytic"}}};
  for (const RayFollower follower : {RayFollower::mesh, RayFollower::polished_mesh}) {
    const bool polished = follower == RayFollower::polished_mesh;
    const std::string series = polished ? "mesh, polished" : "mesh";
    for (int levels = 3; levels <= (quick ? 4 : polished ? 5 : 7); ++levels) {
      const long triangles = 8L << (2 * levels);
      surfaces.push_back({.point = {.series = series,
                                    .setting = fmt::format("{}, {} triangles", series, triangles)},
                          .follower = follower,
                          .levels = levels});
    }
  }
  return surfaces;
}

// The same rays for every surface: they follow from the seed.
void follow(const StreakRequest& request, int rays, bool keep, Surface& surface) {
  for (int batch = 0; batch < batches; ++batch) {
    const BruteStreak streak =
        brute_force_streak(request, {.replicates = 2,
                                     .instants = 8,
                                     .rays_per_instant = rays,
                                     .seed = static_cast<std::uint64_t>(batch + 1),
                                     .follower = surface.follower,
                                     .mesh_levels = surface.levels});
    if (!keep) continue;
    std::vector<double>& rows_of_all = surface.rows.emplace_back();
    for (const StreakImage& light : streak.light) {
      const std::vector<double> rows = row_sums(pixels_of(light), request.frame.width_px);
      rows_of_all.insert(rows_of_all.end(), rows.begin(), rows.end());
    }
  }
}

JudgedPicture bias_of(const Surface& surface, const Surface& truth) {
  PictureBatches differences = surface.rows;
  for (std::size_t b = 0; b < differences.size(); ++b) {
    for (std::size_t i = 0; i < differences[b].size(); ++i) {
      differences[b][i] -= truth.rows[b][i];
    }
  }
  const BatchVerdict verdict = judge_differences(differences, truth.rows);
  return {.square = verdict.square, .standard_error = verdict.standard_error};
}

}  // namespace

SweepCurve sweep_mesh(const SweepInputs& inputs, const Progress& progress) {
  const Preset preset = read_preset(inputs.preset_file);
  const ShardKey key = {
      .diameter_um = diameters_of(preset).front(), .oscillation = 3, .view_elevation_deg = 40};
  const StreakRequest request = part_of(shard_request(preset, key), exposure_share);
  const int rays = inputs.quick ? 500 : 2000;
  std::vector<Surface> surfaces = surfaces_of(inputs.quick);
  std::vector<std::function<void(int)>> jobs;
  for (Surface& surface : surfaces) {
    jobs.push_back([&](int round) { follow(request, rays, round == 0, surface); });
  }
  const auto times = time_interleaved(jobs, inputs.repeats, [&](double share) {
    if (progress) progress("surfaces", share);
  });
  SweepCurve curve = {
      .name = "mesh",
      .title = "Triangle meshes of the drop",
      .time_label = fmt::format("processor time of {} rays [s]", 2 * 8 * batches * rays),
      .error_label = "relative RMSE of the rows of all streaks",
      .text = fmt::format(
          "Set {} from {} degrees under {} lights: the same {} rays through meshes with smooth "
          "normals, "
          "built anew for each of {} instants, and through the analytic drop, which is exact here "
          "(errors of 0 are in the table alone). "
          "Noise is taken away; the error is bias.",
          key.oscillation, key.view_elevation_deg, request.lights.size(), 2 * 8 * batches * rays,
          2 * 8 * batches),
      .whole = "those rays"};
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    set_times(times[k], surfaces[k].point);
    if (k > 0) set_error({bias_of(surfaces[k], surfaces.front())}, surfaces[k].point);
    curve.points.push_back(surfaces[k].point);
  }
  return curve;
}

}  // namespace pluvia
