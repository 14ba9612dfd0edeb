#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "oscillation/equilibrium.h"
#include "oscillation/water.h"
#include "raytrace/preset.h"
#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

constexpr double pi = std::numbers::pi;

Preset tiny() {
  const TemporaryFolder folder;
  return read_preset(write_physical(folder.path()));
}

// With these sets and diameters, whatever the file said.
Preset with(std::vector<OscillationSet> sets, std::vector<int> diameters_um) {
  Preset preset = tiny();
  preset.sets = std::move(sets);
  preset.physical->diameters_um = std::move(diameters_um);
  preset.physical->amplitude = {};
  return preset;
}

TEST(PhysicalPreset, TinyPresetIsReadAsWritten) {
  const Preset preset = tiny();
  ASSERT_TRUE(preset.physical);
  EXPECT_EQ(diameters_of(preset), (std::vector<int>{500, 3000}));
  EXPECT_EQ(preset.view_elevations_deg, (std::vector<int>{-80, 80}));
  EXPECT_EQ(preset.physical->span_s, 0.008);
  EXPECT_FALSE(preset.environment);
  EXPECT_EQ(preset.density_kg_m3, water_density_kg_m3(20));
  EXPECT_EQ(preset.surface_tension_n_m, water_surface_tension_n_m(20));
  const auto bands = bands_of(preset);
  ASSERT_EQ(bands.size(), 2u);
  EXPECT_EQ(bands[0].name, "blue");
  EXPECT_EQ(bands[0].refractive_index, drop_index(20, 101325, 450));
  EXPECT_EQ(bands[1].refractive_index, drop_index(20, 101325, 650));
  ASSERT_EQ(preset.sets.size(), 2u);
  ASSERT_EQ(preset.sets[1].modes.size(), 2u);
  EXPECT_EQ(preset.sets[1].modes[1].n, 3);
  EXPECT_DOUBLE_EQ(preset.sets[1].modes[1].phase_rad, pi / 2);
}

TEST(PhysicalPreset, SizesFallAtTheirOwnSpeedAndLargeOnesAreFlat) {
  const Preset preset = tiny();
  for (const int um : {100, 500, 1000, 2500, 6000, 7000}) {
    const SizeRecord size = size_of(preset, um);
    EXPECT_EQ(size.fall_speed_m_s, fall_speed_m_s(um * 1e-6)) << um;
    EXPECT_EQ(size.mean_radius_m, um * 0.5e-6) << um;
  }
  double before = 1;
  for (int um = 500; um <= 6000; um += 250) {
    const DropInstant drop = drop_at(physical_drop(*preset.physical, preset.sets[0], um), 0);
    const double wide = surface_radius_m(drop, pi / 2, 0);
    const double ratio =
        (surface_radius_m(drop, 0, 0) + surface_radius_m(drop, pi, 0)) / (2 * wide);
    EXPECT_LT(ratio, before) << um << " um: not flatter than a smaller drop";
    before = ratio;
    // The time-mean axis ratio polynomial (data on shapes at rest), which Chuang and Beard's shapes
    // follow to 0.011 at 3 to 4.5 mm, and to 0.02 at 6.
    const double d = um / 1000.0;
    const double known = 1.0048 + d * (5.7e-4 + d * (-2.628e-2 + d * (3.682e-3 - d * 1.677e-4)));
    EXPECT_NEAR(ratio, known, 0.02) << um;
  }
}

TEST(PhysicalPreset, VolumeAndCentroidAreKeptWhileTheDropOscillates) {
  const Preset preset = with({{.index = 0,
                               .phi_drop_deg = 30,
                               .modes = {{.n = 2, .m = 0, .amplitude = 0.1},
                                         {.n = 3, .m = 1, .amplitude = 0.05, .phase_rad = 1},
                                         {.n = 8, .m = 4, .amplitude = 1e-5}}}},
                             {});
  for (const int um : {100, 1000, 3000, 7000}) {
    const DropShape shape = physical_drop(*preset.physical, preset.sets[0], um);
    for (const double time_s : {0.0, 1e-3, 7.3e-3, 1.0}) {
      const DropInstant drop = drop_at(shape, time_s);
      const double r0 = um * 0.5e-6;
      // The quadrature is exact for these polynomials: rounding only.
      EXPECT_NEAR(volume_m3(drop) / (4 * pi / 3 * r0 * r0 * r0), 1, 1e-12) << um << ", " << time_s;
      EXPECT_LT((drop.origin_m + centroid_m(drop)).norm(), 1e-12 * r0) << um << ", " << time_s;
    }
  }
}

