#include "atlas/export_gn2006.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "atlas/atomic_file.h"
#include "atlas/atomic_folder.h"
#include "atlas/gray_png.h"
#include "atlas/streak_atlas.h"

namespace pluvia {
namespace {

constexpr int widest_px = gn2006_sizes_px.front();
constexpr double white = 65535;

using Records = std::vector<const ShardRecord*>;

int diameter_of(const std::string& file, const Manifest& manifest, int wanted_um) {
  std::set<int> diameters;
  for (const ShardRecord& record : manifest.shards) diameters.insert(record.key.diameter_um);
  if (diameters.contains(wanted_um)) return wanted_um;
  const std::string known = fmt::format("{}", fmt::join(diameters, ", "));
  if (wanted_um != 0) {
    throw std::runtime_error(
        fmt::format("{}: no drops of {} um; expected one of {}", file, wanted_um, known));
  }
  if (diameters.size() == 1) return *diameters.begin();
  throw std::runtime_error(fmt::format("{}: drops of {} um; expected one diameter (--diameter-mm)",
                                       file, diameters.empty() ? "no" : known));
}

// The 50 records of the layout: views of oscillation 0, then of 1 ..
Records records_of(const std::string& file, const Manifest& manifest, int diameter_um) {
  Records records;
  std::vector<std::string> missing;
  for (int oscillation = 0; oscillation < gn2006_oscillations; ++oscillation) {
    for (const int view : gn2006_views_deg) {
      const ShardKey key = {diameter_um, oscillation, view};
      const auto at = std::find_if(manifest.shards.begin(), manifest.shards.end(),
                                   [&](const ShardRecord& record) { return record.key == key; });
      if (at == manifest.shards.end()) {
        missing.push_back(shard_name(key));
      } else {
        records.push_back(&*at);
      }
    }
  }
  if (missing.empty()) return records;
  throw std::runtime_error(
      fmt::format("{}: {} of the layout's 50 shards missing: {}; expected oscillations 0 .. 9 at "
                  "views 0, 20, 40, 60, 80. run `pluvia generate` for them",
                  file, missing.size(), fmt::join(missing, ", ")));
}

bool is_wide_enough(int width_px) {
  return width_px >= widest_px && (width_px & (width_px - 1)) == 0;
}

int ceil_of_ratio(int a, int b) {
  return (a + b - 1) / b;
}

// Readers tell views apart by the heights of their pictures.
void check_sizes(const std::string& file, const Records& records) {
  const int width = records.front()->width_px;
  std::set<int> heights;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ShardRecord& record = *records[i];
    const ShardRecord& first = *records[i % gn2006_views_deg.size()];
    if (!is_wide_enough(width) || record.width_px != width || record.height_px != first.height_px) {
      throw std::runtime_error(
          fmt::format("{}: shard {}: {} x {} pixels; expected a width of {} or a power of two "
                      "above it, and one "
                      "size for each view",
                      file, shard_name(record.key), record.width_px, record.height_px, widest_px));
    }
    heights.insert(ceil_of_ratio(first.height_px, width / gn2006_sizes_px.back()));
  }
  if (heights.size() == gn2006_views_deg.size()) return;
  throw std::runtime_error(fmt::format(
      "{}: pictures 4 px wide would be {} px high; expected five heights for five views", file,
      fmt::join(heights, ", ")));
}

// Values in double, row by row.
struct Picture {
  int width = 0, height = 0;
  std::vector<double> values = {};
};

// Averages of n x n pixels; those beyond the last row are black.
template <typename Value>
Picture averaged(int width, int height, const std::vector<Value>& values, int n) {
  Picture small = {.width = width / n, .height = ceil_of_ratio(height, n)};
  small.values.assign(
      static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height), 0.0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto from = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x);
      const auto to = static_cast<std::size_t>(y / n) * static_cast<std::size_t>(small.width) +
                      static_cast<std::size_t>(x / n);
      small.values[to] += static_cast<double>(values[from]);
    }
  }
  for (double& value : small.values) value /= static_cast<double>(n) * n;
  return small;
}

double maximum(const Picture& picture) {
  return *std::max_element(picture.values.begin(), picture.values.end());
}

// Value / scale x 65535, rounded; black where the scale is 0.
GrayPicture quantised(const Picture& picture, double scale) {
  GrayPicture gray = {.width = picture.width, .height = picture.height};
  gray.values.reserve(picture.values.size());
  for (const double value : picture.values) {
    const double step = scale > 0 ? std::floor(value / scale * white + 0.5) : 0;
    gray.values.push_back(static_cast<std::uint16_t>(step));
  }
  return gray;
}

// Where the pictures of one shard go.
struct Target {
  std::string folder = {};
  Normalise normalise = Normalise::shared;
  double level_scale = 1;  // of S to brightness
};

