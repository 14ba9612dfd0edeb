#include "validate/sweep.h"

#include <cmath>
#include <functional>
#include <limits>
#include <regex>
#include <stdexcept>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/streak_atlas.h"
#include "raytrace/preset.h"
#include "tests/run_program.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"
#include "validate/sweep_json.h"
#include "validate/sweep_page.h"
#include "validate/sweep_streaks.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SweepPoint point(const std::string& setting, double time_s, double error) {
  return {.series = "a series",
          .setting = setting,
          .flags = "--setting " + setting,
          .time_s = time_s,
          .low_s = 0.9 * time_s,
          .high_s = 1.2 * time_s,
          .error = error,
          .standard_error = 0.1 * error,
          .noise = 0.2 * error};
}

SweepCurve curve(const std::vector<SweepPoint>& points) {
  SweepCurve result = {.name = "generator",
                       .title = "a title",
                       .time_label = "time [s]",
                       .error_label = "error",
                       .text = "a text",
                       .whole = "the whole",
                       .points = points,
                       .standard = points.front().setting};
  mark_front(result);
  recommend(result);
  return result;
}

std::vector<std::string> front_of(const std::vector<SweepPoint>& points) {
  std::vector<std::string> names;
  for (const SweepPoint& p : curve(points).points) {
    if (p.on_front) names.push_back(p.setting);
  }
  return names;
}

