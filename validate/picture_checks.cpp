#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "validate/checks.h"
#include "validate/picture_planes.h"

namespace pluvia {

namespace {

constexpr const char* exact = " Both pictures are deterministic: no uncertainty. The bound is ";
constexpr const char* of_rounding =
    "what rounding the reference to bytes makes, as a screen of 8 bits does: nobody sees less.";
constexpr const char* of_brightness =
    "what rain 2 % too bright makes, as frame.composite allows it.";
constexpr const char* of_sampling =
    "what another sample of the same rain would differ by, from halves of the reference.";
constexpr double too_bright = 1.02;

// The reference with its rain too bright, and never below zero where that is dark.
Image with_bright_rain(const ComparedPictures& pictures) {
  const Image rain = rain_layer(pictures.reference, pictures.dry);
  Image result = pictures.reference;
  for (std::size_t i = 0; i < rain.values.size(); ++i) {
    result.values[i] += static_cast<float>((too_bright - 1) * rain.values[i]);
    result.values[i] = std::fmax(result.values[i], 0.0f);
  }
  return result;
}

std::string decibels(const PeakError& error) {
  return error.psnr_db ? fmt::format("PSNR {:.1f} dB", *error.psnr_db) : "equal pictures";
}

// The three distances of what a screen shows.
void add_screen_checks(const std::string& prefix, const ComparedPictures& pictures,
                       const PictureComparison& found, Report& report) {
  const double white = pictures.white;
  const Image rounded = rounded_to_bytes(pictures.reference, white);
  const Image goal = srgb_of(pictures.reference, white), bytes = srgb_of(rounded, white);
  const Ssim similar = ssim(bytes, goal, 1);
  report.checks.push_back(deviation(
      prefix + ".psnr.ldr", found.ldr.rms_over_peak, 0, peak_error(bytes, goal, 1).rms_over_peak,
      "of the peak",
      fmt::format("Root mean square of the differences of sRGB values, cut at {} cd/m^2, peak 1: "
                  "{}.",
                  white, decibels(found.ldr)) +
          exact + of_rounding));
  report.checks.push_back(
      deviation(prefix + ".ssim", found.ssim.mean, 1, 1 - similar.mean, "1 - SSIM",
                std::string("Luminance of the same sRGB values.") + exact + of_rounding));
  if (found.ssim.ms_ssim && similar.ms_ssim) {
    report.checks.push_back(
        deviation(prefix + ".ms_ssim", *found.ssim.ms_ssim, 1, 1 - *similar.ms_ssim, "1 - MS-SSIM",
                  std::string("The same over five scales.") + exact + of_rounding));
  } else {
    report.skipped.push_back(prefix + ".ms_ssim: less than 176 x 176 pixels have no fifth scale");
  }
  const Image shown = cut_to_screen(pictures.reference, white);
  report.checks.push_back(deviation(prefix + ".flip.ldr", found.ldr_flip.mean, 0,
                                    ldr_flip(shown, cut_to_screen(rounded, white)).mean,
                                    "mean LDR-FLIP",
                                    fmt::format("Cut at {} cd/m^2.", white) + exact + of_rounding));
}

void add_radiance_checks(const std::string& prefix, const ComparedPictures& pictures,
                         const PictureComparison& found, Report& report) {
  const Image bright = with_bright_rain(pictures);
  report.checks.push_back(deviation(
      prefix + ".psnr.hdr", found.hdr.rms_over_peak, 0,
      peak_error(bright, pictures.reference, found.hdr_peak).rms_over_peak, "of the peak",
      fmt::format("Root mean square of the differences over the reference's largest value, {:.4g} "
                  "cd/m^2: {}.",
                  found.hdr_peak, decibels(found.hdr)) +
          exact + of_brightness));
  if (!found.hdr_flip) {
    report.skipped.push_back(prefix + ".flip.hdr: " + found.no_hdr_flip);
    return;
  }
  const HdrFlipError& flip = *found.hdr_flip;
  report.checks.push_back(
      deviation(prefix + ".flip.hdr", flip.error.mean, 0,
                hdr_flip(pictures.reference, bright).error.mean, "mean HDR-FLIP",
                fmt::format("The largest over {} exposures, {:.1f} to {:.1f} stops.",
                            flip.exposures, flip.start_exposure_stops, flip.stop_exposure_stops) +
                    exact + of_brightness));
}

// A distance between distributions: no value where only one picture has streaks, which fails.
void add_distance(const std::string& name, const std::optional<double>& value, double bound,
                  const std::string& unit, const std::string& why, Report& report) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  report.checks.push_back(deviation(name, value.value_or(none), 0, bound, unit, why));
}

void add_crowd_checks(const std::string& prefix, const PictureComparison& found, Report& report) {
  const StatisticsDistance& crowd = found.statistics;
  const std::string what =
      "Earth mover's distance over the ridge points of streaks that a screen "
      "of 8 bits shows: ";
  add_distance(prefix + ".streaks.brightness", crowd.brightness.value, too_bright - 1,
               "of the mean", what + "brightness." + exact + of_brightness, report);
  const auto sampled = [&](const std::string& name, const SampledDistance& distance,
                           const std::string& unit, const std::string& of) {
    if (!distance.sampling) {
      report.skipped.push_back(name + ": too few streaks to tell by how much samples differ");
      return;
    }
    add_distance(name, distance.value, *distance.sampling, unit, what + of + exact + of_sampling,
                 report);
  };
  sampled(prefix + ".streaks.width", crowd.width_px, "px", "full width at half brightness.");
  sampled(prefix + ".streaks.lean", crowd.lean_deg, "deg",
          "lean from the vertical, by energy of gradients, around the circle of 180 degrees.");
  const double bright_db = 20 * std::log10(too_bright);
  report.checks.push_back(deviation(
      prefix + ".spectrum.rings", crowd.spectrum.rings_db, 0, bright_db, "dB",
      std::string("Log-spectral distance of the rain layers' power over rings of frequency.") +
          exact + of_brightness));
  report.checks.push_back(
      deviation(prefix + ".spectrum.sectors", crowd.spectrum.sectors_db, 0, bright_db, "dB",
                std::string("The same over sectors of direction.") + exact + of_brightness));
}

void add_flux_check(const std::string& prefix, const ComparedPictures& pictures,
                    const PictureComparison& found, Report& report) {
  if (!found.flux) {
    report.skipped.push_back(prefix + ".streak_flux: no streak is seen");
    return;
  }
  report.checks.push_back(deviation(
      prefix + ".streak_flux", found.flux->all.relative_rmse, 0, too_bright - 1, "relative RMSE",
      fmt::format("Luminance times area over the pixels of each of {} streaks.",
                  pictures.streaks.size()) +
          exact + of_brightness));
}

Table table_of(const std::string& prefix, const PictureComparison& found) {
  Table table = {fmt::format("How far the {} is from the exact composite, pixel by pixel", prefix),
                 {"distance", "mean", "median", "90 %", "99 %", "largest"},
                 {}};
  const auto row = [&](const char* name, const MapSummary& map) {
    std::vector<std::string> cells = {name};
    for (const double v :
         {map.mean, map.median, map.percentile_90, map.percentile_99, map.largest}) {
      cells.push_back(fmt::format("{:.3g}", v));
    }
    table.rows.push_back(std::move(cells));
  };
  row("luminance, cd/m^2", found.rain_error);
  row("1 - SSIM", found.ssim.error);
  row("LDR-FLIP", found.ldr_flip_map);
  if (found.hdr_flip) row("HDR-FLIP", found.hdr_flip_map);
  if (found.flux) row("light of a streak, over its root mean square", found.flux->of_typical);
  return table;
}

Comparison comparison_of(const std::string& prefix, const ComparedPictures& pictures,
                         const PictureComparison& found) {
  Comparison comparison = {
      .title = fmt::format("The {} against the exact composite", prefix),
      .text =
          "Both as a screen shows them, and maps of each error: white is four times what 99 of "
          "100 pixels do not exceed.",
      .unit = "cd/m^2",
      .picture = {.image = pictures.picture, .white = pictures.white, .caption = "real-time"},
      .reference = {.image = pictures.reference,
                    .white = pictures.white,
                    .caption = "exact composite"},
      .gain = 64};
  const auto add = [&](const Image& map, const MapSummary& summary, const char* name) {
    const double white = 4 * summary.percentile_99;
    comparison.maps.push_back({map, white > 0 ? white : 1, name, false, 1});
  };
  add(found.rain_map, found.rain_error, "difference of luminance");
  add(found.ssim.map, found.ssim.error, "1 - SSIM");
  add(found.ldr_flip.map, found.ldr_flip_map, "LDR-FLIP");
  if (found.hdr_flip) add(found.hdr_flip->error.map, found.hdr_flip_map, "HDR-FLIP");
  return comparison;
}

}  // namespace

void add_picture_checks(const std::string& prefix, const ComparedPictures& pictures,
                        Report& report) {
  const PictureComparison found = compare_pictures(pictures);
  add_screen_checks(prefix, pictures, found, report);
  add_radiance_checks(prefix, pictures, found, report);
  add_flux_check(prefix, pictures, found, report);
  add_crowd_checks(prefix, found, report);
  report.tables.push_back(table_of(prefix, found));
  report.comparisons.push_back(comparison_of(prefix, pictures, found));
}

}  // namespace pluvia
