#include "atlas/export_gn2006.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/gray_png.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Sample layout_sample() {
  return {.width_px = 32,
          .oscillations = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
          .views = {0, 20, 40, 60, 80},
          .heights = {45, 36, 27, 18, 9},  // 6 .. 2 where the picture is 4 px wide
          .lights = gn2006_light_directions()};
}

// A database of 50 shards and its export, made once; tests look at a few pictures of it.
class Export : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = std::make_unique<TemporaryFolder>();
    manifest = write_database(*shared / "db", layout_sample(), [](Shard& s) {
      if (s.key.oscillation == 3) std::fill(s.env.mean.begin(), s.env.mean.end(), 0.0f);
    });
  }
  // Made when the first test of a process asks for it.
  static const std::string& layout() {
    static const std::string made = [] {
      summary = export_gn2006(*shared / "db", *shared / "layout");
      return *shared / "layout";
    }();
    return made;
  }
  static void TearDownTestSuite() { shared.reset(); }

  static GrayPicture read(const std::string& name) { return read_gray_png(layout() + "/" + name); }
  static Shard shard(int oscillation, int view) {
    return read_shard(*shared / ("db/shards/" + shard_name({3200, oscillation, view}) + ".exr"));
  }
  static double env_factor(int oscillation, int view) {
    const std::string file = layout() + "/" + gn2006_env_factor_file();
    for (const ViewFactors& factors : parse_gn2006_env_factors(file, read_file(file))) {
      if (factors.view_elevation_deg != view) continue;
      return factors.env[static_cast<std::size_t>(oscillation)];
    }
    ADD_FAILURE() << "no view " << view;
    return 0;
  }
  // The message of an export of the database with another manifest; nothing may come of it.
  std::string refusal(Manifest other, const ExportOptions& options = {}) const {
    make_folder(folder / "db");
    fs::remove(folder / "db/shards");
    fs::create_directory_symlink(*shared / "db/shards", folder / "db/shards");
    write_manifest(folder / "db", other);
    const std::string message =
        message_of([&] { export_gn2006(folder / "db", folder / "out", options); });
    EXPECT_FALSE(fs::exists(folder / "out"));
    EXPECT_FALSE(fs::exists(folder / "out.pluvia-tmp"));
    return message;
  }
  // .. of the database with one shard altered.
  template <typename Change>
  std::string refusal_of_shard(Change change) const {
    Manifest other = manifest;
    ShardRecord& record = other.shards[7];
    Shard altered = read_shard(*shared / ("db/" + record.file));
    change(altered);
    const std::string name = shard_name(record.key) + ".exr";
    record.file = "altered/" + name;
    make_folder(folder / "db/altered");
    record.sha256 = write_shard(folder / "db/altered/" + name, altered);
    return refusal(other);
  }

  static std::unique_ptr<TemporaryFolder> shared;
  static Manifest manifest;
  static ExportSummary summary;
  const TemporaryFolder folder;
};

std::unique_ptr<TemporaryFolder> Export::shared;
Manifest Export::manifest;
ExportSummary Export::summary;

TEST_F(Export, LayoutHoldsExactlyTheFilesThatReadersOpen) {
  const std::string root = layout();
  EXPECT_EQ(summary.pictures, 15000);
  EXPECT_EQ(summary.shards_left_out, 0);
  std::set<std::string> expected = {gn2006_env_factor_file()};
  for (const int view : gn2006_views_deg) {
    expected.insert(gn2006_point_factor_file(view));
    for (const int size : gn2006_sizes_px) {
      for (int oscillation = 0; oscillation < gn2006_oscillations; ++oscillation) {
        expected.insert(gn2006_env_picture(size, view, oscillation));
        for (const LightDirection& light : gn2006_light_directions()) {
          expected.insert(gn2006_point_picture(size, view, light, oscillation));
        }
      }
    }
  }
  EXPECT_EQ(expected.size(), 15006u);
  std::set<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.is_regular_file()) {
      found.insert(entry.path().lexically_relative(root).generic_string());
    }
  }
  EXPECT_EQ(found, expected);
}

TEST_F(Export, ValueTimesFactorIsTheTransitsBrightnessToHalfAStep) {
  for (const int view : {0, 60}) {
    const Shard source = shard(2, view);
    const auto& covered = source.coverage.mean;
    const double transit = *std::max_element(covered.begin(), covered.end());
    const GrayPicture picture = read(gn2006_env_picture(32, view, 2));
    EXPECT_EQ(*std::max_element(picture.values.begin(), picture.values.end()), 65535);
    const double factor = env_factor(2, view);
    ASSERT_EQ(picture.values.size(), source.env.mean.size());
    for (std::size_t i = 0; i < picture.values.size(); ++i) {
      EXPECT_NEAR(picture.values[i] * factor / 65535, source.env.mean[i] / transit,
                  0.5001 / 65535 * factor)
          << "view " << view << ", value " << i;
    }
  }
}

