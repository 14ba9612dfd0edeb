#include "validate/amplitude_table.h"

#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

// The mean over the seeds; their spread goes into the tables' noise.
LogMaxima node_value(CountedModel& tracer, AmplitudeTables& tables, double a20, double a31,
                     double phi_drop_deg) {
  std::vector<LogMaxima> samples;
  for (int k = 0; k < tables.grid.seeds; ++k) {
    samples.push_back(tracer(a20, a31, phi_drop_deg, 100 + static_cast<std::uint64_t>(k)));
  }
  LogMaxima mean(samples.front().size(), 0.0);
  for (std::size_t light = 0; light < mean.size(); ++light) {
    for (const LogMaxima& sample : samples) mean[light] += sample[light] / tables.grid.seeds;
    double square = 0;
    for (const LogMaxima& sample : samples) square += std::pow(sample[light] - mean[light], 2);
    if (samples.size() > 1) {
      // Of the mean of the seeds.
      tables.noise_square += square / static_cast<double>(samples.size() * (samples.size() - 1));
      ++tables.entries;
    }
  }
  return mean;
}

}  // namespace

AmplitudeTables make_amplitude_tables(CountedModel& tracer, const std::set<double>& directions,
                                      const AmplitudeGrid& grid,
                                      const std::function<void(double)>& progress) {
  AmplitudeTables tables{.grid = grid};
  const std::size_t columns = grid.a31.size(), lights = tracer.model.lights.size();
  for (const double phi : directions) {
    tables.of[phi].values.assign(lights, std::vector<double>(tables.nodes()));
  }
  const double total =
      static_cast<double>(grid.a20.size() * ((columns - 1) * directions.size() + 1));
  int done = 0;
  const auto put = [&](double phi, std::size_t node, const LogMaxima& maxima) {
    for (std::size_t k = 0; k < lights; ++k) tables.of[phi].values[k][node] = maxima[k];
  };
  for (std::size_t i = 0; i < grid.a20.size(); ++i) {
    const LogMaxima level = node_value(tracer, tables, grid.a20[i], 0, 0);
    if (progress) progress(++done / total);
    for (const double phi : directions) {
      put(phi, i * columns, level);
      for (std::size_t j = 1; j < columns; ++j) {
        put(phi, i * columns + j, node_value(tracer, tables, grid.a20[i], grid.a31[j], phi));
        if (progress) progress(++done / total);
      }
    }
  }
  return tables;
}

std::vector<double> with_border(const std::vector<double>& values, std::size_t rows,
                                std::size_t columns) {
  const auto along = [](std::size_t k, std::size_t count, auto at) {
    if (k == 0) return 2 * at(0) - at(1);
    if (k == count + 1) return 2 * at(count - 1) - at(count - 2);
    return at(k - 1);
  };
  std::vector<double> wider;
  for (std::size_t i = 0; i < rows + 2; ++i) {
    for (std::size_t j = 0; j < columns + 2; ++j) {
      wider.push_back(along(i, rows, [&](std::size_t row) {
        return along(j, columns, [&](std::size_t c) { return values[row * columns + c]; });
      }));
    }
  }
  return wider;
}

AmplitudeModel traced_model(const Preset& preset, const std::vector<RealFactor>& factors) {
  StreakRequest request = shard_request(preset, {.oscillation = preset.sets.front().index});
  request.environment.transfer_degree = -1;  // lights alone are fitted
  request.lights.clear();
  for (const RealFactor& factor : factors) {
    const auto& lights = request.lights;
    if (std::find(lights.begin(), lights.end(), factor.light) != lights.end()) continue;
    request.lights.push_back(factor.light);
  }
  const auto log_maxima = [request](double a20, double a31, double phi_drop_deg,
                                    std::uint64_t seed) {
    StreakRequest trial = request;
    trial.drop.modes.clear();
    if (a20 != 0) trial.drop.modes.push_back({.n = 2, .m = 0, .amplitude = a20});
    if (a31 != 0) trial.drop.modes.push_back({.n = 3, .m = 1, .amplitude = a31});
    trial.drop.phi_drop_rad = phi_drop_deg * std::numbers::pi / 180;
    trial.seed = seed;
    const TracedStreak streak = trace_streak(trial);
    LogMaxima maxima;
    for (std::size_t k = 0; k < streak.light.size(); ++k) {
      const auto& mean = streak.light[k].mean;
      const double brightest = *std::max_element(mean.begin(), mean.end());
      if (!(brightest > 0)) {
        throw std::runtime_error(fmt::format("{} of A20 = {}, A31 = {} is black; expected light",
                                             light_name(trial.lights[k]), a20, a31));
      }
      maxima.push_back(std::log10(brightest));
    }
    return maxima;
  };
  return {request.lights, log_maxima};
}

}  // namespace pluvia
