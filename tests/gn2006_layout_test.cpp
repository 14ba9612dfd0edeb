#include "atlas/gn2006_layout.h"

#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::StartsWith;

ViewFactors random_factors(int view) {
  std::mt19937 random(static_cast<unsigned>(view));
  std::uniform_real_distribution<double> exponent(-9, 2);
  ViewFactors factors = {.view_elevation_deg = view, .point = {}};
  factors.point.resize(gn2006_light_directions().size());
  for (double& f : factors.env) f = std::pow(10, exponent(random));
  for (auto& row : factors.point) {
    for (double& f : row) f = std::pow(10, exponent(random));
  }
  return factors;
}

TEST(Gn2006Layout, NamesAreThoseThatReadersBuild) {
  EXPECT_EQ(gn2006_env_picture(8, 0, 9), "env_light_database/size8/cv0_osc9.png");
  EXPECT_EQ(gn2006_point_picture(32, 0, {-90, 170}, 0),
            "point_light_database/size32/dcam00/cv0_v-90_h170_osc0.png");
  EXPECT_EQ(gn2006_point_picture(4, 60, {10, 30}, 7),
            "point_light_database/size4/dcam60/cv60_v10_h30_osc7.png");
  EXPECT_EQ(gn2006_env_factor_file(), "env_light_database/txt/normalized_env_max.txt");
  EXPECT_EQ(gn2006_point_factor_file(0), "point_light_database/txt/dcam00_point_max.txt");
}

TEST(Gn2006Layout, TextsAreTheKnownOnesToTheBlank) {
  ViewFactors view = {.view_elevation_deg = 20,
                      .env = {0.998342, 0.5, 1, 0, 1.25e-9, 12.3456789, 123456.7, 1e7, 0.1, 0.3}};
  view.point.assign(gn2006_light_directions().size(), view.env);
  const std::string row =
      "0.998342 0.500000 1.00000 0.000000 0.00000000125000 12.3457 123457 10000000 0.100000 "
      "0.300000 \n";
  EXPECT_EQ(gn2006_env_factor_text({view, view}), "cv20\n" + row + "cv20\n" + row);
  std::string point = "cv20\nv-90\nh170 " + row;
  for (int v = -70; v <= 70; v += 20) {
    point += fmt::format("v{}\n", v);
    for (int h = 10; h <= 170; h += 20) point += fmt::format("h{} ", h) + row;
  }
  EXPECT_EQ(gn2006_point_factor_text(view), point + "v90\nh170 " + row);
}

TEST(Gn2006Layout, ToldFactorIsNearAndStaysAsItIs) {
  // Six digits of a number that begins with 1: off by half a unit of 1.00000, 5e-6 at most. A
  // picture divided by it still ends at 65535: 65535 (1 + 5e-6) rounds to 65535.
  std::mt19937 random(6);
  std::uniform_real_distribution<double> exponent(-30, 30);
  for (int i = 0; i < 1000; ++i) {
    const double factor = std::pow(10, exponent(random));
    const double told = gn2006_told_factor(factor);
    EXPECT_NEAR(told / factor, 1, 5.0001e-6) << factor;
    EXPECT_EQ(gn2006_told_factor(told), told);
    // Neither does a float on the way move it: FLT_DIG is 6.
    EXPECT_EQ(gn2006_told_factor(static_cast<double>(static_cast<float>(told))), told) << factor;
  }
  EXPECT_EQ(gn2006_told_factor(0), 0);
}

TEST(Gn2006Layout, TextsAreReadBack) {
  std::vector<ViewFactors> views;
  for (const int view : gn2006_views_deg) views.push_back(random_factors(view));
  const auto again = parse_gn2006_env_factors("env.txt", gn2006_env_factor_text(views));
  ASSERT_EQ(again.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(again[i].view_elevation_deg, views[i].view_elevation_deg);
    const auto point = parse_gn2006_point_factors("p.txt", gn2006_point_factor_text(views[i]));
    for (std::size_t o = 0; o < again[i].env.size(); ++o) {
      EXPECT_EQ(again[i].env[o], gn2006_told_factor(views[i].env[o]));
      for (std::size_t k = 0; k < point.size(); ++k) {
        ASSERT_EQ(point[k][o], gn2006_told_factor(views[i].point[k][o]));
      }
    }
  }
}

