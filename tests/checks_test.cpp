// Every check of the report must be able to fail: each is fed a fault through its inputs.

#include "validate/checks.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr const char* data = PLUVIA_SOURCE_DIR "/data";

const Check& check_named(const Report& report, const std::string& name) {
  for (const Check& check : report.checks) {
    if (check.name == name) return check;
  }
  throw std::runtime_error(name + ": not in the report");
}

Preset gn2006() {
  return read_preset(std::string(data) + "/presets/gn2006.toml");
}

TEST(Checks, SphereChecksPassAndAreNamed) {
  Report report;
  add_sphere_checks(report);
  for (const char* name :
       {"sphere.energy.p0", "sphere.energy.p1", "sphere.energy.p2", "sphere.energy.p3",
        "sphere.rainbow.p2_deg", "sphere.rainbow.p3_deg", "sphere.intensity.rms"}) {
    EXPECT_TRUE(passes(check_named(report, name))) << name;
    EXPECT_FALSE(check_named(report, name).why.empty()) << name;
  }
  // They could not pass with a drop of another index: what they expect would differ by more than
  // the bound.
  const double energy = sphere_energy(1.333, 2), other_energy = sphere_energy(1.34, 2);
  EXPECT_GT(std::abs(other_energy / energy - 1), check_named(report, "sphere.energy.p2").bound);
  const double bow = sphere_rainbow_rad(1.333, 2), other_bow = sphere_rainbow_rad(1.3335, 2);
  EXPECT_GT(std::abs(other_bow - bow) * 180 / pi,
            check_named(report, "sphere.rainbow.p2_deg").bound);
}

TEST(Checks, FurnaceFailsWhenLightIsLost) {
  Preset preset = gn2006();
  preset.sets.resize(2);
  preset.width_px = 8;
  preset.field.space_depth = 1;
  preset.field.time_depth = 0;
  Report whole, cut;
  add_energy_check(preset, whole);
  EXPECT_TRUE(passes(check_named(whole, "furnace"))) << check_named(whole, "furnace").value;
  // Order 3 left out: the sphere returns 0.6 % less than the closed form's orders 0 to 3.
  preset.field.paths.max_order = 2;
  add_energy_check(preset, cut);
  EXPECT_FALSE(passes(check_named(cut, "furnace")));
  EXPECT_NEAR(check_named(cut, "furnace").value, sphere_energy(1.333, 3), 5e-4);
}

TEST(Checks, MeshesConvergeToTheAnalyticDropWithTheNumberOfTriangles) {
  Report report;
  add_mesh_check(gn2006(), report);
  const Check& check = check_named(report, "mesh.convergence");
  EXPECT_TRUE(passes(check)) << check.measured << " +- " << check.uncertainty;
  ASSERT_EQ(report.plots.size(), 1u);
  // 512 to 32,768 triangles, errors falling all the way.
  const Curve& curve = report.plots[0].curves.at(0);
  for (std::size_t k = 1; k < curve.y.size(); ++k) EXPECT_LT(curve.y[k], curve.y[k - 1]);
}

// A database of oscillation 0 alone whose pictures are made of the closed form and of the real
// factors: light k has the sphere's flux, and its brightest pixel is proportional to the factor
// where there is one.
struct MadeUp {
  double flux_scale = 1;            // of one light in front
  bool mirror_azimuth = false;      // front and back swapped
  double refractive_index = 1.333;  // of the pictures; the manifest says 1.333
  double factor_scale = 1;          // of the brightest pixels of elevation 50
};

constexpr LightDirection one_light = {30, 30};
constexpr double pixel_m = 1.6e-3 / 11.2;
constexpr double cone_rad = 5 * pi / 180;

double factor_of(const LightDirection& light) {
  // Column osc0 of data/factors at the nine azimuths 10 .. 170.
  constexpr double f10[] = {.004535, .011450, .004249, .002484, .002403,
                            .004843, .105644, .302834, .414521};
  constexpr double f50[] = {.003520, .002254, .002181, .002397, .002598,
                            .003277, .008558, .031062, .051063};
  const int k = (light.azimuth_deg - 10) / 20;
  if (light.elevation_deg == 10) return f10[k];
  if (light.elevation_deg == 50) return f50[k];
  return light.elevation_deg == 90 ? .001969 : .002;
}

