#include "validate/picture_comparison.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "atlas/rec709.h"
#include "validate/picture_planes.h"

namespace pluvia {
namespace {

void compare_rain(const ComparedPictures& pictures, PictureComparison& result) {
  const Image rain = rain_layer(pictures.picture, pictures.dry);
  const Image truth = rain_layer(pictures.reference, pictures.dry);
  const Image exact = make_image(truth.width, truth.height, truth.channels);
  result.rain = noisy_error(rain, truth, pictures.variance ? *pictures.variance : exact);
  result.rain_map = luminance_error(rain, truth);
  result.rain_error = summary_of(result.rain_map);
  if (!pictures.streaks.empty()) {
    result.flux = flux_error(streak_fluxes(rain, truth, pictures.streaks, pictures.variance));
  }
  const double least = pictures.white * srgb_linear(1.0 / 255);
  result.statistics =
      statistics_distance(streak_statistics(rain, least), streak_statistics(truth, least));
}

}  // namespace

Image rain_layer(const Image& with, const Image& without) {
  require_pair("rain_layer", with, without);
  Image rain = with;
  for (std::size_t i = 0; i < rain.values.size(); ++i) rain.values[i] -= without.values[i];
  return rain;
}

PictureComparison compare_pictures(const ComparedPictures& pictures) {
  const Image &picture = pictures.picture, &reference = pictures.reference;
  require_pair("compare_pictures", picture, reference);
  PictureComparison result;
  compare_rain(pictures, result);
  const Image shown = srgb_of(picture, pictures.white), goal = srgb_of(reference, pictures.white);
  result.ldr = peak_error(shown, goal, 1);
  result.ssim = ssim(shown, goal, 1);
  result.hdr_peak = *std::max_element(reference.values.begin(), reference.values.end());
  result.hdr = peak_error(picture, reference, result.hdr_peak);
  result.ldr_flip =
      ldr_flip(cut_to_screen(reference, pictures.white), cut_to_screen(picture, pictures.white));
  result.ldr_flip_map = summary_of(result.ldr_flip.map);
  try {
    result.hdr_flip = hdr_flip(reference, picture);
    result.hdr_flip_map = summary_of(result.hdr_flip->error.map);
  } catch (const std::runtime_error& error) {
    result.no_hdr_flip = error.what();
  }
  return result;
}

Image rounded_to_bytes(const Image& image, double white) {
  Image rounded = srgb_of(image, white);
  for (float& value : rounded.values) {
    value = static_cast<float>(white * srgb_linear(std::round(255.0 * value) / 255));
  }
  return rounded;
}

}  // namespace pluvia
