#include "raytrace/preset.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

Preset tiny() {
  const TemporaryFolder folder;
  return read_preset(write_preset(folder.path()));
}

TEST(Preset, TinyPresetIsReadAsWritten) {
  const Preset preset = tiny();
  EXPECT_EQ(preset.name, "gn2006");
  EXPECT_EQ(preset.seed, 7u);
  EXPECT_EQ(preset.mean_radius_m, 1.6e-3);
  EXPECT_EQ(preset.fall_speed_m_s, 8.49);
  EXPECT_EQ(preset.cone_half_angle_deg, 5);
  EXPECT_EQ(preset.field.paths.max_order, 2);
  EXPECT_EQ(preset.field.base_cells, 4);
  EXPECT_EQ(preset.oscillations, (std::vector<int>{0, 3}));
  EXPECT_EQ(preset.view_elevations_deg, (std::vector<int>{80}));
  ASSERT_EQ(preset.sets.size(), 2u);
  EXPECT_EQ(preset.sets[1].index, 3);
  EXPECT_EQ(preset.sets[1].a31, 0.1);
}

// A refusal: the preset's or the sets' text changed in one place, and what the message must say.
struct Refusal {
  std::string from = {}, to = {};  // in the preset, or where it is not there, in the sets
  std::string file = "preset.toml";
  std::string says = {};  // after the file's name
};