std::string complaint(const std::function<void()>& what) {
  try {
    what();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(SweepFront, HoldsWhatNoOtherIsCheaperAndMoreAccurateThan) {
  EXPECT_THAT(front_of({point("dear", 4, 0.01), point("cheap", 1, 0.3), point("both worse", 5, 0.1),
                        point("middle", 2, 0.1), point("wrong", 3, 0.2)}),
              ElementsAre("dear", "cheap", "middle"));
}

TEST(SweepFront, ASinglePointIsOnIt) {
  EXPECT_THAT(front_of({point("only", 1, 1)}), ElementsAre("only"));
}

TEST(SweepFront, OfEqualTimesOrErrorsTheBetterInTheOtherIsOnIt) {
  EXPECT_THAT(front_of({point("a", 1, 0.2), point("b", 1, 0.1)}), ElementsAre("b"));
  EXPECT_THAT(front_of({point("a", 1, 0.1), point("b", 2, 0.1)}), ElementsAre("a"));
}

TEST(SweepFront, PointsEqualInBothAreOnItTogetherOrNotAtAll) {
  EXPECT_THAT(
      front_of({point("a", 1, 0.1), point("b", 1, 0.1), point("c", 2, 0.2), point("d", 2, 0.2)}),
      ElementsAre("a", "b"));
}

TEST(SweepFront, AnErrorOfZeroIsOnIt) {
  EXPECT_THAT(front_of({point("exact", 9, 0), point("a", 1, 0.1)}), ElementsAre("exact", "a"));
}

TEST(SweepFront, RefusesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint([&] { curve({point("a", 0, 0.1)}); }), HasSubstr("time 0 s; expected"));
  EXPECT_THAT(complaint([&] { curve({point("a", nan, 0.1)}); }), HasSubstr("time nan s; expected"));
  EXPECT_THAT(complaint([&] { curve({point("a", 1, nan)}); }), HasSubstr("error nan; expected"));
  EXPECT_THAT(complaint([&] { curve({point("a", 1, -0.1)}); }), HasSubstr("error -0.1; expected"));
  SweepPoint other = point("b", 1, 0.1);
  other.also = {{"FLIP", nan}};
  EXPECT_THAT(complaint([&] {
                curve({point("a", 1, 1), other});
              }),
              HasSubstr("other distances than of the first setting; expected the same names"));
  EXPECT_THAT(complaint([&] { curve({other}); }), HasSubstr("FLIP nan; expected a finite"));
  SweepPoint bars = point("a", 1, 0.1);
  bars.high_s = 0.95;
  EXPECT_THAT(complaint([&] { curve({bars}); }), HasSubstr("times from 0.9 to 0.95 s, median 1 s"));
  EXPECT_THAT(complaint([&] {
                curve({point("a", 1, 1), point("a", 2, 1)});
              }),
              HasSubstr("setting \"a\" twice; expected once"));
}

// Times 1, 2, 4 with errors 0.3, 0.1, 0.08: time x error^2 is 0.09, 0.02, 0.026.
SweepCurve three() {
  return curve({point("rough", 1, 0.3), point("middle", 2, 0.1), point("fine", 4, 0.08)});
}

TEST(SweepRecommendation, HasTheLeastTimeTimesSquaredError) {
  EXPECT_EQ(three().recommended, "middle");
  EXPECT_THAT(three().why, HasSubstr("pluvia does \"rough\": 0.5 times the time, error 0.3 "
                                     "instead of 0.1, on the front"));
}

TEST(SweepRecommendation, IsNothingThatPluviaCannotBeAskedFor) {
  SweepPoint middle = point("middle", 2, 0.1);
  middle.flags.clear();
  const SweepCurve c = curve({point("rough", 1, 0.3), middle, point("fine", 4, 0.08)});
  EXPECT_EQ(c.recommended, "fine");
  EXPECT_EQ(pick_by_error(c, 0.1).setting, "fine");
  middle.flags.clear();
  EXPECT_EQ(curve({middle}).recommended, "");
}

TEST(SweepPick, TakesTheMostAccurateWithinATime) {
  EXPECT_EQ(pick_by_time(three(), 100).setting, "fine");
  EXPECT_EQ(pick_by_time(three(), 4).setting, "fine");  // the budget itself is within it
  EXPECT_EQ(pick_by_time(three(), 3.99).setting, "middle");
  EXPECT_EQ(pick_by_time(three(), 1).setting, "rough");
}

TEST(SweepPick, HoldsTheWholeAgainstTheTime) {
  SweepCurve c = three();
  c.whole_factor = 25;
  EXPECT_EQ(pick_by_time(c, 100).setting, "fine");
  EXPECT_EQ(pick_by_time(c, 99).setting, "middle");
}

TEST(SweepPick, TakesTheCheapestWithinAnError) {
  EXPECT_EQ(pick_by_error(three(), 1).setting, "rough");
  EXPECT_EQ(pick_by_error(three(), 0.3).setting, "rough");
  EXPECT_EQ(pick_by_error(three(), 0.29).setting, "middle");
  EXPECT_EQ(pick_by_error(three(), 0.08).setting, "fine");
}

TEST(SweepPick, TellsTheNearestWhereThereIsNone) {
  EXPECT_THAT(complaint([] { pick_by_time(three(), 0.5); }),
              HasSubstr("curve \"generator\": no setting takes at most 500 ms for the whole; the "
                        "nearest is \"rough\": 1 s for the whole, error 0.3"));
  EXPECT_THAT(complaint([] { pick_by_error(three(), 0.01); }),
              HasSubstr("no setting has an error of at most 0.01; the nearest is \"fine\": 4 s"));
  SweepPoint other = point("other", 1, 0.1);
  other.flags.clear();
  EXPECT_THAT(complaint([&] { pick_by_time(curve({other}), 9); }),
              HasSubstr("no setting on its front that pluvia can be asked for"));
}

TEST(SweepStreaks, TellTheNinetiethPercentileOfTheLights) {
  std::vector<JudgedPicture> pictures;
  for (int k = 1; k <= 10; ++k) {
    pictures.push_back(
        {.square = 0.01 * k * k, .standard_error = 0.018 * k, .noise_square = 0.04 * k});
  }
  SweepPoint p;
  set_error(pictures, p);
  EXPECT_NEAR(p.error, 0.9, 1e-12);            // the ninth of ten: sqrt 0.81
  EXPECT_NEAR(p.standard_error, 0.09, 1e-12);  // 0.162 / (2 x 0.9)
  EXPECT_NEAR(p.noise, 0.6, 1e-12);            // sqrt 0.36
}

TEST(SweepStreaks, AnErrorThatCannotBeToldFromNoneIsABound) {
  SweepPoint p;
  set_error({{.square = -0.02, .standard_error = 0.04}}, p);
  EXPECT_NEAR(p.error, 0.2, 1e-12);
  EXPECT_EQ(p.standard_error, p.error);
  set_error({{.square = 0.05, .standard_error = 0.11}}, p);
  EXPECT_NEAR(p.error, 0.4, 1e-12);
  set_error({{}}, p);  // the same picture, no noise
  EXPECT_EQ(p.error, 0);
}

TEST(SweepStreaks, APartOfAnExposureFallsAtTheSpeedOfTheWhole) {
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/gn2006.toml");
  const StreakRequest whole = shard_request(preset, {.diameter_um = 3200, .oscillation = 1});
  const StreakRequest part = part_of(whole, 0.25);
  EXPECT_DOUBLE_EQ(part.frame.path_rows / part.exposure_s,
                   whole.frame.path_rows / whole.exposure_s);
  // What lies above and below the path stays, rounded to whole rows.
  EXPECT_NEAR(part.frame.height_px - part.frame.path_rows,
              whole.frame.height_px - whole.frame.path_rows, 1);
  EXPECT_EQ(part.slices, 256);
}

TEST(SweepTimes, AreMediansBetweenTheLeastAndTheGreatest) {
  SweepPoint p;
  set_times({5, 1, 3}, p);
  EXPECT_EQ(p.time_s, 3);
  EXPECT_EQ(p.low_s, 1);
  EXPECT_EQ(p.high_s, 5);
}

TEST(SweepTimes, ComeFromRoundsOfAllSettingsNotFromOneAfterTheOther) {
  std::string order;
  const auto times = time_interleaved({[&](int round) { order += fmt::format("a{} ", round); },
                                       [&](int round) { order += fmt::format("b{} ", round); }},
                                      2);
  EXPECT_EQ(order, "a0 b0 a1 b1 ");
  EXPECT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].size(), 2u);
}

