#include "tests/bench/brute_trial.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "raytrace/process_time.h"

namespace pluvia {

namespace {

using Picture = std::vector<double>;

Picture at_scale(const StreakImage& image, Scale scale, int width_px) {
  const Picture picture(image.mean.begin(), image.mean.end());
  return scale == rows ? row_sums(picture, width_px) : picture;
}

double sum_of(const StreakImage& image) {
  double sum = 0;
  for (const float v : image.mean) sum += v;
  return sum;
}

// Brute force of the judged lights.
struct Batches {
  std::array<std::vector<std::vector<Picture>>, scales> pictures = {};  // light, batch
  std::vector<std::vector<double>> fluxes = {};                         // light, batch
  std::vector<double> total_flux = {};                                  // batch
  double used_s = 0, rays = 0;

  double count() const { return static_cast<double>(total_flux.size()); }
};

// The field's picture of one light, to be compared with the batches.
struct Contestant {
  double field_s = 0;
  double ray_s = 0;  // brute force's time for a ray
  std::array<Picture, scales> pictures = {};
};

struct Work {
  const StreakRequest& request;
  const TrialOptions& options;
  std::vector<std::size_t> judged = {};  // of the request's lights
  std::vector<Contestant> all = {}, one = {};
  Batches batches = {}, quarter = {};
};

// Two replicates are the fewest; batches are as independent of each other as they are.
BruteOptions batch_options(const TrialOptions& options) {
  return {.replicates = 2,
          .instants = options.instants,
          .rays_per_instant = options.rays_per_instant,
          .seed = 1,
          .follower = options.follower};
}

BruteOptions quarter_options(const TrialOptions& options) {
  return {.replicates = 2,
          .instants = options.instants / 2,
          .rays_per_instant = options.rays_per_instant / 2,
          .seed = 1000003,  // beyond every batch's
          .follower = options.follower};
}

void add_batch(const Work& work, BruteOptions options, Batches& batches) {
  options.seed += batches.total_flux.size();
  const double start_s = process_cpu_s();
  const BruteStreak streak = brute_force_streak(work.request, options);
  batches.used_s += process_cpu_s() - start_s;
  batches.rays += streak.rays;
  double total = 0;
  for (const ReplicateMean& flux : streak.flux) total += flux.mean;
  batches.total_flux.push_back(total);
  batches.fluxes.resize(work.judged.size());
  for (auto& pictures : batches.pictures) pictures.resize(work.judged.size());
  for (std::size_t k = 0; k < work.judged.size(); ++k) {
    batches.fluxes[k].push_back(streak.flux[work.judged[k]].mean);
    for (const Scale scale : {pixels, rows}) {
      batches.pictures[scale][k].push_back(
          at_scale(streak.light[work.judged[k]], scale, work.request.frame.width_px));
    }
  }
}

Contestant contestant(const StreakRequest& request, const StreakImage& image, double field_s) {
  Contestant result{.field_s = field_s};
  for (const Scale scale : {pixels, rows}) {
    result.pictures[scale] = at_scale(image, scale, request.frame.width_px);
  }
  return result;
}

void trace_all_lights(Work& work, Trial& trial) {
  const double start_s = process_cpu_s();
  const TracedStreak streak = trace_streak(work.request);
  trial.field_s = process_cpu_s() - start_s;
  trial.lights = streak.light.size();
  for (const StreakImage& image : streak.light) trial.total.field += sum_of(image);
  for (const std::size_t light : work.judged) {
    trial.fluxes.push_back({.field = sum_of(streak.light[light])});
    work.all.push_back(contestant(work.request, streak.light[light], trial.field_s));
  }
}

// The field of one light, and brute force's time for a ray with that light. Its pictures need no
// run of their own: rays do not depend on the lights.
void trace_one_light(Work& work, std::size_t light) {
  StreakRequest request = work.request;
  request.lights = {request.lights[light]};
  double start_s = process_cpu_s();
  const TracedStreak streak = trace_streak(request);
  work.one.push_back(contestant(request, streak.light.front(), process_cpu_s() - start_s));
  start_s = process_cpu_s();
  const BruteStreak brute = brute_force_streak(request, quarter_options(work.options));
  work.one.back().ray_s = (process_cpu_s() - start_s) / brute.rays;
}

SpeedRatio ratio_of(const Contestant& field, const BatchVerdict& verdict, const Batches& batches) {
  if (verdict.batch_square <= 0) return {};
  SpeedRatio ratio{.bound = verdict.square < 2 * verdict.standard_error};
  const double square =
      ratio.bound ? std::max(verdict.square, 0.0) + 2 * verdict.standard_error : verdict.square;
  const double rays = batches.rays / batches.count() * verdict.batch_square / square;
  ratio.brute_s = rays * field.ray_s;
  ratio.speed = ratio.brute_s / field.field_s;
  ratio.extrapolation = std::sqrt(verdict.batch_square / batches.count() / square);
  return ratio;
}

std::vector<Figure> figures_of(const Work& work) {
  std::vector<Figure> figures;
  for (std::size_t k = 0; k < work.judged.size(); ++k) {
    for (const bool all : {true, false}) {
      const Contestant& field = all ? work.all[k] : work.one[k];
      for (const Scale scale : {pixels, rows}) {
        Figure figure{.light = k, .all = all, .scale = scale, .field_s = field.field_s};
        figure.verdict = judge_picture(field.pictures[scale], work.batches.pictures[scale][k]);
        figure.brute_error = std::sqrt(figure.verdict.batch_square / work.batches.count());
        figure.ratio = ratio_of(field, figure.verdict, work.batches);
        figures.push_back(figure);
      }
    }
  }
  return figures;
}

bool is_sharp(const Work& work) {
  const std::vector<Figure> figures = figures_of(work);
  return std::all_of(figures.begin(), figures.end(), [](const Figure& figure) {
    return figure.ratio.extrapolation <= farthest_extrapolation && !figure.ratio.bound;
  });
}

void run_brute_force(Work& work) {
  for (int k = 0; k < work.options.batches; ++k) {
    add_batch(work, quarter_options(work.options), work.quarter);
    add_batch(work, batch_options(work.options), work.batches);
  }
  // A verdict costs as much as some rays: asked for after every eighth of the work.
  while (work.batches.used_s < work.options.brute_cpu_s && !is_sharp(work)) {
    const int more = std::max(1, static_cast<int>(work.batches.count()) / 8);
    for (int k = 0; k < more; ++k) add_batch(work, batch_options(work.options), work.batches);
  }
  for (Contestant& field : work.all) field.ray_s = work.batches.used_s / work.batches.rays;
}

double batch_square(const Batches& batches, Scale scale, std::size_t light) {
  const auto& pictures = batches.pictures[scale][light];
  return judge_picture(pictures.front(), pictures).batch_square;
}

std::vector<double> exponents_of(const Work& work, Scale scale) {
  const double whole = work.batches.rays / work.batches.count();
  const double quarter = work.quarter.rays / work.quarter.count();
  std::vector<double> exponents;
  for (std::size_t k = 0; k < work.judged.size(); ++k) {
    const double of_whole = batch_square(work.batches, scale, k);
    const double of_quarter = batch_square(work.quarter, scale, k);
    if (of_whole <= 0 || of_quarter <= 0) continue;
    exponents.push_back(0.5 * std::log(of_whole / of_quarter) / std::log(whole / quarter));
  }
  return exponents;
}

std::size_t find_light(const StreakRequest& request, const std::string& name) {
  for (std::size_t k = 0; k < request.lights.size(); ++k) {
    if (light_name(request.lights[k]) == name) return k;
  }
  throw CLI::ValidationError("--lights",
                             fmt::format("\"{}\"; expected a light of the preset, such as {}", name,
                                         light_name(request.lights.front())));
}

}  // namespace

Trial judge_shard(const ChosenShard& shard, const TrialOptions& options) {
  Work work{.request = shard.request, .options = options};
  for (const std::string& name : options.lights) {
    work.judged.push_back(find_light(shard.request, name));
  }
  Trial trial{.shard = shard.name};
  trace_all_lights(work, trial);
  for (const std::size_t light : work.judged) trace_one_light(work, light);
  run_brute_force(work);
  trial.figures = figures_of(work);
  for (const Scale scale : {pixels, rows}) trial.exponents[scale] = exponents_of(work, scale);
  trial.total.brute = mean_and_error(work.batches.total_flux);
  for (std::size_t k = 0; k < work.judged.size(); ++k) {
    trial.fluxes[k].brute = mean_and_error(work.batches.fluxes[k]);
  }
  trial.brute_s = work.batches.used_s;
  trial.rays = work.batches.rays;
  trial.batches = work.batches.total_flux.size();
  return trial;
}

}  // namespace pluvia