TEST_F(Export, PointPicturesGoWithTheirOwnFactors) {
  const Shard source = shard(9, 40);
  const std::string file = layout() + "/" + gn2006_point_factor_file(40);
  const auto factors = parse_gn2006_point_factors(file, read_file(file));
  const auto& covered = source.coverage.mean;
  const double transit = *std::max_element(covered.begin(), covered.end());
  for (const std::size_t k : {std::size_t{0}, std::size_t{40}, std::size_t{73}}) {
    const GrayPicture picture = read(gn2006_point_picture(32, 40, source.lights[k], 9));
    for (std::size_t i = 0; i < picture.values.size(); ++i) {
      EXPECT_NEAR(picture.values[i] * factors[k][9] / 65535, source.light[k].mean[i] / transit,
                  0.5001 / 65535 * factors[k][9]);
    }
  }
}

TEST_F(Export, SmallerPicturesAreAveragesOfTheLargestAndBlackBeyondIt) {
  const GrayPicture large = read(gn2006_env_picture(32, 0, 1));
  for (const int size : {16, 8, 4}) {
    const GrayPicture small = read(gn2006_env_picture(size, 0, 1));
    const int n = 32 / size;
    EXPECT_EQ(small.width, size);
    EXPECT_EQ(small.height, (45 + n - 1) / n);
    for (int y = 0; y < small.height; ++y) {
      for (int x = 0; x < size; ++x) {
        double sum = 0;
        for (int row = n * y; row < std::min(45, n * y + n); ++row) {
          for (int column = n * x; column < n * x + n; ++column) {
            sum += large.values[static_cast<std::size_t>(row * 32 + column)];
          }
        }
        EXPECT_NEAR(small.values[static_cast<std::size_t>(y * size + x)], sum / (n * n), 0.5)
            << size << " px wide, pixel " << x << ", " << y;
      }
    }
  }
}

TEST_F(Export, OptionsChangeTheLevelAndTheScaleOfSmallPictures) {
  export_gn2006(*shared / "db", folder / "out",
                {.level = StreakLevel::exposure, .normalise = Normalise::each});
  const Shard source = shard(4, 80);
  const float brightest = *std::max_element(source.env.mean.begin(), source.env.mean.end());
  const std::string file = folder / ("out/" + gn2006_env_factor_file());
  EXPECT_EQ(parse_gn2006_env_factors(file, read_file(file))[4].env[4],
            gn2006_told_factor(static_cast<double>(brightest)));
  for (const int size : gn2006_sizes_px) {
    const std::string name = gn2006_env_picture(size, 80, 4);
    const GrayPicture each = read_gray_png(folder / ("out/" + name)), same = read(name);
    EXPECT_EQ(*std::max_element(each.values.begin(), each.values.end()), 65535) << size;
    const double whitest = *std::max_element(same.values.begin(), same.values.end());
    for (std::size_t i = 0; i < each.values.size(); ++i) {
      // Half a step of the shared picture and of its maximum, stretched, and half a step of its
      // own.
      EXPECT_NEAR(each.values[i], same.values[i] * 65535.0 / whitest, 65535 / whitest + 0.5)
          << size;
    }
  }
}

TEST_F(Export, WiderDatabaseIsAveragedDownAndOthersAreLeftOut) {
  Sample sample = layout_sample();
  sample.width_px = 64;
  sample.views.insert(sample.views.begin(), -20);
  sample.heights = {1, 72, 56, 40, 24, 7};
  sample.oscillations.push_back(10);
  sample.lights.resize(gn2006_light_directions().size());
  write_database(folder / "db", sample, [](Shard& s) { s.light = {s.light.size(), s.env}; });
  EXPECT_EQ(export_gn2006(folder / "db", folder / "out").shards_left_out, 16);
  const GrayPicture picture = read_gray_png(folder / "out/" + gn2006_env_picture(32, 80, 0));
  EXPECT_EQ(picture.width, 32);
  EXPECT_EQ(picture.height, 4);  // 7 rows of 64 px
  const Shard source = read_shard(folder / "db/shards/d3200_osc00_v+80.exr");
  const auto average = [&](int x, int y) {
    const auto at = [&](int i, int j) {
      return j < 7 ? source.env.mean[static_cast<std::size_t>(j * 64 + i)] : 0;
    };
    return at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) +
           at(2 * x + 1, 2 * y + 1);
  };
  const auto brightest = std::max_element(picture.values.begin(), picture.values.end());
  const int at = static_cast<int>(brightest - picture.values.begin());
  const float most = average(at % 32, at / 32);
  for (int i = 0; i < 32 * 4; ++i) {
    EXPECT_NEAR(picture.values[static_cast<std::size_t>(i)], 65535 * average(i % 32, i / 32) / most,
                0.9)  // half a step, and 65535 * 5e-6 of the told factor
        << i;
  }
}

