// The validator can fail: every fault that a wrong build might have is put into what a check reads,
// and the check of that name sees it, and passes without it. docs/fidelity.md has the figures,
// which this prints.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "atlas/streak_atlas.h"
#include "tests/faulty_database.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

struct Fault {
  const char* name = "";   // also of the test
  const char* check = "";  // that must catch it
  std::function<Report(bool faulty)> report = {};
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

const Check& check_named(const Report& report, const std::string& name) {
  for (const Check& check : report.checks) {
    if (check.name == name) return check;
  }
  throw std::runtime_error(name + ": not in the report");
}

class Validator : public testing::TestWithParam<Fault> {};

TEST_P(Validator, Catches) {
  const Fault& fault = GetParam();
  const Report right_report = fault.report(false), wrong_report = fault.report(true);
  const Check& right = check_named(right_report, fault.check);
  const Check& wrong = check_named(wrong_report, fault.check);
  fmt::print("| {} | `{}` | {:.3g} | {:.3g} | {:.3g} | {} |\n", fault.name, fault.check,
             right.value, wrong.value, right.bound, right.unit);
  EXPECT_TRUE(passes(right)) << right.value << " > " << right.bound;
  EXPECT_FALSE(passes(wrong)) << wrong.value << " <= " << wrong.bound;
}

// --- the database ---

Report traced_report(const FaultyDatabase& database,
                     const std::function<void(const std::string& folder, Report&)>& add) {
  const TemporaryFolder folder;
  write_traced(folder.path(), database);
  Report report;
  add(folder.path(), report);
  return report;
}

void add_streaks(const std::string& folder, Report& report) {
  add_streak_checks(folder, {}, report);
}

// h -> -h: the picture of the lamp on the other side.
void swap_left_and_right(Shard& shard) {
  for (StreakImage& image : shard.light) {
    for (int y = 0; y < shard.height_px; ++y) {
      for (std::vector<float>* values : {&image.mean, &image.variance}) {
        const auto row = values->begin() + static_cast<std::ptrdiff_t>(y) * shard.width_px;
        std::reverse(row, row + shard.width_px);
      }
    }
  }
}

void shift_phases(StreakRequest& request) {
  for (Mode& mode : request.drop.modes) mode.phase_rad += std::numbers::pi / 2;
}

void double_coverage(Shard& shard) {
  for (float& value : shard.coverage.mean) value *= 2;
}

Report mirrored_database(bool faulty) {
  return traced_report({.oscillations = {6},
                        .written = faulty ? swap_left_and_right : std::function<void(Shard&)>()},
                       add_streaks);
}

Report database_without_order_2(bool faulty) {
  return traced_report(
      {.oscillations = {6},
       .traced = [&](StreakRequest& request) { request.field.paths.max_order -= faulty ? 1 : 0; }},
      add_streaks);
}

Report database_out_of_phase(bool faulty) {
  return traced_report({.oscillations = {6},
                        .traced = faulty ? shift_phases : std::function<void(StreakRequest&)>()},
                       add_streaks);
}

Report database_of_double_coverage(bool faulty) {
  return traced_report(
      {.oscillations = {0}, .written = faulty ? double_coverage : std::function<void(Shard&)>()},
      add_coverage_check);
}

// --- the atlas ---

Report atlas_report(bool faulty, const std::function<void(StreakAtlas&)>& spoil) {
  const TemporaryFolder folder;
  write_database(folder.path(), {.harmonics = 4});
  StreakAtlas atlas = pack_database(folder.path());
  if (faulty) spoil(atlas);
  Report report;
  add_atlas_checks(folder.path(), atlas, report);
  return report;
}

// Every light has the picture of its neighbour.
void shift_lights(StreakAtlas& atlas) {
  std::rotate(atlas.lights.begin(), atlas.lights.begin() + 1, atlas.lights.end());
}

// Means of 4 x 4 texels instead of 2 x 2, over the whole picture: a little of every neighbour.
Image half_size_with_bleeding(const Image& fine) {
  Image half = make_image(fine.width / 2, fine.height / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      for (int k = 0; k < 16; ++k) {
        const int from_x = std::clamp(2 * x - 1 + k % 4, 0, fine.width - 1);
        const int from_y = std::clamp(2 * y - 1 + k / 4, 0, fine.height - 1);
        half.at(x, y) += fine.at(from_x, from_y) / 16;
      }
    }
  }
  return half;
}

void bleed(StreakAtlas& atlas) {
  for (AtlasLayer& layer : atlas.layers) {
    for (std::size_t level = 1; level < layer.point.size(); ++level) {
      layer.point[level] = half_size_with_bleeding(layer.point[level - 1]);
    }
  }
}

void double_atlas_coverage(StreakAtlas& atlas) {
  for (AtlasLayer& layer : atlas.layers) {
    for (Image& level : layer.coverage) {
      for (float& value : level.values) value *= 2;
    }
  }
}

Report shifted_atlas(bool faulty) {
  return atlas_report(faulty, shift_lights);
}
Report bleeding_atlas(bool faulty) {
  return atlas_report(faulty, bleed);
}
Report atlas_of_double_coverage(bool faulty) {
  return atlas_report(faulty, double_atlas_coverage);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, Validator,
    testing::Values(
        Fault{"DatabaseOfMirroredAzimuth", "gn2006.brute_force.osc6.easy", mirrored_database},
        Fault{"DatabaseWithoutOrder2", "gn2006.brute_force.osc6.hard", database_without_order_2},
        Fault{"DatabaseAQuarterPeriodLate", "gn2006.brute_force.osc6.easy", database_out_of_phase},
        Fault{"DatabaseOfDoubleCoverage", "gn2006.sphere_coverage.osc0",
              database_of_double_coverage},
        Fault{"AtlasCellsShiftedByOne", "atlas.cells", shifted_atlas},
        Fault{"MipsThatBleed", "atlas.mips", bleeding_atlas},
        Fault{"AtlasOfDoubleCoverage", "atlas.cells", atlas_of_double_coverage}),
    [](const testing::TestParamInfo<Fault>& one) { return one.param.name; });

}  // namespace
}  // namespace pluvia
