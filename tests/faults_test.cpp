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

#include "atlas/image_io.h"
#include "atlas/streak_atlas.h"
#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "tests/faulty_database.h"
#include "tests/realtime_fixture.h"
#include "tests/sample_database.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"
#include "validate/frame_composite.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

struct Fault {
  const char* name = "";   // also of the test
  const char* check = "";  // that must catch it
  std::function<Report(bool faulty)> report = {};
  bool draws = false;
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
  if (fault.draws) PLUVIA_NEEDS_OPENGL();
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

// --- the lookup of light, and the frame ---

// h -> -h: every picture is that of the lamp on the other side.
void mirror_cells(StreakAtlas& atlas) {
  for (AtlasLayer& layer : atlas.layers) {
    Image& picture = layer.point.at(0);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; x += atlas.cell_width_px) {
        float* const row = &picture.at(x, y);
        std::reverse(row, row + atlas.cell_width_px);
      }
    }
  }
}

Report lamp_report(bool faulty) {
  const TemporaryFolder folder;
  write_traced(folder.path(), {.oscillations = {0}});
  StreakAtlas atlas = pack_database(folder.path());
  if (faulty) mirror_cells(atlas);
  Report report;
  add_lamp_check(folder.path(), atlas, report);
  return report;
}

// The synthetic pictures as bright and as dense as those of a drop: it covers its disc, is as
// bright as a uniform environment, and scatters about a tenth of a lamp's light into a steradian.
StreakAtlas drop_like_atlas() {
  StreakAtlas atlas = quarter_atlas();
  const CellRect cell = cell_rect(atlas, 0, 0, 0);
  double covered_px = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x)
      covered_px += static_cast<double>(atlas.layers[0].coverage[0].at(cell.x + x, cell.y + y));
  }
  const double disc_px = std::numbers::pi * std::pow(atlas.mean_radius_m / atlas.pixel_m, 2);
  const auto scale = [](std::vector<Image>& levels, double factor) {
    for (Image& level : levels) {
      for (float& value : level.values) value *= static_cast<float>(factor);
    }
  };
  for (AtlasLayer& layer : atlas.layers) {  // synthetic: coverage 0.01, environment 0.2, lamps 1
    scale(layer.coverage, disc_px / covered_px);
    scale(layer.env, 0.01 / 0.2 * disc_px / covered_px);
    scale(layer.point, 0.1 * 0.01 * disc_px / covered_px);
  }
  return atlas;
}

// The renderer has the fault, its judge has not.
Report frame_report(const std::function<void(StreakAtlas&)>& spoil) {
  const Scene scene = rainy_scene(3000);
  const StreakAtlas atlas = drop_like_atlas();
  StreakAtlas drawn = atlas;
  if (spoil) spoil(drawn);
  RainRenderer renderer(scene, drawn);
  const Frame frame = renderer.render(0.5);
  const int sets = static_cast<int>(atlas.layers.size());
  const FrameComposite truth =
      composite_frame(scene, atlas, drop_field(scene, make_rain_space(scene), sets, 0.5),
                      sky_of(scene, atlas, 0), frame.background, frame.depth_m);
  Report report;
  add_frame_comparison("frame", scene, frame, truth, "a scene", report);
  return report;
}

Report frame_of_shifted_cells(bool faulty) {
  return frame_report(faulty ? shift_lights : std::function<void(StreakAtlas&)>());
}
Report frame_of_double_coverage(bool faulty) {
  return frame_report(faulty ? double_atlas_coverage : std::function<void(StreakAtlas&)>());
}

// A ramp over what a screen shows, and a little more.
Report png_report(bool faulty) {
  const double white = 2.5;
  Image frame = make_image(64, 16, 3);
  for (std::size_t i = 0; i < frame.values.size(); ++i)
    frame.values[i] = static_cast<float>(1.1 * white * static_cast<double>(i) / (64 * 16 * 3));
  // Encoded before write_png encodes.
  const auto png = faulty ? png_bytes(srgb_of(frame, white)) : png_bytes(frame, white);
  Report report;
  add_png_check("frame", png, frame, white, report);
  return report;
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
        Fault{"AtlasOfDoubleCoverage", "atlas.cells", atlas_of_double_coverage},
        Fault{"LookupOfMirroredAzimuth", "frame.lamp_side", lamp_report},
        Fault{"FrameOfCellsShiftedByOne", "frame.composite", frame_of_shifted_cells, true},
        Fault{"FrameOfDoubleCoverage", "frame.composite", frame_of_double_coverage, true},
        Fault{"GammaTwice", "frame.png", png_report}),
    [](const testing::TestParamInfo<Fault>& one) { return one.param.name; });

}  // namespace
}  // namespace pluvia