TEST_F(Export, BlackPictureHasAFactorOfZero) {
  EXPECT_EQ(env_factor(3, 20), 0);
  for (const int size : {32, 4}) {
    const auto black = read(gn2006_env_picture(size, 20, 3)).values;
    EXPECT_EQ(std::accumulate(black.begin(), black.end(), 0), 0) << size;
  }
}

TEST_F(Export, DatabasesThatDoNotFillTheLayoutAreRefused) {
  Manifest other = manifest;
  std::erase_if(other.shards, [](const ShardRecord& r) {
    return r.key.oscillation == 3 && r.key.view_elevation_deg >= 60;
  });
  EXPECT_EQ(refusal(other),
            (folder / "db") +
                "/manifest.json: 2 of the layout's 50 shards missing: d3200_osc03_v+60, "
                "d3200_osc03_v+80; expected oscillations 0 .. 9 at views 0, 20, 40, 60, 80. run "
                "`pluvia generate` for them");
  other.shards.clear();
  EXPECT_THAT(refusal(other), HasSubstr("drops of no um; expected one diameter (--diameter-mm)"));
  EXPECT_THAT(refusal(manifest, {.diameter_um = 1000}),
              HasSubstr("no drops of 1000 um; expected one of 3200"));
  other = manifest;
  other.shards.push_back(other.shards.back());
  other.shards.back().key.diameter_um = 4000;
  EXPECT_THAT(refusal(other), HasSubstr("drops of 3200, 4000 um; expected one diameter"));
  EXPECT_THAT(refusal(other, {.diameter_um = 4000}), HasSubstr("49 of the layout's 50 shards"));
}

TEST_F(Export, PicturesThatTheLayoutCannotHoldAreRefused) {
  for (const int width : {16, 33, 48}) {
    Manifest other = manifest;
    for (ShardRecord& record : other.shards) record.width_px = width;
    EXPECT_THAT(refusal(other),
                HasSubstr(fmt::format("shard d3200_osc00_v+00: {} x 45 pixels; expected a width of "
                                      "32 or a power of two above it",
                                      width)));
  }
  Manifest other = manifest;
  other.shards[8].height_px = 19;
  EXPECT_THAT(refusal(other), HasSubstr("shard d3200_osc01_v+60: 32 x 19 pixels"));
  other = manifest;
  for (ShardRecord& record : other.shards) {
    if (record.key.view_elevation_deg == 0) record.height_px = 37;  // 5 rows of 4 px, like 36
  }
  EXPECT_THAT(refusal(other), HasSubstr("would be 2, 3, 4, 5 px high; expected five heights"));
}

TEST_F(Export, ShardsThatAreNotWholeAreRefused) {
  EXPECT_THAT(refusal_of_shard([](Shard& s) { s.env = {}; }), HasSubstr("part env is missing"));
  EXPECT_THAT(refusal_of_shard([](Shard& s) {
                s.lights.pop_back();
                s.light.pop_back();
              }),
              HasSubstr("73 light directions; expected the layout's 74"));
  EXPECT_THAT(refusal_of_shard([](Shard& s) {
                std::fill(s.coverage.mean.begin(), s.coverage.mean.end(), 0.0f);
              }),
              HasSubstr("part coverage: 0 everywhere; expected a drop"));
  Manifest other = manifest;
  other.shards[7].sha256 = sha256("another");
  EXPECT_THAT(refusal(other), HasSubstr("d3200_osc01_v+40.exr: SHA-256 is not the manifest's"));
}

TEST_F(Export, FolderThatIsThereIsRefused) {
  make_folder(folder / "out");
  EXPECT_THAT(message_of([&] { export_gn2006(*shared / "db", folder / "out"); }),
              HasSubstr("out: is there already"));
}

}  // namespace
}  // namespace pluvia
