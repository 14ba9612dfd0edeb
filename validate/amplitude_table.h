// The table behind validate/amplitude_fit.h: logarithms of maxima over a grid of amplitudes, and
// the smooth surface through it. Only that file uses it.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include <ceres/cubic_interpolation.h>

#include "validate/amplitude_fit.h"

namespace pluvia {

// log10 of the brightest pixel of every light.
using LogMaxima = std::vector<double>;

struct CountedModel {
  const AmplitudeModel& model;
  int traced = 0;

  LogMaxima operator()(double a20, double a31, double phi_drop_deg, std::uint64_t seed) {
    ++traced;
    return model.log_maxima(a20, a31, phi_drop_deg, seed);
  }
  std::size_t light_index(const LightDirection& light) const {
    const auto at = std::find(model.lights.begin(), model.lights.end(), light);
    assert(at != model.lights.end());
    return static_cast<std::size_t>(at - model.lights.begin());
  }
};

// For one phi_drop: values[light][a20 index * a31 count + a31 index].
struct AmplitudeTable {
  std::vector<std::vector<double>> values = {};
};

struct AmplitudeTables {
  AmplitudeGrid grid = {};
  std::map<double, AmplitudeTable> of = {};  // by phi_drop_deg
  double noise_square = 0;                   // summed over entries
  std::size_t entries = 0;

  std::size_t nodes() const { return grid.a20.size() * grid.a31.size(); }
  double step_20() const { return grid.a20[1] - grid.a20[0]; }
  double step_31() const { return grid.a31[1] - grid.a31[0]; }
};

// A31 = 0 has no direction: its column is asked for once for all.
AmplitudeTables make_amplitude_tables(CountedModel& tracer, const std::set<double>& directions,
                                      const AmplitudeGrid& grid,
                                      const std::function<void(double)>& progress);

// The table with a border of linear continuation: Ceres repeats the last value there, which would
// bend the surface in its outermost cells.
std::vector<double> with_border(const std::vector<double>& values, std::size_t rows,
                                std::size_t columns);

// log10(ours / theirs) of one factor, minus the unit.
struct TableResidual {
  std::vector<double> table;
  using Grid = ceres::Grid2D<double, 1>;
  Grid grid;
  ceres::BiCubicInterpolator<Grid> surface;
  double step_20 = 0, step_31 = 0, log_theirs = 0;

  TableResidual(const AmplitudeTables& tables, const std::vector<double>& values, double theirs)
      : table(with_border(values, tables.grid.a20.size(), tables.grid.a31.size())),
        grid(table.data(), -1, static_cast<int>(tables.grid.a20.size()) + 1, -1,
             static_cast<int>(tables.grid.a31.size()) + 1),
        surface(grid),
        step_20(tables.step_20()),
        step_31(tables.step_31()),
        log_theirs(std::log10(theirs)) {}
  TableResidual(const TableResidual&) = delete;  // the surface refers to the grid beside it
  TableResidual& operator=(const TableResidual&) = delete;

  template <typename T>
  bool operator()(const T* unit, const T* a20, const T* a31, T* residual) const {
    T ours;
    surface.Evaluate(a20[0] / step_20, a31[0] / step_31, &ours);
    residual[0] = ours - log_theirs - unit[0];
    return true;
  }
};

}  // namespace pluvia
