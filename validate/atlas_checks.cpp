#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "validate/checks.h"

namespace pluvia {

namespace {

struct WorstCell {
  double deviation = 0;
  std::string where = {};  // for people; empty: no cell deviates
};

struct WorstCells {
  WorstCell finest = {}, coarser = {};
};

// What the next coarser level of one cell should be, in double: means of 2 x 2, zeros below its
// last row.
struct CellPicture {
  int width = 0, height = 0;
  std::vector<double> values = {};
};

CellPicture coarser(const CellPicture& fine) {
  CellPicture half = {fine.width / 2, (fine.height + 1) / 2};
  half.values.assign(static_cast<std::size_t>(half.width * half.height), 0);
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < 2 * half.width; ++x) {
      half.values[static_cast<std::size_t>(y / 2 * half.width + x / 2)] +=
          fine.values[static_cast<std::size_t>(y * fine.width + x)] / 4;
    }
  }
  return half;
}

// Largest difference between the atlas's texels and those, over the largest texel of level 0. A
// cell that should be black and is not is infinitely far off.
double cell_deviation(const Image& picture, const CellRect& cell, const CellPicture& expected,
                      double scale) {
  double worst = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x) {
      const double goal = expected.values[static_cast<std::size_t>(y * expected.width + x)];
      worst = std::max(worst, std::abs(picture.at(cell.x + x, cell.y + y) - goal));
    }
  }
  return worst == 0 ? 0 : worst / scale;
}

void keep_worst(WorstCell& worst, double deviation, const std::string& where) {
  if (deviation > worst.deviation) worst = {deviation, where};
}

struct CellSource {  // one cell of the atlas and what the database has for it
  const std::vector<Image>& levels;
  int view = 0, column = 0;
  const std::vector<float>& values;
  std::string name = {};
};

void compare_cell(const StreakAtlas& atlas, const CellSource& source, WorstCells& worst) {
  const CellRect finest = cell_rect(atlas, source.view, source.column, 0);
  CellPicture expected = {
      finest.width, finest.height, {source.values.begin(), source.values.end()}};
  double scale = 0;
  for (const double value : expected.values) scale = std::max(scale, std::abs(value));
  for (int level = 0; level < static_cast<int>(source.levels.size()); ++level) {
    const CellRect cell = cell_rect(atlas, source.view, source.column, level);
    const double deviation =
        cell_deviation(source.levels[static_cast<std::size_t>(level)], cell, expected, scale);
    keep_worst(level == 0 ? worst.finest : worst.coarser, deviation,
               fmt::format("{}, level {}", source.name, level));
    expected = coarser(expected);
  }
}

// Under a sky of radiance Y_00 a drop that keeps no light is 1 / sqrt(4 pi) where it is.
std::vector<float> under_first_harmonic(const std::vector<float>& coverage) {
  std::vector<float> values;
  for (const float share : coverage)
    values.push_back(static_cast<float>(share / std::sqrt(4 * std::numbers::pi)));
  return values;
}

// Every cell of one row of cells. A light that the database does not have is as wrong as can be.
void compare_view(const StreakAtlas& atlas, const AtlasLayer& layer, int view, const Shard& shard,
                  WorstCells& worst) {
  const std::string shown = shard_name(shard.key) + ", ";
  for (std::size_t i = 0; i < atlas.lights.size(); ++i) {
    const std::string name = shown + light_name(atlas.lights[i]);
    const auto at = std::find(shard.lights.begin(), shard.lights.end(), atlas.lights[i]);
    if (at == shard.lights.end()) {
      keep_worst(worst.finest, std::numeric_limits<double>::infinity(), name);
      continue;
    }
    const auto& mean = shard.light[static_cast<std::size_t>(at - shard.lights.begin())].mean;
    compare_cell(atlas, {layer.point, view, static_cast<int>(i), mean, name}, worst);
  }
  for (std::size_t i = 0; i < shard.transfer.size(); ++i) {
    const bool whole = atlas.rest_from_sky && i == 0;
    compare_cell(atlas,
                 {layer.transfer, view, static_cast<int>(i),
                  whole ? under_first_harmonic(shard.coverage.mean) : shard.transfer[i].mean,
                  shown + transfer_name(i)},
                 worst);
  }
  if (!shard.env.mean.empty()) {
    const auto& mean = atlas.rest_from_sky ? shard.coverage.mean : shard.env.mean;
    compare_cell(atlas, {layer.env, view, 0, mean, shown + "env"}, worst);
  }
  compare_cell(atlas, {layer.coverage, view, 0, shard.coverage.mean, shown + "coverage"}, worst);
}

WorstCells worst_cells(const std::string& folder, const Manifest& manifest,
                       const StreakAtlas& atlas) {
  WorstCells worst;
  for (const ShardRecord& record : manifest.shards) {
    if (record.key.diameter_um != atlas.diameter_um) continue;
    const auto layer = std::find_if(
        atlas.layers.begin(), atlas.layers.end(),
        [&](const AtlasLayer& other) { return other.oscillation == record.key.oscillation; });
    const auto view =
        std::find_if(atlas.views.begin(), atlas.views.end(), [&](const AtlasView& other) {
          return other.elevation_deg == record.key.view_elevation_deg;
        });
    if (layer == atlas.layers.end() || view == atlas.views.end()) {
      keep_worst(worst.finest, std::numeric_limits<double>::infinity(), shard_name(record.key));
      continue;
    }
    compare_view(atlas, *layer, static_cast<int>(view - atlas.views.begin()),
                 read_whole_shard(folder, record), worst);
  }
  return worst;
}

std::string told(const std::string& why, const WorstCell& worst) {
  return worst.where.empty() ? why : fmt::format("{} Worst: {}.", why, worst.where);
}

}  // namespace

void add_atlas_checks(const std::string& database_folder, const StreakAtlas& atlas,
                      Report& report) {
  const Manifest manifest = read_manifest(database_folder);
  const std::string names = "atlas.cells, atlas.mips: ";
  if (atlas.database_sha256 != sha256(read_file(database_folder + "/manifest.json"))) {
    report.skipped.push_back(names +
                             "the atlas was packed from another database, or before this "
                             "one grew");
    return;
  }
  if (manifest.bands.size() > 1) {
    report.skipped.push_back(names +
                             "the database has several bands, and an atlas does not tell "
                             "which it holds");
    return;
  }
  const WorstCells worst = worst_cells(database_folder, manifest, atlas);
  report.checks.push_back(deviation(
      "atlas.cells", worst.finest.deviation, 0, 0, "of the cell's largest",
      told("Largest difference between a texel of the atlas and the pixel of the database that its "
           "view, light and oscillation name. Packing copies: none is the bound. Both are "
           "deterministic: no uncertainty.",
           worst.finest)));
  // Half a step of float for each level, of values no larger than the cell's largest.
  const double bound = (atlas.levels - 1) * 0x1p-24;
  report.checks.push_back(deviation(
      "atlas.mips", worst.coarser.deviation, 0, bound, "of the cell's largest",
      told("The same of every coarser level, against means over the cell's own pixels in double, "
           "zeros beyond its last row: what another cell lends or a level loses is seen. The bound "
           "is one rounding to float for each level.",
           worst.coarser)));
}

}  // namespace pluvia
