#include "raytrace/reference_picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace pluvia {
namespace {

void require_finite(const Eigen::Vector3d& value, const ReferenceSums& sums, std::size_t pixel) {
  if (value.allFinite()) return;
  const auto width = static_cast<std::size_t>(sums.width);
  throw std::runtime_error(fmt::format("pixel ({}, {}): {}, {}, {} cd/m^2; expected finite values",
                                       pixel % width, pixel / width, value.x(), value.y(),
                                       value.z()));
}

// Sides of the grids of samples in the pixels: half of a pass evenly, half in proportion to the
// standard deviation of a pixel's samples. Finer in passes that learn: a small bright thing that
// they do not find is a rare and bright error of the others.
std::vector<int> grid_sides(const ReferenceSettings& settings, bool counts,
                            const ReferenceSums& sums) {
  const std::size_t pixels = sums.spread.size();
  std::vector<double> deviation(pixels);
  double all = 0;
  for (std::size_t i = 0; i < pixels; ++i) all += deviation[i] = std::sqrt(sums.spread[i]);
  std::vector<int> sides(pixels);
  const double least = counts ? 2 : 8, most = 64;
  for (std::size_t i = 0; i < pixels; ++i) {
    const double noisy = all > 0 ? deviation[i] / all * static_cast<double>(pixels) : 1;
    const double samples = settings.surface_samples * (0.5 + 0.5 * noisy);
    sides[i] = static_cast<int>(std::lround(std::clamp(std::sqrt(samples), least, most)));
  }
  return sides;
}

void add_surfaces(const ReferenceScene& scene, const ReferenceSettings& settings,
                  const PassKey& key, bool counts, ReferenceSums& sums) {
  const std::vector<int> sides = grid_sides(settings, counts, sums);
  tbb::parallel_for(0, sums.height, [&](int y) {
    for (int x = 0; x < sums.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(sums.width) +
                         static_cast<std::size_t>(x);
      const PixelSample sample = sample_pixel(scene, key, x, y, sides[pixel]);
      require_finite(sample.mean, sums, pixel);
      sums.luminance[pixel] += sample.luminance;
      sums.spread[pixel] += sample.spread;
      if (!counts) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = sample.mean[static_cast<Eigen::Index>(c)];
        sums.surface[3 * pixel + c] += value;
        sums.surface_squares[3 * pixel + c] += value * value;
      }
      sums.samples[pixel] += sides[pixel] * sides[pixel];
    }
  });
}

struct Task {  // neighbouring strata
  std::size_t begin = 0, end = 0;
  std::vector<Deposit> deposits = {};
};

std::vector<Task> tasks_of(const std::vector<int>& samples) {
  constexpr int most_of_a_task = 1024;
  std::vector<Task> tasks;
  int size = most_of_a_task;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (size >= most_of_a_task) {
      tasks.push_back({.begin = i});
      size = 0;
    }
    tasks.back().end = i + 1;
    size += samples[i];
  }
  return tasks;
}

// The rain, the coverage and the number of samples of one pass.
struct RainPicture {
  std::vector<double> rain = {}, coverage = {}, samples = {};
};

void lay_down(const ReferenceSums& sums, const std::vector<Deposit>& deposits,
              RainPicture& picture) {
  for (const Deposit& deposit : deposits) {
    const Eigen::Vector3d value = deposit.weight * deposit.change;
    require_finite(value, sums, deposit.pixel);
    for (std::size_t c = 0; c < 3; ++c)
      picture.rain[3 * std::size_t{deposit.pixel} + c] += value[static_cast<Eigen::Index>(c)];
    picture.coverage[deposit.pixel] += deposit.weight;
    picture.samples[deposit.pixel] += 1;
  }
}

RainPicture rain_of_pass(const ReferenceScene& scene, const PassKey& key,
                         const std::vector<int>& samples, ReferenceSums& sums) {
  std::vector<Task> tasks = tasks_of(samples);
  const std::vector<double> weights = pixel_weights(scene, sums);
  RainPicture picture = {std::vector<double>(sums.rain.size(), 0.0),
                         std::vector<double>(sums.coverage.size(), 0.0),
                         std::vector<double>(sums.coverage.size(), 0.0)};
  // Batches bound the memory; within one, tasks run in any order and are laid down in theirs.
  constexpr std::size_t batch = 256;
  for (std::size_t begin = 0; begin < tasks.size(); begin += batch) {
    const std::size_t end = std::min(begin + batch, tasks.size());
    tbb::parallel_for(begin, end, [&](std::size_t i) {
      Task& task = tasks[i];
      const std::size_t count = task.end - task.begin;
      task.deposits =
          sample_strata(scene, key, weights, std::span(sums.strata).subspan(task.begin, count),
                        std::span(samples).subspan(task.begin, count));
    });
    for (std::size_t i = begin; i < end; ++i) {
      lay_down(sums, tasks[i].deposits, picture);
      tasks[i].deposits = {};
    }
  }
  return picture;
}