TEST(SweepTexts, TellDurationsInTheUnitThatFits) {
  EXPECT_EQ(duration_text(0.0123), "12.3 ms");
  EXPECT_EQ(duration_text(90), "90 s");
  EXPECT_EQ(duration_text(250), "4.17 min");
  EXPECT_EQ(duration_text(9000), "2.5 h");
}

TEST(SweepPlot, MarksFrontAndRecommendationAndKeepsTheBars) {
  const Plot plot = sweep_plot(three());
  ASSERT_EQ(plot.curves.size(), 3u);
  EXPECT_EQ(plot.curves[0].label, "front");
  EXPECT_EQ(plot.curves[0].x.size(), 3u);
  EXPECT_EQ(plot.curves[1].x_low, (std::vector<double>{0.9, 1.8, 3.6}));
  EXPECT_EQ(plot.curves[1].y_error.front(), 0.1 * 0.3);
  EXPECT_EQ(plot.curves[2].x, std::vector<double>{2});
}

class SweepFile : public testing::Test {
 protected:
  Sweep sweep() const {
    return {.curves = {three()},
            .machine = {{"processor", "p"}},
            .seeds = {{"of it", "7"}},
            .commands = {"pluvia sweep"},
            .skipped = {"curve atlas: \"why\""}};
  }
  std::string refusal(const std::string& text) const {
    const std::string file = folder / "sweep.json";
    write_file_atomically(file, text);
    return complaint([&] { read_sweep(file); });
  }
  // The file's text with one replaced by another, once.
  std::string changed(const std::string& from, const std::string& to) const {
    std::string text = sweep_json(sweep());
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  }

  TemporaryFolder folder;
};