// Writes a picture in all sizes and returns its factor. The smaller ones are averages of the 16-bit
// values, so that they follow from the largest alone, also after an import.
template <typename Name>
double write_sizes(const Target& target, Picture picture, Name name) {
  for (double& value : picture.values) value *= target.level_scale;
  const double factor = gn2006_told_factor(maximum(picture));
  const GrayPicture largest = quantised(picture, factor);
  for (const int size : gn2006_sizes_px) {
    const Picture small = averaged(largest.width, largest.height, largest.values, widest_px / size);
    const double scale = target.normalise == Normalise::each ? maximum(small) : white;
    write_file_plainly(target.folder + "/" + name(size), gray_png_bytes(quantised(small, scale)));
  }
  return factor;
}

Picture widest(const Shard& shard, const StreakImage& image) {
  return averaged(shard.width_px, shard.height_px, image.mean, shard.width_px / widest_px);
}

double level_scale(const std::string& file, const Shard& shard, StreakLevel level) {
  if (level == StreakLevel::exposure) return 1;
  const double covered = maximum(widest(shard, shard.coverage));
  if (covered > 0) return 1 / covered;
  throw std::runtime_error(file + ": part coverage: 0 everywhere; expected a drop");
}

void check_parts(const std::string& file, const Shard& shard) {
  if (shard.env.mean.empty()) {
    throw std::runtime_error(file + ": part env is missing; expected it as the layout has it");
  }
  if (shard.lights != gn2006_light_directions()) {
    throw std::runtime_error(fmt::format("{}: {} light directions; expected the layout's 74", file,
                                         shard.lights.size()));
  }
}

// The factors go into the oscillation's place.
void export_shard(const std::string& database, const ShardRecord& record, const std::string& folder,
                  const ExportOptions& options, ViewFactors& factors) {
  Shard shard = read_whole_shard(database, record);
  const std::string file = (std::filesystem::path(database) / record.file).string();
  check_parts(file, shard);
  keep_one_band(file, options.band, shard);
  const int view = record.key.view_elevation_deg, oscillation = record.key.oscillation;
  const auto place = static_cast<std::size_t>(oscillation);
  const Target target = {.folder = folder,
                         .normalise = options.normalise,
                         .level_scale = level_scale(file, shard, options.level)};
  factors.env[place] = write_sizes(target, widest(shard, shard.env), [&](int size) {
    return gn2006_env_picture(size, view, oscillation);
  });
  for (std::size_t i = 0; i < shard.lights.size(); ++i) {
    const LightDirection& light = shard.lights[i];
    factors.point[i][place] = write_sizes(target, widest(shard, shard.light[i]), [&](int size) {
      return gn2006_point_picture(size, view, light, oscillation);
    });
  }
}

void make_folders(const std::string& folder) {
  const auto make_parent = [&](const std::string& name) {
    make_folder(std::filesystem::path(folder + "/" + name).parent_path().string());
  };
  make_parent(gn2006_env_factor_file());
  make_parent(gn2006_point_factor_file(0));
  for (const int size : gn2006_sizes_px) {
    make_parent(gn2006_env_picture(size, 0, 0));
    for (const int view : gn2006_views_deg) make_parent(gn2006_point_picture(size, view, {}, 0));
  }
}

void fill_layout(const std::string& database, const Records& records, const std::string& folder,
                 const ExportOptions& options) {
  make_folders(folder);
  std::vector<ViewFactors> views;
  for (const int view : gn2006_views_deg) {
    views.push_back({.view_elevation_deg = view, .point = {}});
    views.back().point.resize(gn2006_light_directions().size());
  }
  tbb::parallel_for(std::size_t{0}, records.size(), [&](std::size_t i) {
    export_shard(database, *records[i], folder, options, views[i % views.size()]);
  });
  write_file_plainly(folder + "/" + gn2006_env_factor_file(), gn2006_env_factor_text(views));
  for (const ViewFactors& view : views) {
    write_file_plainly(folder + "/" + gn2006_point_factor_file(view.view_elevation_deg),
                       gn2006_point_factor_text(view));
  }
}

}  // namespace

ExportSummary export_gn2006(const std::string& database_folder, const std::string& out,
                            const ExportOptions& options) {
  const Manifest manifest = read_manifest(database_folder);
  const std::string file = (std::filesystem::path(database_folder) / "manifest.json").string();
  const int diameter_um = diameter_of(file, manifest, options.diameter_um);
  const Records records = records_of(file, manifest, diameter_um);
  check_sizes(file, records);
  build_folder_atomically(out, [&](const std::string& temporary) {
    fill_layout(database_folder, records, temporary, options);
  });
  const std::size_t shown = gn2006_light_directions().size() + 1;
  return {.pictures = static_cast<int>(records.size() * shown * gn2006_sizes_px.size()),
          .shards_left_out = static_cast<int>(manifest.shards.size() - records.size())};
}

}  // namespace pluvia