// 32 x 64 pixels: one bright pixel, the rest of the flux spread evenly and darker.
StreakImage picture_of(double flux, double brightest) {
  const int pixels = 32 * 64;
  StreakImage image;
  image.mean.assign(pixels, static_cast<float>((flux - brightest) / (pixels - 1)));
  image.mean[100] = static_cast<float>(brightest);
  image.variance.assign(pixels, 1e-12f);
  return image;
}

void write_made_up(const std::string& folder, const MadeUp& made) {
  make_folder(folder + "/shards");
  Shard shard = {.key = {3200, 0, 0}, .width_px = 32, .height_px = 64};
  for (const LightDirection& light : gn2006_light_directions()) {  // the factors' and one more
    if (light.elevation_deg >= 10 && (light.elevation_deg % 40 == 10 || light == one_light)) {
      shard.lights.push_back(light);
    }
  }
  const double disc_px = pi * std::pow(1.6e-3 / pixel_m, 2);
  for (const LightDirection& light : shard.lights) {
    const int azimuth = made.mirror_azimuth ? 180 - light.azimuth_deg : light.azimuth_deg;
    const double angle =
        std::acos(-std::cos(light.elevation_deg * pi / 180) * std::cos(azimuth * pi / 180));
    double flux = disc_px * sphere_intensity_in_cone(made.refractive_index, 3, angle, cone_rad);
    if (light == one_light) flux *= made.flux_scale;
    const LightDirection seen = {light.elevation_deg, azimuth};
    const double brightest =
        5 * factor_of(seen) * (light.elevation_deg == 50 ? made.factor_scale : 1);
    shard.light.push_back(picture_of(flux, brightest));
  }
  shard.env = shard.coverage = picture_of(100, 0.1);
  Manifest manifest = {
      .preset = "gn2006",
      .parameters = R"({"cone_half_angle_deg":5,"max_order":3,"refractive_index":1.333})",
      .seed = 1,
      .instruction_set = "any",
      .mean_radius_m = 1.6e-3,
      .exposure_s = 1.0 / 60,
      .fall_speed_m_s = 8.49,
      .pixel_m = pixel_m};
  ShardRecord record = {.key = shard.key, .file = "shards/" + shard_name(shard.key) + ".exr"};
  record.width_px = 32;
  record.height_px = 64;
  record.path_bottom_row = 64;
  record.sha256 = write_shard(folder + "/" + record.file, shard);
  manifest.shards = {record};
  write_manifest(folder, manifest);
}

Report database_report(const MadeUp& made) {
  const TemporaryFolder folder;
  write_made_up(folder.path(), made);
  Report report;
  add_database_checks(folder.path(),
                      std::string(data) + "/factors/garg_nayar_2006_point_factors.csv", report);
  return report;
}

constexpr const char* closed_form = "gn2006.sphere_closed_form.osc0";
constexpr const char* factors = "gn2006.log_factor_rms.osc0";

TEST(Checks, DatabaseOfTheClosedFormPassesAndNamesWhatItLacks) {
  const Report report = database_report({});
  EXPECT_LT(check_named(report, closed_form).value, 1e-5);
  EXPECT_LT(check_named(report, factors).value, 1e-5);
  ASSERT_EQ(report.skipped.size(), 1u);
  EXPECT_THAT(report.skipped[0], testing::HasSubstr("gn2006.log_factor_rms.all: "));
  EXPECT_THAT(report.skipped[0], testing::HasSubstr("1 of the ten oscillations"));
}