void expect_refused(const Refusal& refusal) {
  const TemporaryFolder folder;
  std::string preset = tiny_preset, sets = tiny_sets;
  std::string& text = refusal.file == "preset.toml" ? preset : sets;
  text = replaced(text, refusal.from, refusal.to);
  const std::string file = write_preset(folder.path(), preset, sets);
  const std::string message = message_of([&] { read_preset(file); });
  EXPECT_THAT(message, HasSubstr((folder / refusal.file) + refusal.says)) << refusal.to;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(Preset, RefusalsNameFileLineColumnAndWhatIsExpected) {
  const std::string sets = "sets.toml";
  const Refusal refusals[] = {
      {"max_order = 2", "max_order = 2\nmax_ordr = 2", "preset.toml",
       ":18:1: unknown key \"max_ordr\" in [light]; did you mean \"max_order\"?"},
      {"cone_half_angle_deg = 5", "cone_half_angle_deg = 0.01", "preset.toml",
       ":16:1: cone_half_angle_deg = 0.01 deg; expected 0 (points at infinity) or 0.05 .. 30"},
      {"seed = 7", "sed = 7", "preset.toml", ":3:1: unknown key \"sed\"; did you mean \"seed\"?"},
      {"preset = \"gn2006\"", "preset = \"gn2007\"", "preset.toml",
       ":1:1: preset = \"gn2007\"; expected \"gn2006\""},
      {"1.6e-3", "nan", "preset.toml", ":6:1: drop.mean_radius_m = nan; expected"},
      {"fall_speed_m_s = 8.49", "fall_speed_m_s = inf", "preset.toml", ":13:1: "},
      {"fall_speed_m_s = 8.49", "fall_speed_m_s = 0", "preset.toml", ":13:1: "},
      {"refractive_index = 1.333", "refractive_index = 0.9", "preset.toml", ":9:1: "},
      {"width_px = 4", "width_px = 20", "preset.toml",
       ":20:1: width_px = 20; expected a power of two"},
      {"width_px = 4", "width_px = 128", "preset.toml", ":20:1: "},
      {"[80]", "[]", "preset.toml", ":21:1: view_elevations_deg is empty; expected"},
      {"[80]", "[-20]", "preset.toml", ":21:1: "},
      {"[0, 3]", "[]", "preset.toml", ":22:1: oscillations is empty; expected"},
      {"[0, 3]", "[0, 4]", "preset.toml", ":22:1: oscillation 4; expected one of"},
      {"[0, 3]", "[3, 0, 3]", "preset.toml", ":22:1: oscillations: 3 again; expected each once"},
      {"[80]", "[80, 80]", "preset.toml", ":21:1: view_elevations_deg: 80 again; expected"},
      {"max_order = 2", "max_order = 2\ngrid_step_deg = 15", "preset.toml",
       ":18:1: grid_step_deg = 15; expected 20, 10 or 5"},
      {"max_order = 2", "max_order = 2\ngrid_step_deg = 40", "preset.toml",
       ":18:1: light.grid_step_deg = 40; expected"},
      {"[0, 3]", "[0, 3]\ntransfer_degree = 9", "preset.toml",
       ":23:1: picture.transfer_degree = 9; expected"},
      {"[0, 3]", "[0, 3]\ntransfer_degree = -1", "preset.toml", ":23:1: "},
      {"slices = 3", "slices = 2.5", "preset.toml", ":25:1: accuracy.slices = 2.5; expected"},
      {"[accuracy]\nslices = 3", "[accuracy]", "preset.toml",
       ":24:1: accuracy.slices is missing; expected"},
      {"exposure_s = 0.01", "exposure_s = 0.02", "preset.toml", ":12:1: the drop falls to row"},
      {"index = 3", "index = 0", sets, ":7:1: index = 0 again; expected each index once"},
      {"A20 = 0.11", "A20 = 1.5", sets, ":8:1: "},
      {"A31 = 0.1\n", "A32 = 0.1\n", sets, ":6:1: "},
      {"A20 = 0.11\nA31 = 0.1\n", "A20 = 0.4\nA31 = 0.4\n", sets,
       ":8:1: set 3: the drop's surface comes as near as "},
      {tiny_sets, "", sets, ":1:1: no [[set]]; expected at least one oscillation set"},
  };
  for (const Refusal& refusal : refusals) expect_refused(refusal);
}

TEST(Preset, AConeOfZeroAsksForPointsAtInfinity) {
  const TemporaryFolder folder;
  const Preset preset = read_preset(write_preset(
      folder.path(), replaced(tiny_preset, "cone_half_angle_deg = 5", "cone_half_angle_deg = 0")));
  EXPECT_EQ(shard_request(preset, {.diameter_um = 3200, .oscillation = 3, .view_elevation_deg = 80})
                .cone_half_angle_rad,
            0);
}

TEST(Preset, LightsAreThoseOf2006OrOfTheGridThatIsAskedFor) {
  const TemporaryFolder folder;
  EXPECT_EQ(tiny().lights, gn2006_light_directions());
  EXPECT_EQ(preset_parameters(tiny()).find("lights"), std::string::npos);
  const Preset finer = read_preset(write_preset(
      folder.path(), replaced(tiny_preset, "max_order = 2", "max_order = 2\ngrid_step_deg = 10")));
  EXPECT_EQ(finer.lights, light_grid(10));
  EXPECT_EQ(shard_request(finer, {3200, 3, 80}).lights, light_grid(10));
  EXPECT_THAT(preset_parameters(finer), HasSubstr("\"light_v-80_h010\""));
}

TEST(Preset, TransferIsAParameterWhereItIsAskedForAlone) {
  const TemporaryFolder folder;
  const Preset none = tiny();
  EXPECT_EQ(none.transfer_degree, -1);
  EXPECT_EQ(preset_parameters(none).find("transfer"), std::string::npos);
  const Preset asked = read_preset(
      write_preset(folder.path(), replaced(tiny_preset, "[0, 3]", "[0, 3]\ntransfer_degree = 3")));
  EXPECT_EQ(asked.transfer_degree, 3);
  EXPECT_THAT(preset_parameters(asked), HasSubstr("\"transfer_degree\":3"));
  const StreakRequest request = shard_request(asked, {3200, 3, 80});
  EXPECT_EQ(request.environment.transfer_degree, 3);
  EXPECT_TRUE(request.environment.uniform);
}

TEST(Preset, MissingFilesAndTablesAreNamed) {
  const TemporaryFolder folder;
  const std::string file = write_preset(folder.path());
  std::filesystem::remove(folder / "sets.toml");
  EXPECT_THAT(message_of([&] { read_preset(file); }),
              HasSubstr((folder / "sets.toml") + ": cannot read: No such file or directory"));
  EXPECT_THAT(message_of([&] { read_preset(folder / "none.toml"); }),
              HasSubstr("none.toml: cannot read"));
  for (const std::string table : {"drop", "exposure", "light", "picture", "accuracy"}) {
    const std::string text = replaced(tiny_preset, fmt::format("[{}]", table), "[other]");
    EXPECT_THAT(message_of([&] { read_preset(write_preset(folder.path(), text)); }),
                HasSubstr(table))
        << table;
  }
}

TEST(Preset, LongestFallThatFitsThePictureIsAccepted) {
  // 16 px wide: the drop's radius is 5.6 px and its centre enters in row 9 of 525, so it may fall
  // 516 rows of 1.6 mm / 5.6, 147.43 mm.
  const TemporaryFolder folder;
  const auto with = [&](double speed_m_s) {
    return write_preset(folder.path(),
                        replaced(replaced(replaced(tiny_preset, "8.49", std::to_string(speed_m_s)),
                                          "0.016666666666666666", "0.01"),
                                 "width_px = 4", "width_px = 16"));
  };
  EXPECT_NO_THROW(read_preset(with(14.742)));
  EXPECT_THAT(message_of([&] { read_preset(with(14.744)); }),
              HasSubstr("expected at most 525 (exposure_s fall_speed_m_s <= 0.1474 m)"));
}

TEST(Preset, PicturesHaveTheHeightsOfThePublishedDatabase) {
  Preset preset = tiny();
  // The published sizes: 32 and 16 px wide, then halves and quarters rounded up.
  const struct {
    int width, height[5];
  } sizes[] = {{32, {1050, 988, 810, 544, 216}},
               {16, {525, 494, 405, 272, 108}},
               {8, {263, 247, 203, 136, 54}},
               {4, {132, 124, 102, 68, 27}}};
  for (const auto& size : sizes) {
    preset.width_px = size.width;
    for (int k = 0; k < 5; ++k) {
      const StreakFrame frame = gn2006_frame(preset, 20 * k);
      EXPECT_EQ(frame.width_px, size.width);
      EXPECT_EQ(frame.height_px, size.height[k]) << "width " << size.width << ", view " << 20 * k;
      EXPECT_NEAR(preset.mean_radius_m / frame.pixel_m, 0.35 * size.width, 1e-12);
      EXPECT_EQ(frame.centre_column, size.width / 2.0);
    }
  }
}

TEST(Preset, FallOfTheFullSpeedFills495RowsAtWidth16) {
  // 8.49 m/s / 60 s = 141.5 mm of fall, 285.71 um a pixel (1.6 mm / 5.6): 495.25 rows, and their
  // cosine as the view rises.
  Preset preset = tiny();
  preset.width_px = 16;
  for (const int view : {0, 20, 40, 60, 80}) {
    const StreakFrame frame = gn2006_frame(preset, view);
    EXPECT_NEAR(frame.path_rows, 495.25 * std::cos(view * std::numbers::pi / 180), 1e-9)
        << "view " << view;
    EXPECT_EQ(frame.path_top_row, 9);
    // The whole drop, 5.6 rows beyond its centre, stays in the picture at both ends.
    EXPECT_LT(frame.path_top_row + frame.path_rows + 5.6, frame.height_px) << "view " << view;
  }
}

TEST(Preset, PicturesBetweenThePublishedViewsHoldTheWholeFall) {
  Preset preset = tiny();
  preset.width_px = 16;
  for (int view = 0; view <= 80; ++view) {
    const StreakFrame frame = gn2006_frame(preset, view);
    EXPECT_LT(frame.path_top_row + frame.path_rows + 5.6, frame.height_px) << "view " << view;
  }
}

TEST(Preset, ParametersTellEveryFieldThatChangesTheBytes) {
  using Change = std::function<void(Preset&)>;
  const std::pair<const char*, Change> changes[] = {
      {"index", [](Preset& p) { p.sets[1].index = 5; }},
      {"A20", [](Preset& p) { p.sets[1].a20 += 1e-15; }},
      {"A31", [](Preset& p) { p.sets[1].a31 += 1e-15; }},
      {"phi_drop_deg", [](Preset& p) { p.sets[1].phi_drop_deg = 90; }},
      {"mean_radius_m", [](Preset& p) { p.mean_radius_m *= 1.001; }},
      {"density_kg_m3", [](Preset& p) { p.density_kg_m3 += 1e-9; }},
      {"surface_tension_n_m", [](Preset& p) { p.surface_tension_n_m += 1e-12; }},
      {"refractive_index", [](Preset& p) { p.field.paths.refractive_index += 1e-12; }},
      {"max_order", [](Preset& p) { p.field.paths.max_order = 3; }},
      {"min_power", [](Preset& p) { p.field.paths.min_power *= 2; }},
      {"exposure_s", [](Preset& p) { p.exposure_s += 1e-12; }},
      {"fall_speed_m_s", [](Preset& p) { p.fall_speed_m_s += 1e-12; }},
      {"cone_half_angle_deg", [](Preset& p) { p.cone_half_angle_deg += 1e-12; }},
      {"width_px", [](Preset& p) { p.width_px = 8; }},
      {"slices", [](Preset& p) { p.slices = 4; }},
      {"base_cells", [](Preset& p) { p.field.base_cells = 5; }},
      {"spans_per_period", [](Preset& p) { p.spans_per_period = 2; }},
      {"space_depth", [](Preset& p) { p.field.space_depth = 1; }},
      {"time_depth", [](Preset& p) { p.field.time_depth = 1; }},
      {"bend_tolerance", [](Preset& p) { p.field.bend_tolerance += 1e-12; }},
      {"motion_tolerance", [](Preset& p) { p.motion_tolerance += 1e-12; }}};
  const Preset preset = tiny();
  for (const auto& [field, change] : changes) {
    Preset other = preset;
    change(other);
    EXPECT_NE(preset_parameters(other), preset_parameters(preset)) << field;
    EXPECT_THAT(preset_parameters(preset), HasSubstr(fmt::format("\"{}\"", field)));
  }
  // A database may grow: what is traced is no parameter.
  Preset wider = preset;
  wider.view_elevations_deg = {0, 20};
  wider.oscillations = {0};
  EXPECT_EQ(preset_parameters(wider), preset_parameters(preset));
}

TEST(Preset, EveryShardHasASeedOfItsOwnThatFollowsFromItsKey) {
  const Preset preset = tiny();
  std::vector<std::uint64_t> seeds;
  for (const int oscillation : {0, 3}) {
    for (int view = 0; view <= 80; ++view) {
      const ShardKey key = {3200, oscillation, view};
      seeds.push_back(shard_request(preset, key).seed);
      EXPECT_EQ(shard_request(preset, key).seed, seeds.back());
    }
  }
  std::sort(seeds.begin(), seeds.end());
  EXPECT_EQ(std::adjacent_find(seeds.begin(), seeds.end()), seeds.end());
}

TEST(Preset, ShippedPresetsAreRead) {
  for (const std::string name : {"gn2006", "preview"}) {
    const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/" + name + ".toml");
    EXPECT_EQ(preset.sets.size(), 10u) << name;
    EXPECT_EQ(preset.oscillations.size(), 10u) << name;
  }
}

TEST(Preset, OscillationThatThePresetLacksIsRefused) {
  EXPECT_THROW(shard_request(tiny(), {3200, 4, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