TEST(PhysicalPreset, ARigidSphereHasNoSums) {
  Preset preset = tiny();
  preset.physical->equilibrium = {};
  const DropShape sphere = physical_drop(*preset.physical, preset.sets[0], 3000);
  EXPECT_TRUE(sphere.modes.empty() && sphere.equilibrium_cos.empty());
  EXPECT_FALSE(sphere.keep_volume || sphere.keep_centroid);
  // Below the onset of oscillation the other set is rigid, too, if not a sphere.
  const DropShape small = physical_drop(*tiny().physical, preset.sets[1], 500);
  EXPECT_TRUE(is_rigid(small));
  EXPECT_EQ(small.equilibrium_cos.size(), 11u);
}

TEST(PhysicalPreset, AmplitudesFollowTheirFactorOfTheDiameter) {
  const AmplitudeFactor table = {.diameter_m = {1e-3, 2e-3, 4e-3}, .factor = {0, 1, 0.5}};
  const double known[][2] = {{0.1e-3, 0},  {1e-3, 0},   {1.25e-3, 0.25}, {2e-3, 1},
                             {3e-3, 0.75}, {4e-3, 0.5}, {7e-3, 0.5}};
  for (const auto& [d, factor] : known) EXPECT_DOUBLE_EQ(amplitude_factor(table, d), factor) << d;
  EXPECT_EQ(amplitude_factor({}, 1e-3), 1);
}

// The farthest point from the frame's centre at many instants in all directions.
double sampled_reach_m(const DropShape& shape, double& least_radius) {
  double reach = 0;
  least_radius = 1e300;
  for (int i = 0; i < 24; ++i) {
    const DropInstant drop = drop_at(shape, i * 0.00437);
    for (int a = 0; a <= 36; ++a) {
      for (int b = 0; b < 18; ++b) {
        const double theta = a * pi / 36, phi = b * pi / 9;
        const Eigen::Vector3d u(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                std::cos(theta));
        const double r = surface_radius_m(drop, u);
        reach = std::max(reach, (drop.origin_m + r * u).norm());
        least_radius = std::min(least_radius, r / shape.mean_radius_m);
      }
    }
  }
  return reach;
}

TEST(PhysicalPreset, EveryPictureHoldsTheWholeDropAtAnyTime) {
  const std::vector<OscillationSet> sets = {
      {.index = 0},
      {.index = 1, .modes = {{.n = 2, .m = 0, .amplitude = 0.2}}},
      {.index = 3,
       .modes = {{.n = 2, .m = 1, .amplitude = 0.1}, {.n = 3, .m = 1, .amplitude = 0.05}}},
      {.index = 5, .modes = {{.n = 8, .m = 0, .amplitude = 0.05}}}};
  for (const int um : {100, 1600, 3200, 7000}) {
    const Preset preset = with(sets, {um});
    double largest = 0;
    for (const OscillationSet& set : sets) {
      const DropShape shape = physical_drop(*preset.physical, set, um);
      double least_radius = 0;
      const double sampled = sampled_reach_m(shape, least_radius);
      EXPECT_LE(sampled, drop_reach_m(shape)) << um << ", set " << set.index;
      // Worst phases at once, and the margin of the centroid: not far from what samples find.
      EXPECT_LT(drop_reach_m(shape), 1.15 * sampled) << um << ", set " << set.index;
      EXPECT_LE(least_relative_radius(shape), least_radius) << um << ", set " << set.index;
      largest = std::max(largest, sampled);
    }
    for (const int view : {-80, -20, 0, 45, 80}) {
      const StreakFrame frame = physical_frame(preset, um, view);
      const double reach_px = largest / frame.pixel_m;
      EXPECT_LE(frame.centre_column + reach_px, frame.width_px - 1) << um << ", view " << view;
      EXPECT_GE(frame.path_top_row - reach_px, 1) << um << ", view " << view;
      EXPECT_LE(frame.path_top_row + frame.path_rows + reach_px, frame.height_px - 1);
      EXPECT_LT(frame.height_px, frame.path_rows + frame.width_px + 1) << um;
    }
  }
}