void add_rain(const RainPicture& picture, ReferenceSums& sums) {
  for (std::size_t i = 0; i < sums.rain.size(); ++i) {
    sums.rain[i] += picture.rain[i];
    sums.rain_squares[i] += picture.rain[i] * picture.rain[i];
  }
  for (std::size_t i = 0; i < sums.coverage.size(); ++i) {
    sums.coverage[i] += picture.coverage[i];
    sums.samples[i] += picture.samples[i];
  }
}

struct NoisySignal {  // sums of squares
  double noise = 0, signal = 0;
};

NoisySignal weighed(const ReferenceLayer& layer, const std::vector<double>& weights) {
  NoisySignal sums;
  for (std::size_t i = 0; i < layer.mean.size(); ++i) {
    sums.noise += weights[i / 3] * layer.variance[i];
    sums.signal += weights[i / 3] * (layer.mean[i] * layer.mean[i] - layer.variance[i]);
  }
  return sums;
}

double relative_error(double noise, double signal) {
  if (noise == 0) return 0;
  return signal > 0 ? std::sqrt(noise / signal) : std::numeric_limits<double>::infinity();
}

}  // namespace

ReferenceSums empty_sums(const ReferenceScene& scene) {
  ReferenceSums sums = {.width = scene.camera.width_px, .height = scene.camera.height_px};
  const std::size_t pixels =
      static_cast<std::size_t>(sums.width) * static_cast<std::size_t>(sums.height);
  for (auto* layer : {&sums.surface, &sums.surface_squares, &sums.rain, &sums.rain_squares})
    layer->assign(3 * pixels, 0.0);
  for (auto* layer : {&sums.coverage, &sums.samples, &sums.luminance, &sums.spread})
    layer->assign(pixels, 0.0);
  sums.strata = first_strata(scene);
  return sums;
}

void add_pass(const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums) {
  const PassKey key = {settings.seed, static_cast<std::uint64_t>(sums.learned + sums.passes)};
  const bool counts = sums.learned >= settings.learning_passes;
  add_surfaces(scene, settings, key, counts, sums);
  ++(counts ? sums.passes : sums.learned);
  const std::vector<int> samples = allocate(scene, settings.samples_per_px, sums.strata);
  const RainPicture picture = rain_of_pass(scene, key, samples, sums);
  if (counts) add_rain(picture, sums);
}

std::vector<double> pixel_weights(const ReferenceScene& scene, const ReferenceSums& sums) {
  const double white = scene.camera.white_cd_m2 * (sums.learned + sums.passes);
  std::vector<double> weights;
  for (const double luminance : sums.luminance)
    weights.push_back(luminance > white ? std::pow(white / luminance, 2) : 1);
  return weights;
}

ReferenceErrors estimated_errors(const ReferenceScene& scene, const ReferenceSums& sums) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  if (sums.passes < 2) return {unknown, unknown, unknown};
  const std::vector<double> weights = pixel_weights(scene, sums);
  const NoisySignal surface =
      weighed(layer_of(sums.surface, sums.surface_squares, sums.passes), weights);
  const NoisySignal rain = weighed(layer_of(sums.rain, sums.rain_squares, sums.passes), weights);
  return {relative_error(surface.noise, surface.signal), relative_error(rain.noise, rain.signal),
          relative_error(rain.noise, surface.signal)};
}

bool meets(const ReferenceErrors& errors, double error) {
  const bool no_rain = errors.rain >= 1 && errors.rain_noise <= least_rain * error;
  return errors.surface <= error && (errors.rain <= error || no_rain);
}

void trace_reference(const ReferenceScene& scene, const ReferenceSettings& settings,
                     ReferenceSums& sums, const AfterPass& after_pass) {
  const auto start = std::chrono::steady_clock::now();
  const auto is_done = [&](const ReferenceErrors& found) {
    if (sums.passes >= settings.most_passes) return true;
    if (sums.passes < settings.least_passes) return false;
    return meets(found, settings.error);
  };
  ReferenceErrors errors = estimated_errors(scene, sums);
  while (!is_done(errors)) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    if (settings.budget_s > 0 && passed.count() > settings.budget_s) return;
    add_pass(scene, settings, sums);
    errors = estimated_errors(scene, sums);
    if (after_pass) after_pass(sums, errors);
  }
}

ReferenceLayer layer_of(const std::vector<double>& sums, const std::vector<double>& squares,
                        int passes) {
  ReferenceLayer layer;
  const double n = passes;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double mean = sums[i] / n;
    layer.mean.push_back(mean);
    // Rounding may leave a little less than nothing of equal passes.
    layer.variance.push_back(std::max(0.0, squares[i] - n * mean * mean) / (n * (n - 1)));
  }
  return layer;
}

}  // namespace pluvia
