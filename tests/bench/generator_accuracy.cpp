// What accuracy costs in the generator: one shard traced with several settings, each against a much
// finer run; CPU seconds and the error of the streaks (relative RMSE per light, median and 90th
// percentile over the lights), of their fluxes, and the program's own estimate of the error.
//
//   generator_accuracy PRESET OSCILLATION VIEW [--fine KEY=VALUE,..] SETTING..
//   SETTING: KEY=VALUE,.. over slices spans cells space time tol cone
#include <algorithm>
#include <cmath>
#include <ctime>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "raytrace/preset.h"

namespace {

using pluvia::StreakRequest;

double cpu_s() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void apply(const std::string& setting, StreakRequest& request) {
  std::istringstream list(setting);
  for (std::string item; std::getline(list, item, ',');) {
    const std::string key = item.substr(0, item.find('='));
    const double value = std::stod(item.substr(item.find('=') + 1));
    if (key == "slices") request.slices = static_cast<int>(value);
    else if (key == "spans") request.spans_per_period = value;
    else if (key == "cells") request.field.base_cells = static_cast<int>(value);
    else if (key == "space") request.field.space_depth = static_cast<int>(value);
    else if (key == "time") request.field.time_depth = static_cast<int>(value);
    else if (key == "tol") request.field.bend_tolerance = value;
    else if (key == "cone") request.cone_half_angle_rad = value * std::acos(-1) / 180;
    else if (key == "exposure") request.exposure_s *= value, request.frame.path_rows *= value;
    else if (key == "start") for (auto& m : request.drop.modes) m.phase_rad = value * mode_frequency_rad_s(request.drop, m.n) * request.exposure_s;
    else if (key == "seed") request.seed = static_cast<std::uint64_t>(value);
    else throw std::invalid_argument(item);
  }
}

struct Errors {
  std::vector<double> image = {}, flux = {}, estimate = {};
};

double at(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

Errors compare(const pluvia::TracedStreak& ours, const pluvia::TracedStreak& fine) {
  Errors errors;
  for (std::size_t k = 0; k < ours.light.size(); ++k) {
    double difference = 0, size = 0, flux = 0, fine_flux = 0, variance = 0;
    for (std::size_t i = 0; i < ours.light[k].mean.size(); ++i) {
      const double a = ours.light[k].mean[i], b = fine.light[k].mean[i];
      difference += (a - b) * (a - b);
      size += b * b;
      flux += a;
      fine_flux += b;
      variance += ours.light[k].variance[i];
    }
    errors.image.push_back(std::sqrt(difference / size));
    errors.flux.push_back(std::abs(flux / fine_flux - 1));
    errors.estimate.push_back(std::sqrt(variance / size));
  }
  return errors;
}

double sum(const std::vector<float>& v) {
  double s = 0;
  for (const float x : v) s += x;
  return s;
}

}  // namespace

int main(int argc, char** argv) {
  const pluvia::Preset preset = pluvia::read_preset(argv[1]);
  const StreakRequest base =
      pluvia::shard_request(preset, {3200, std::stoi(argv[2]), std::stoi(argv[3])});
  StreakRequest fine = base;
  apply(argv[4], fine);
  double start = cpu_s();
  const pluvia::TracedStreak truth = trace_streak(fine);
  fmt::print("{:<50} {:7.2f} CPU s {:9} nodes\n", argv[4], cpu_s() - start, truth.traced_nodes);
  std::fflush(stdout);
  for (int a = 5; a < argc; ++a) {
    StreakRequest request = base;
    apply(argv[a], request);
    start = cpu_s();
    const pluvia::TracedStreak ours = trace_streak(request);
    const double used = cpu_s() - start;
    const Errors e = compare(ours, truth);
    fmt::print("{:<50} {:7.2f} CPU s {:9} nodes  error {:.2f} / {:.2f} %  flux {:.2f} / {:.2f} %  "
               "estimate {:.2f} / {:.2f} %  env {:+.4f} coverage {:+.4f} %\n",
               argv[a], used, ours.traced_nodes, 100 * at(e.image, 0.5), 100 * at(e.image, 0.9),
               100 * at(e.flux, 0.5), 100 * at(e.flux, 0.9), 100 * at(e.estimate, 0.5),
               100 * at(e.estimate, 0.9), 100 * (sum(ours.env.mean) / sum(truth.env.mean) - 1),
               100 * (sum(ours.coverage.mean) / sum(truth.coverage.mean) - 1));
    std::vector<std::size_t> worst(e.image.size());
    for (std::size_t k = 0; k < worst.size(); ++k) worst[k] = k;
    std::sort(worst.begin(), worst.end(), [&](auto i, auto j) { return e.image[i] > e.image[j]; });
    fmt::print("   worst:");
    for (std::size_t k = 0; k < 12; ++k) {
      fmt::print(" {} {:.1f}/{:.1f}/{:.3g}", light_name(base.lights[worst[k]]), 100 * e.image[worst[k]],
                 100 * e.flux[worst[k]], sum(truth.light[worst[k]].mean));
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}
