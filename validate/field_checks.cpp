#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "raytrace/brute_force.h"
#include "validate/checks.h"
#include "validate/false_alarm.h"
#include "validate/metrics.h"

namespace pluvia {

namespace {

// The streak of the comparison: strong oscillation across the view, seen from 20 degrees above.
constexpr ShardKey compared_shard = {3200, 6, 20};

constexpr int replicates = 16;  // of brute force

struct ComparedLight {
  LightDirection light = {};
  const char* check = "";  // name of its check; empty: only shown
  const char* what = "";
};

constexpr std::array<ComparedLight, 3> compared_lights = {{
    {{10, 150}, "easy", "behind the drop: straight refraction"},
    {{30, 50}, "hard", "in front, by the rainbows: caustics of two internal reflections"},
    {{-30, 110}, "", "from the side below: reflection and the rim of refraction"},
}};

double seconds(const std::chrono::steady_clock::time_point& start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::size_t light_index(const StreakRequest& request, const LightDirection& light) {
  return static_cast<std::size_t>(std::find(request.lights.begin(), request.lights.end(), light) -
                                  request.lights.begin());
}

double flux_of(const StreakImage& image) {
  double sum = 0;
  for (const float v : image.mean) sum += v;
  return sum;
}

Image picture(const StreakRequest& request, const std::vector<float>& values) {
  Image image = make_image(request.frame.width_px, request.frame.height_px, 1);
  image.values = values;
  return image;
}

// Without the noise of both.
std::string beyond_noise(const NoisyError& error) {
  if (error.below_noise) {
    return fmt::format("below the noise: without it, its square is {:.1e} +- {:.1e}", error.squared,
                       error.standard_error);
  }
  const double root = std::sqrt(error.squared);
  return fmt::format("without that noise by {:.4f} +- {:.4f}", root,
                     error.standard_error / (2 * root));
}

// Four panels of one light, and a sentence on how far apart they are; the distance beside their
// noise.
NoisyError add_panels(const StreakRequest& request, const ComparedLight& compared,
                      const StreakImage& field, const StreakImage& brute, Figure& figure) {
  std::vector<float> difference, noise, variance;
  for (std::size_t i = 0; i < field.mean.size(); ++i) {
    difference.push_back(field.mean[i] - brute.mean[i]);
    variance.push_back(brute.variance[i] + field.variance[i]);
    noise.push_back(std::sqrt(variance.back()));
  }
  // Shown so that all but the brightest half per cent of the pixels fall below white.
  std::vector<float> sorted = brute.mean;
  std::sort(sorted.begin(), sorted.end());
  const double white = sorted[sorted.size() - 1 - sorted.size() / 200];
  const std::string light =
      fmt::format("({}, {})", compared.light.elevation_deg, compared.light.azimuth_deg);
  figure.panels.push_back({picture(request, field.mean), white, light + " field", false, 1});
  figure.panels.push_back({picture(request, brute.mean), white, light + " brute", false, 1});
  figure.panels.push_back(
      {picture(request, difference), white / 4, light + " difference, x 4", true, 1});
  figure.panels.push_back({picture(request, noise), white / 4, light + " noise, x 4", false, 1});
  const NoisyError error = noisy_error(picture(request, field.mean), picture(request, brute.mean),
                                       picture(request, variance));
  figure.text += fmt::format(
      " Light at elevation {}, azimuth {} ({}): the pictures differ by a relative RMSE of {:.3f}; "
      "their own noise is {:.3f} (field, from its two replicates) and {:.3f} (brute force), {}.",
      compared.light.elevation_deg, compared.light.azimuth_deg, compared.what, error.relative_rmse,
      estimated_relative_error(field), estimated_relative_error(brute), beyond_noise(error));
  return error;
}

void add_picture_check(const ComparedLight& compared, const NoisyError& error, Report& report) {
  const double bound = two_sided_bound(report_false_alarm, report_comparisons);
  Check check = deviation(
      fmt::format("field.picture.{}", compared.check), error.squared, 0, bound, "standard errors",
      fmt::format("The streak's pixels under the light {}: measured is the square of the relative "
                  "RMSE between exit field and brute force, less what the noise of both makes. "
                  "{} A relative RMSE of {:.3f} would be seen.",
                  compared.what, false_alarm_text(), std::sqrt(bound * error.standard_error)),
      error.standard_error);
  check.uncertainty = error.standard_error;
  report.checks.push_back(check);
}

void add_flux_checks(const ComparedLight& compared, double field_flux, const ReplicateMean& brute,
                     double rays, Report& report) {
  const std::string name = fmt::format("field.flux.{}", compared.check);
  Check flux;
  flux.name = name;
  flux.measured = field_flux;
  flux.expected = brute.mean;
  flux.uncertainty = brute.standard_error;
  flux.value = std::abs(field_flux - brute.mean) / brute.standard_error;
  flux.bound = two_sided_bound(report_false_alarm, report_comparisons, replicates - 1);
  flux.unit = "standard errors";
  flux.why = fmt::format(
      "Sum of the streak's pixels under the light {}: exit field against {:.0f} million "
      "brute-force rays that share only the intersection. The standard error is brute force's own, "
      "from its {} replicates, which makes the deviation Student's. {}",
      compared.what, rays / 1e6, replicates, false_alarm_text());
  report.checks.push_back(flux);
  report.checks.push_back(deviation(
      name + ".standard_error", brute.standard_error / brute.mean, 0, 0.005, "relative",
      "The comparison above must be sharp: brute force's standard error, relative to the flux."));
}

}  // namespace

void add_field_checks(const Preset& preset, const Progress& progress, Report& report) {
  Preset narrow = preset;
  narrow.width_px = 16;
  narrow.cone_half_angle_deg = 5;
  narrow.slices = 512;
  narrow.spans_per_period = 8;
  narrow.field.base_cells = 10;
  narrow.field.space_depth = 2;
  narrow.field.time_depth = 1;
  const StreakRequest request = shard_request(narrow, compared_shard);

  auto start = std::chrono::steady_clock::now();
  const TracedStreak field = trace_streak(request, [&](double share) {
    if (progress) progress("streaks from the field", 0.4 * share);
  });
  report.timings_s.emplace_back("field, one streak with 74 lights, 16 px", seconds(start));

  start = std::chrono::steady_clock::now();
  BruteOptions options;
  options.replicates = replicates;
  options.instants = 512;
  options.rays_per_instant = 3000;
  report.seeds.emplace_back("exit field", std::to_string(request.seed));
  report.seeds.emplace_back("brute force", std::to_string(options.seed));
  const BruteStreak brute = brute_force_streak(request, options, [&](double share) {
    if (progress) progress("streaks by brute force", 0.4 + 0.6 * share);
  });
  report.timings_s.emplace_back("brute force, the same 74 lights", seconds(start));

  Figure figure;
  figure.title = "Three streaks, fast and by brute force";
  figure.text =
      "Each light's streak from the exit field and from counted rays, their difference (red: the "
      "field is brighter), and one standard error of both together.";
  for (const ComparedLight& compared : compared_lights) {
    const std::size_t k = light_index(request, compared.light);
    const NoisyError error = add_panels(request, compared, field.light[k], brute.light[k], figure);
    if (compared.check[0] != '\0') {
      add_flux_checks(compared, flux_of(field.light[k]), brute.flux[k], brute.rays, report);
      add_picture_check(compared, error, report);
    }
  }
  report.figures.push_back(figure);
}

}  // namespace pluvia