TEST_F(SweepFile, ComesBackAsItWasWritten) {
  Sweep before = sweep();
  before.curves[0].points[0].error = 0.1 + 0.2;  // 17 digits
  mark_front(before.curves[0]);
  write_file_atomically(folder / "sweep.json", sweep_json(before));
  const Sweep after = read_sweep(folder / "sweep.json");
  EXPECT_EQ(sweep_json(after), sweep_json(before));
  EXPECT_EQ(after.curves[0].points[0].error, 0.1 + 0.2);
  EXPECT_EQ(after.machine, before.machine);
  EXPECT_EQ(after.skipped, before.skipped);
}

TEST_F(SweepFile, IsRefusedWithThePlaceWhereItIsWrong) {
  EXPECT_THAT(refusal("{\n \"version\": 1,\n oops}"), HasSubstr("sweep.json:3:2: not JSON"));
  EXPECT_THAT(refusal("{\"version\": 2}"), HasSubstr("sweep.json: version 2; this program reads"));
  EXPECT_THAT(refusal(changed("\"error\": 0.1,", "")),
              HasSubstr("curves[0].points[1].error: missing; expected this key"));
  EXPECT_THAT(refusal(changed("\"time_s\": 2.0", "\"time_s\": \"2\"")),
              HasSubstr("curves[0].points[1].time_s: \"2\"; expected a number"));
  EXPECT_THAT(refusal(changed("\"error\": 0.1,", "\"error\": -1,")),
              HasSubstr("curves[0]: curve \"generator\": setting \"middle\": error -1; expected"));
  EXPECT_THAT(refusal(changed("\"on_front\": true", "\"on_front\": false")),
              HasSubstr("curves[0].points[0].on_front: false; expected true"));
  EXPECT_THAT(refusal(changed("\"recommended\": \"middle\"", "\"recommended\": \"none\"")),
              HasSubstr("curves[0].recommended: \"none\"; expected a setting on the front"));
  EXPECT_THAT(refusal(changed("\"whole_factor\": 1.0", "\"whole_factor\": 0")),
              HasSubstr("curves[0].whole_factor: 0; expected a number > 0"));
  EXPECT_THAT(refusal(changed("\"processor\": \"p\"", "\"processor\": 3")),
              HasSubstr("machine.processor: 3; expected a string"));
  Sweep twice = sweep();
  twice.curves.push_back(twice.curves[0]);
  EXPECT_THAT(refusal(sweep_json(twice)),
              HasSubstr("curves[1].name: \"generator\" as in curves[0]; expected each name once"));
}

class SweepProgram : public SweepFile {
 protected:
  Outcome from_file(const std::string& flags) const {
    write_file_atomically(folder / "sweep.json", sweep_json(sweep()));
    return run_pluvia("sweep --from " + (folder / "sweep.json") + " " + flags);
  }
};

TEST_F(SweepProgram, PicksFromAFileByTimeOrError) {
  const Outcome by_time = from_file("--budget 0.05min");
  EXPECT_EQ(by_time.code, 0) << by_time.err;
  EXPECT_THAT(by_time.out, HasSubstr("generator: middle; 2 s for the whole, error 0.1 +- 0.01; "
                                     "--setting middle"));
  EXPECT_THAT(from_file("--error 0.09").out, HasSubstr("generator: fine; 4 s"));
  EXPECT_THAT(from_file("").out, HasSubstr("recommended: middle"));
}

TEST_F(SweepProgram, SaysWhereNothingFits) {
  const Outcome none = from_file("--budget 10ms");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("pluvia sweep: curve \"generator\": no setting takes at most"));
  const Outcome unmeasured = from_file("--curve renderer");
  EXPECT_EQ(unmeasured.code, 1);
  EXPECT_THAT(unmeasured.err, HasSubstr("no curve \"renderer\"; expected one that was measured"));
}