TEST(Checks, OneLightThatIsTenPerCentTooBrightFails) {
  const Report report = database_report({.flux_scale = 1.1});
  const Check& check = check_named(report, closed_form);
  EXPECT_FALSE(passes(check));
  EXPECT_NEAR(check.value, std::log10(1.1), 1e-4);
  EXPECT_THAT(check.why, testing::HasSubstr("Worst at elevation 30, azimuth 30."));
  EXPECT_TRUE(passes(check_named(report, factors)));
}

TEST(Checks, LightFromTheWrongSideFailsBothDatabaseChecks) {
  const Report report = database_report({.mirror_azimuth = true});
  EXPECT_FALSE(passes(check_named(report, closed_form)));
  EXPECT_FALSE(passes(check_named(report, factors)));
}

TEST(Checks, DropOfGlassFailsTheClosedFormOfWater) {
  EXPECT_FALSE(passes(check_named(database_report({.refractive_index = 1.5}), closed_form)));
}

TEST(Checks, FactorsOfOneElevationThatAreHalfAsBrightAgainFail) {
  const Report report = database_report({.factor_scale = 1.5});
  EXPECT_FALSE(passes(check_named(report, factors)));
  EXPECT_NEAR(check_named(report, factors).value, std::log10(1.5), 1e-5);
  EXPECT_TRUE(passes(check_named(report, closed_form)));
}

TEST(Checks, ManifestWithoutTheConeIsRefusedByKey) {
  const TemporaryFolder folder;
  write_made_up(folder.path(), {});
  Manifest manifest = read_manifest(folder.path());
  manifest.parameters = "{}";
  write_manifest(folder.path(), manifest);
  Report report;
  EXPECT_THAT(message_of([&] { add_database_checks(folder.path(), "none", report); }),
              testing::HasSubstr("manifest.json: parameters.cone_half_angle_deg: missing"));
}

TEST(Checks, GalleryShowsTheLightBehindTheDrop) {
  const TemporaryFolder folder;
  write_made_up(folder.path(), {});
  Report report;
  add_gallery(folder.path(), report);
  ASSERT_EQ(report.figures.size(), 2u);
  ASSERT_EQ(report.figures[0].panels.size(), 1u);
  // At half size the bright pixel (column 4, row 3) is one of four that column 2, row 1 averages;
  // the others have the dark value of any other place.
  const Image& picture = report.figures[0].panels[0].image;
  EXPECT_NEAR(picture.at(2, 1) - 0.75 * picture.at(0, 0), 0.25 * 5 * 0.302834, 1e-6);
}

TEST(Checks, AtlasOfAnotherDatabaseIsNotCompared) {
  const TemporaryFolder folder;
  write_database(folder.path());
  StreakAtlas atlas = pack_database(folder.path());
  atlas.database_sha256 = "another";
  Report report;
  add_atlas_checks(folder.path(), atlas, report);
  EXPECT_TRUE(report.checks.empty());
  ASSERT_EQ(report.skipped.size(), 1u);
  EXPECT_THAT(report.skipped[0], testing::HasSubstr("packed from another database"));
}

TEST(Checks, AtlasThatLacksWhatItsDatabaseHasFailsByName) {
  const TemporaryFolder folder;
  write_database(folder.path());
  const StreakAtlas whole = pack_database(folder.path());
  StreakAtlas renamed = whole, cut = whole;
  renamed.lights[1].azimuth_deg = 350;  // no light of the database
  cut.layers.pop_back();
  for (const StreakAtlas& atlas : {renamed, cut}) {
    Report report;
    add_atlas_checks(folder.path(), atlas, report);
    EXPECT_FALSE(passes(check_named(report, "atlas.cells")));
  }
}

TEST(Checks, DatabaseWithoutTheStreaksThatAreJudgedIsSkippedWithTheReason) {
  const TemporaryFolder folder;
  write_made_up(folder.path(), {});
  Report report;
  add_streak_checks(folder.path(), {}, report);
  EXPECT_TRUE(report.checks.empty());
  ASSERT_EQ(report.skipped.size(), 1u);
  EXPECT_THAT(report.skipped[0], testing::HasSubstr("the database has no oscillation 6"));
}

}  // namespace
}  // namespace pluvia