TEST(PhysicalPreset, ExposuresFromAMicrosecondToASecondHaveAPicture) {
  for (const double span_s : {1e-6, 1.0}) {
    const TemporaryFolder folder;
    std::string text =
        replaced(tiny_physical, "span_s = 0.008", fmt::format("span_s = {}", span_s));
    text = replaced(text, "exposure_s = 0.004", fmt::format("exposure_s = {}", span_s));
    const Preset preset = read_preset(write_physical(folder.path(), text));
    const SizeRecord size = size_of(preset, 3000);
    const StreakFrame frame = physical_frame(preset, 3000, -80);
    EXPECT_NEAR(frame.path_rows * frame.pixel_m,
                size.fall_speed_m_s * span_s * std::cos(80 * pi / 180), 1e-12);
    const StreakRequest request = shard_request(preset, {3000, 3, -80}, 1);
    EXPECT_EQ(request.exposure_s, span_s);
    // Three instants for each period of mode 3: (30 sigma / rho / r0^3)^(1/2) / (2 pi) = 128 Hz.
    EXPECT_EQ(request.slices,
              span_s < 1e-3 ? 1
                            : static_cast<int>(std::ceil(
                                  3 * span_s * mode_frequency_rad_s(request.drop, 3) / (2 * pi))));
  }
}

struct Refusal {
  std::string from = {}, to = {}, says = {};
};