TEST_F(SweepProgram, TakesTimesInTheUnitsOfPeople) {
  for (const char* budget : {"3s", "3", "3000ms", "0.05min", "3e0s", "0.001h"}) {
    EXPECT_THAT(from_file(fmt::format("--budget {}", budget)).out, HasSubstr("middle;")) << budget;
  }
  for (const char* budget : {"5parsecs", "min", "0s", "-1s", "nan", "inf", "1e10s", "2s3"}) {
    const Outcome refused = from_file(fmt::format("--budget={}", budget));
    EXPECT_EQ(refused.code, 2) << budget;
    EXPECT_THAT(refused.err, HasSubstr("expected a time such as 90s, 5min or 1h")) << budget;
  }
}

TEST_F(SweepProgram, RefusesFlagsThatDoNotGoTogether) {
  EXPECT_EQ(run_pluvia("sweep").code, 2);
  EXPECT_EQ(from_file("--out " + (folder / "out")).code, 2);
  EXPECT_EQ(from_file("--quick").code, 2);
  const Outcome no_atlas = run_pluvia("sweep --curve renderer --out " + (folder / "out"));
  EXPECT_EQ(no_atlas.code, 2);
  EXPECT_THAT(no_atlas.err, HasSubstr("--atlas: is required for the curve renderer"));
}

TEST_F(SweepProgram, ValidateRefusesBadCurvesBeforeItMeasures) {
  write_file_atomically(folder / "bad.json", "{\"version\": 1}");
  const Outcome refused =
      run_pluvia(fmt::format("validate --database none --atlas none --out {} --sweep {}",
                             folder / "report", folder / "bad.json"));
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("bad.json: machine: missing; expected this key"));
}

TEST(SweepPage, SaysFirstWhatEachCurveRecommends) {
  SweepPoint other = point("other", 1, 0.1);
  other.flags.clear();
  EXPECT_EQ(
      sweep_lead({.curves = {three(), curve({other})}}),
      "Error against time. generator: recommended is middle, error 0.1 +- 0.01. generator: no "
      "setting on the front can be asked for. Nothing here is held against a bound.");
}

class SweepMeasured : public SweepProgram {
 protected:
  // The curve as `pluvia sweep --quick` measures it, once for each time; what the program says.
  Sweep measured(const std::string& name, const std::string& flags = "") {
    const Outcome done = run_pluvia(fmt::format("sweep --quick --repeats 1 --curve {} --out {} {}",
                                                name, folder / "out", flags));
    EXPECT_EQ(done.code, 0) << done.err;
    const auto holds = [&](const std::string& file, const char* text) {
      return read_file(folder / ("out/" + file)).find(text) != std::string::npos;
    };
    EXPECT_TRUE(holds(name + ".svg", "<svg"));
    EXPECT_TRUE(holds("index.html", "<td>front"));
    EXPECT_TRUE(holds("index.html", "<p class=\"verdict\">Error against time. "));
    return read_sweep(folder / "out/sweep.json");
  }
  double error_of(const Sweep& measured_sweep, const std::string& setting) const {
    const SweepPoint* found = find_setting(measured_sweep.curves.at(0), setting);
    EXPECT_NE(found, nullptr) << setting;
    return found == nullptr ? -1 : found->error;
  }
};

TEST_F(SweepMeasured, FinerSettingsOfTheGeneratorErrLessThanCoarseOnesAndThanCountedRays) {
  const Sweep generator = measured("generator");
  EXPECT_LT(error_of(generator, "level 1"), error_of(generator, "level 0"));
  EXPECT_LT(error_of(generator, "preset"), error_of(generator, "level 1"));
  // Of 128,000 rays fewer than ten meet the cone of a dim light: more noise than light.
  EXPECT_GT(error_of(generator, "brute force, 128000 rays"), 0.5);
  EXPECT_EQ(generator.curves[0].whole.substr(0, 23), "a database of 50 shards");
}

TEST_F(SweepMeasured, ModelsOfTheDropErrLessTheMoreTheyHaveAndTheSameInEveryRun) {
  const Sweep first = measured("drop"), second = measured("drop");
  EXPECT_LT(error_of(first, "shape at rest, two modes"), error_of(first, "shape at rest"));
  EXPECT_LT(error_of(first, "shape at rest, four modes"),
            error_of(first, "shape at rest, two modes"));
  for (const SweepPoint& p : first.curves.at(0).points) {
    EXPECT_EQ(error_of(second, p.setting), p.error) << p.setting;
  }
}