TEST(Gn2006Layout, BlanksAndLineEndsOfOtherWritersAreNoErrors) {
  const std::string plain = gn2006_env_factor_text({random_factors(0), random_factors(80)});
  std::string other;
  for (const char c : plain) other += c == '\n' ? "\r\n\r\n" : c == ' ' ? "\t " : std::string(1, c);
  const auto a = parse_gn2006_env_factors("a", plain), b = parse_gn2006_env_factors("b", other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].env, b[i].env);
}

// `text` with the piece replaced.
std::string with(std::string text, const std::string& piece, const std::string& other) {
  const std::size_t at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return text.replace(at, piece.size(), other);
}

TEST(Gn2006Layout, BadEnvironmentFactorsAreRefusedWithFileLineAndColumn) {
  ViewFactors view = {.env = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}};
  std::vector<ViewFactors> views = {view, view};
  views[1].view_elevation_deg = 40;
  const std::string good = gn2006_env_factor_text(views);
  const auto message = [](const std::string& text) {
    return message_of([&] { parse_gn2006_env_factors("env.txt", text); });
  };
  EXPECT_EQ(message(""), "env.txt:1:1: an empty file; expected cv0 and its factors");
  EXPECT_EQ(message(with(good, "cv40", "cv41")),
            "env.txt:3:1: \"cv41\"; expected cv0, cv20, cv40, cv60 or cv80");
  EXPECT_EQ(message(with(good, "cv40", "cv0")),
            "env.txt:3:1: \"cv0\" after cv0; expected ascending views, each once");
  EXPECT_EQ(message(with(good, "cv40\n", "cv40 ")),
            "env.txt:3:6: \"1.00000\"; expected the end of the line");
  EXPECT_EQ(message(with(good, "1.00000 ", "")),
            "env.txt:2:72: end of the line after 9 factors; expected 10");
  EXPECT_EQ(message(with(good, "1.00000 ", "1 1 ")),
            "env.txt:2:69: \"1.00000\"; expected the end of the line after 10 factors");
  for (const std::string bad : {"-1", "nan", "inf", "1,5", "0x1", "1e999", "one"}) {
    EXPECT_EQ(message(with(good, " 1.00000", "  " + bad)),
              fmt::format("env.txt:2:10: \"{}\"; expected a factor >= 0", bad));
  }
  EXPECT_EQ(message(good + "cv60\n"), "env.txt:5:5: end of the file; expected the factors of cv60");
}

TEST(Gn2006Layout, BadPointFactorsAreRefusedWithFileLineAndColumn) {
  ViewFactors view;
  view.point.resize(gn2006_light_directions().size());
  const std::string good = gn2006_point_factor_text(view);
  const auto message = [](const std::string& text) {
    return message_of([&] { parse_gn2006_point_factors("p.txt", text); });
  };
  EXPECT_THAT(message("\n \n"), StartsWith("p.txt:1:1: an empty file"));
  EXPECT_THAT(message(with(good, "cv0\n", "")), StartsWith("p.txt:1:1: \"v-90\"; expected cv0"));
  EXPECT_EQ(message(with(good, "v-90\n", "")), "p.txt:2:1: \"h170\"; expected vN before it");
  EXPECT_EQ(message(with(good, "h170", "h10")),
            "p.txt:3:1: \"h10\" of v-90; expected one of the layout's 74 lights");
  EXPECT_EQ(message(with(good, "h30", "h10")), "p.txt:6:1: \"h10\" again; expected it once");
  EXPECT_EQ(message(with(good, "h30", "k30")), "p.txt:6:1: \"k30\"; expected vN or hN");
  EXPECT_EQ(message(with(good, "0.000000", "a")), "p.txt:3:6: \"a\"; expected a factor >= 0");
  EXPECT_EQ(message(good.substr(0, good.find("v90"))),
            "p.txt:83:95: end of the file without h170 of v90; expected all 74 lights");
}

}  // namespace
}  // namespace pluvia