TEST(PhysicalPreset, RefusalsNameFileLineColumnAndWhatIsExpected) {
  const Refusal refusals[] = {
      {"[3, 0.5]", "[3, 7.1]",
       ":6:1: drop.diameters_mm[1] = 7.1; expected 0.01 <= diameters_mm[1]"},
      {"[3, 0.5]", "[8]", "diameters_mm[0] = 8; expected"},
      {"[3, 0.5]", "[0]", "diameters_mm[0] = 0; expected"},
      {"[3, 0.5]", "[nan]", "diameters_mm[0] = nan; expected"},
      {"[3, 0.5]", "[]", ":6:1: diameters_mm is empty; expected some"},
      {"[3, 0.5]", "3", ":6:1: drop.diameters_mm = 3; expected an array of numbers"},
      {"[3, 0.5]", "[3, 3.0]", ":6:1: diameter 3 mm again; expected each once"},
      {"[3, 0.5]", "[3.0004]", ":6:1: diameter 3.0004 mm; expected whole micrometres"},
      {"temperature_c = 20", "temperature_c = -1", ":7:1: drop.temperature_c = -1; expected 0 <="},
      {"temperature_c = 20", "temperature_c = 51", ":7:1: drop.temperature_c = 51"},
      {"temperature_c = 20", "temperature_c = 20\npressure_pa = 1", ":8:1: drop.pressure_pa = 1"},
      {"temperature_c = 20", "temperature_c = 20\nmean_radius_m = 1",
       "unknown key \"mean_radius_m\""},
      {"\"equilibrium.csv\"", "\"none.csv\"", "none.csv: cannot read"},
      {"span_s = 0.008", "span_s = 0.003", ":12:1: exposure.span_s = 0.003; expected 0.004 <="},
      {"exposure_s = 0.004", "exposure_s = 0", ":11:1: exposure.exposure_s = 0; expected"},
      {"max_order = 2", "max_order = 2\nwavelength_nm = 600",
       "has two of wavelength_nm, bands, band"},
      {"max_order = 2", "max_order = 2\nbands = \"rgb\"", "has two of wavelength_nm, bands, band"},
      {"max_order = 2", "max_order = 2\nbands = \"rbg\"",
       ":17:1: bands = \"rbg\"; expected \"rgb\""},
      {"\"red\"", "\"blue\"", "band \"blue\" again; expected each name once"},
      {"\"red\"", "\"deep red\"", "band \"deep red\"; expected up to 20 letters"},
      {"\"red\"", "\"red.x\"", "band \"red.x\"; expected"},
      {"\"red\"", "\"\"", "band \"\"; expected"},
      {"650", "1200", "wavelength_nm = 1200; expected 300 <= wavelength_nm <= 1100 nm"},
      {"[-80, 80]", "[-90]", "view_elevations_deg[0] = -90; expected an integer, -80 <="},
      {"slices_per_row = 0.05", "slices = 3", "accuracy.slices_per_row is missing; expected"}};
  for (const Refusal& refusal : refusals) {
    const TemporaryFolder folder;
    const std::string file =
        write_physical(folder.path(), replaced(tiny_physical, refusal.from, refusal.to));
    const std::string message = message_of([&] { read_preset(file); });
    EXPECT_THAT(message, HasSubstr(refusal.says)) << refusal.to;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(PhysicalPreset, SetsThatCannotBeAreRefused) {
  const Refusal refusals[] = {
      {"n = 3, m = 1", "n = 1, m = 1", "sets.toml:7:"},
      {"n = 3, m = 1", "n = 11, m = 1", ".n = 11; expected an integer, 2 <= n <= 10"},
      {"n = 3, m = 1", "n = 3, m = 4", ".m = 4; expected an integer, 0 <= m <= 3"},
      {"phase_deg", "phase_rad", "unknown key \"phase_rad\""},
      {"amplitude = 0.1", "amplitude = -0.9",
       "sets.toml:7:1: set 3: the drop's surface comes as near"},
      {"[1, 2]", "[2, 1]", "sets.toml:9:1: diameters_mm out of order; expected ascending"},
      {"[0, 1]", "[0]", "sets.toml:10:1: 1 factors for 2 diameters; expected one each"},
      {"[0, 1]", "[-1, 1]", "factors[0] = -1; expected 0 <= factors[0] <= 10"},
      {"index = 3\nphi_drop_deg = 0", "index = 3\nphi_drop_deg = 90",
       "sets.toml: set 3: its left-right mirror image is not set 3; expected"}};
  for (const Refusal& refusal : refusals) {
    const TemporaryFolder folder;
    const std::string file = write_physical(folder.path(), tiny_physical,
                                            replaced(tiny_physical_sets, refusal.from, refusal.to));
    EXPECT_THAT(message_of([&] { read_preset(file); }), HasSubstr(refusal.says)) << refusal.to;
  }
}

TEST(PhysicalPreset, PicturesOfMoreThanAMillionRowsAreRefused) {
  // 2 m/s for 10 s in pixels of 0.25 mm / 15: 1.2 million rows.
  const TemporaryFolder folder;
  std::string text = replaced(tiny_physical, "span_s = 0.008", "span_s = 10");
  text = replaced(text, "width_px = 8", "width_px = 32");
  EXPECT_THAT(message_of([&] { read_preset(write_physical(folder.path(), text)); }),
              HasSubstr(":12:1: drops of 0.5 mm fall 12"));
}

TEST(PhysicalPreset, TransverseModesAreMirroredByTurnsOfTheirOwn) {
  // cos 2(phi - phi_drop): 90 and -90 degrees are the same drop.
  const OscillationSet two = {
      .index = 3, .phi_drop_deg = 90, .modes = {{.n = 2, .m = 2, .amplitude = 0.1}}};
  EXPECT_NO_THROW(refuse_wrong_mirrors("f", {two}));
  OscillationSet three = two;
  three.modes[0] = {.n = 3, .m = 3, .amplitude = 0.1};
  EXPECT_THROW(refuse_wrong_mirrors("f", {three}), std::runtime_error);
  three.phi_drop_deg = 60;
  EXPECT_NO_THROW(refuse_wrong_mirrors("f", {three}));
}

TEST(PhysicalPreset, BandsAreOneThreeOrNamed) {
  const TemporaryFolder folder;
  const std::string band_line =
      "band = [{ name = \"red\", wavelength_nm = 650 }, { name = \"blue\", wavelength_nm = 450 "
      "}]\n";
  const auto bands_with = [&](const std::string& line) {
    return bands_of(
        read_preset(write_physical(folder.path(), replaced(tiny_physical, band_line, line))));
  };
  EXPECT_EQ(
      bands_with("").front(),
      (Band{.name = "Y", .wavelength_nm = 589, .refractive_index = drop_index(20, 101325, 589)}));
  EXPECT_EQ(bands_with("wavelength_nm = 700\n").front().wavelength_nm, 700);
  const auto rgb = bands_with("bands = \"rgb\"\n");
  ASSERT_EQ(rgb.size(), 3u);
  // Means over the (signed) matching functions of Rec.709 under equal energy at 20 C: R 1.33164, G
  // 1.33445, B 1.33990; dispersion's curvature over a band moves the mean by less than 3e-4.
  EXPECT_NEAR(rgb[2].refractive_index, 1.33164, 3e-4);
  EXPECT_NEAR(rgb[1].refractive_index, 1.33445, 3e-4);
  EXPECT_NEAR(rgb[0].refractive_index, 1.33990, 3e-4);
  EXPECT_EQ(rgb[0].name + rgb[1].name + rgb[2].name, "BGR");
}

TEST(PhysicalPreset, ParametersTellEveryFieldThatChangesTheBytes) {
  using Change = std::function<void(Preset&)>;
  const std::pair<const char*, Change> changes[] = {
      {"modes", [](Preset& p) { p.sets[1].modes[0].phase_rad += 1e-12; }},
      {"phi_drop_deg", [](Preset& p) { p.sets[1].phi_drop_deg += 1e-9; }},
      {"temperature_c", [](Preset& p) { p.physical->air.temperature_c += 1e-9; }},
      {"pressure_pa", [](Preset& p) { p.physical->air.pressure_pa += 1e-6; }},
      {"bands", [](Preset& p) { p.physical->bands.pop_back(); }},
      {"equilibrium_cos_terms", [](Preset& p) { p.physical->equilibrium.cos_terms[3][2] += 1e-9; }},
      {"keep_volume", [](Preset& p) { p.physical->keep_volume = false; }},
      {"keep_centroid", [](Preset& p) { p.physical->keep_centroid = false; }},
      {"amplitude_factor", [](Preset& p) { p.physical->amplitude.factor[0] = 0.1; }},
      {"exposure_s", [](Preset& p) { p.exposure_s += 1e-12; }},
      {"span_s", [](Preset& p) { p.physical->span_s += 1e-12; }},
      {"slices_per_row", [](Preset& p) { p.physical->slices_per_row += 1e-12; }},
      {"slices_per_period", [](Preset& p) { p.physical->slices_per_period += 1e-12; }},
      {"density_kg_m3", [](Preset& p) { p.density_kg_m3 += 1e-9; }}};
  const Preset preset = tiny();
  for (const auto& [field, change] : changes) {
    Preset other = preset;
    change(other);
    EXPECT_NE(preset_parameters(other), preset_parameters(preset)) << field;
    EXPECT_THAT(preset_parameters(preset), HasSubstr(fmt::format("\"{}\"", field)));
  }
  Preset fewer = preset;
  fewer.physical->diameters_um = {500};
  fewer.view_elevations_deg = {80};
  EXPECT_EQ(preset_parameters(fewer), preset_parameters(preset)) << "a database may grow";
  fewer.lights.pop_back();
  EXPECT_NE(preset_parameters(fewer), preset_parameters(preset)) << "other lights";
  fewer = preset;
  fewer.environment = true;
  EXPECT_NE(preset_parameters(fewer), preset_parameters(preset)) << "environment";
}

TEST(PhysicalPreset, EveryShardHasASeedOfItsOwn) {
  const Preset preset = tiny();
  std::vector<std::uint64_t> seeds;
  for (const int um : {500, 3000}) {
    for (const int oscillation : {0, 3}) {
      for (int view = -80; view <= 80; ++view) {
        seeds.push_back(shard_request(preset, {um, oscillation, view}).seed);
      }
    }
  }
  std::sort(seeds.begin(), seeds.end());
  EXPECT_EQ(std::adjacent_find(seeds.begin(), seeds.end()), seeds.end());
}

TEST(PhysicalPreset, ShippedPresetIsRead) {
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/physical.toml");
  EXPECT_EQ(preset.sets.size(), 10u);
  EXPECT_EQ(diameters_of(preset).front(), 500);
  EXPECT_EQ(diameters_of(preset).back(), 6000);
  EXPECT_EQ(preset.view_elevations_deg.front(), -80);
  EXPECT_GE(preset.physical->span_s, 2 * preset.exposure_s);
}

TEST(PhysicalPreset, DropsBeyondTheTableOfShapesAreRefused) {
  const TemporaryFolder folder;
  const std::string preset = write_physical(folder.path());
  std::string table = read_file(folder / "equilibrium.csv");
  for (int rows = 0; rows < 11; ++rows) table.resize(table.rfind('\n', table.size() - 2) + 1);
  write_file_atomically(folder / "equilibrium.csv", table);
  const double largest_mm =
      1e3 * read_equilibrium_table(folder / "equilibrium.csv").diameter_m.back();
  ASSERT_LT(largest_mm, 3);
  EXPECT_THAT(message_of([&] { read_preset(preset); }),
              testing::HasSubstr("preset.toml:6:1: diameter 3 mm; expected at most "));
}

}  // namespace
}  // namespace pluvia