TEST_F(SweepMeasured, MeshesErrLessTheFinerTheyAreAndPolishHelps) {
  const Sweep mesh = measured("mesh");
  EXPECT_LT(error_of(mesh, "mesh, 2048 triangles"), error_of(mesh, "mesh, 512 triangles"));
  EXPECT_LT(error_of(mesh, "mesh, polished, 512 triangles"), error_of(mesh, "mesh, 512 triangles"));
  EXPECT_EQ(error_of(mesh, "analytic"), 0);
}

TEST_F(SweepMeasured, PicturesOfAnAtlasErrLessTheCloserTheirLightsAndTheMoreTheyMix) {
  const Sweep atlas = measured("atlas");
  const std::string coarse = "lights every 20, views every 20, ";
  const std::string fine = "lights every 10, views every 20, ";
  const auto error = [&](const std::string& start) {
    for (const SweepPoint& p : atlas.curves.at(0).points) {
      if (p.setting.starts_with(start)) return p.error;
    }
    ADD_FAILURE() << start;
    return -1.0;
  };
  EXPECT_LT(error(coarse + "trilinear"), error(coarse + "nearest"));
  EXPECT_LT(error(fine + "trilinear"), error(coarse + "trilinear"));
  EXPECT_LT(error(fine + "nearest"), error(coarse + "nearest"));
  EXPECT_LT(error("lights every 10, level 1"), error("lights every 10, level 3"));
  // Half floats move a picture by 2^-11 of itself at most.
  EXPECT_NEAR(error("lights every 10, half floats"), error(fine + "trilinear"), 5e-4);
}

TEST_F(SweepMeasured, ModelsAreRefusedAnAtlasThatCannotBeJudged) {
  StreakAtlas atlas = synthetic_atlas({.cell_width_px = 16, .levels = 5, .layers = 2});
  atlas.diameter_um = 3200;
  write_atlas(folder / "atlas", atlas);
  for (const char* curve : {"models-night", "models-near-day"}) {
    const Outcome refused = run_pluvia(fmt::format("sweep --quick --curve {} --atlas {} --out {}",
                                                   curve, folder / "atlas", folder / "out"));
    EXPECT_EQ(refused.code, 1) << curve;
    EXPECT_THAT(refused.err, HasSubstr("not what models are judged with; expected ten sets"));
  }
}

// Drops 2 to 12 m away, a lamp above them.
constexpr const char* rain_scene = R"([camera]
position_m = [0, 0, 1.6]
target_m = [0, 10, 1.6]
vertical_fov_deg = 40
width_px = 320
height_px = 240
exposure_s = 0.016666666666666666
white_cd_m2 = 1

[rain]
drops_per_m3 = 2
mean_radius_m = 0.0016
fall_speed_m_s = 8.49
box_min_m = [-4, 2, 0]
box_max_m = [4, 12, 5]
culling_radius_m = 16
local_height_m = 6

[[light]]
name = "lamp"
position_m = [1, 7, 6]
intensity_cd = [300, 300, 300]
)";

TEST_F(SweepMeasured, LookupsOfAFrameErrLessTheMoreCellsTheyMix) {
  StreakAtlas atlas = synthetic_atlas({.cell_width_px = 16, .levels = 5});
  atlas.diameter_um = 3200;
  write_atlas(folder / "atlas", atlas);
  write_file_atomically(folder / "rain.toml", rain_scene);
  const Sweep renderer =
      measured("renderer", "--atlas " + (folder / "atlas") + " --scene " + (folder / "rain.toml"));
  EXPECT_LT(error_of(renderer, "trilinear"), error_of(renderer, "view-linear"));
  EXPECT_LT(error_of(renderer, "view-linear"), error_of(renderer, "nearest"));
}

}  // namespace
}  // namespace pluvia
