#include "validate/rain_mattes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include "validate/matte_steps.h"
#include "validate/median.h"

namespace pluvia {
namespace {

constexpr double least_fall = 5e-3;  // of E, in a whole iteration

void refuse(const std::string& found_and_expected) {
  throw std::runtime_error("rain_mattes: " + found_and_expected);
}

void check_settings(const MatteSettings& settings) {
  const auto refuse_value = [](const char* name, double value, const char* expected) {
    refuse(fmt::format("{} = {}; expected {}", name, value, expected));
  };
  const auto finite_from_0 = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!finite_from_0(settings.lambda)) refuse_value("lambda", settings.lambda, "a number >= 0");
  if (!finite_from_0(settings.mu)) refuse_value("mu", settings.mu, "a number >= 0");
  if (settings.iterations < 1) refuse_value("iterations", settings.iterations, "at least 1");
  if (!finite_from_0(settings.white) || settings.white == 0)
    refuse_value("white", settings.white, "a number > 0");
}

void check_frames(const std::vector<Image>& frames) {
  if (frames.size() < 3)
    refuse(fmt::format("{} frames; expected at least 3, for a median", frames.size()));
  const Image& first = frames.front();
  if (first.width < 16 || first.height < 16 || (first.channels != 1 && first.channels != 3))
    refuse(fmt::format("{} x {} pixels of {} channels; expected at least 16 x 16 of 1 or 3",
                       first.width, first.height, first.channels));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Image& frame = frames[k];
    if (frame.width != first.width || frame.height != first.height ||
        frame.channels != first.channels || frame.values.size() != first.values.size())
      refuse(fmt::format("frame {} has {} x {} pixels of {} channels; expected those of the first",
                         k, frame.width, frame.height, frame.channels));
    for (const float value : frame.values) {
      if (!std::isfinite(value) || value < 0)
        refuse(fmt::format("frame {} has a value {}; expected finite values >= 0", k, value));
    }
  }
}

PixelValues channel_of(const Image& image, int channel, double white) {
  PixelValues values(image.width * image.height);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto at = static_cast<std::size_t>(i * image.channels + channel);
    values[i] = static_cast<double>(image.values[at]) / white;
  }
  return values;
}

std::vector<PixelValues> channels_of(const Image& image, double white) {
  std::vector<PixelValues> channels;
  for (int c = 0; c < image.channels; ++c) channels.push_back(channel_of(image, c, white));
  return channels;
}

MatteClip clip_of(const std::vector<Image>& frames, double white) {
  MatteClip clip = {.width = frames.front().width, .height = frames.front().height};
  for (const Image& frame : frames) {
    clip.light.push_back(channels_of(frame, white));
    for (const PixelValues& light : clip.light.back())
      clip.brightest = std::max(clip.brightest, light.maxCoeff());
  }
  return clip;
}

MatteUnknowns starting_point(const MatteClip& clip, const Image& median, double white) {
  const auto none = PixelValues::Zero(clip.width * clip.height);
  MatteUnknowns unknowns = {.mattes = std::vector<PixelValues>(clip.light.size(), none),
                            .background = channels_of(median, white)};
  for (const std::vector<PixelValues>& frame : clip.light) {
    unknowns.rain.push_back({});
    for (std::size_t c = 0; c < frame.size(); ++c)
      unknowns.rain.back()[c] = exceeded_by_a_thousandth(frame[c]);
  }
  return unknowns;
}

MatteIteration iterate(const MatteClip& clip, const MatteSettings& settings, MatteSystems& systems,
                       MatteUnknowns& unknowns) {
  MatteIteration energies;
  improve_mattes(clip, systems, settings, unknowns);
  energies.mattes = matte_energy(clip, systems, unknowns, settings);
  improve_direction(clip, settings, systems, unknowns);
  energies.direction = matte_energy(clip, systems, unknowns, settings);
  improve_background(clip, systems, settings, unknowns);
  energies.background = matte_energy(clip, systems, unknowns, settings);
  improve_colours(clip, unknowns);
  energies.colours = matte_energy(clip, systems, unknowns, settings);
  return energies;
}

RainMattes result_of(const MatteClip& clip, const MatteUnknowns& unknowns, double white) {
  RainMattes result = {
      .background = picture_of(unknowns.background, clip.width, clip.height, white),
      .colours = unknowns.rain,
      .lean_deg = unknowns.lean_deg};
  for (const PixelValues& matte : unknowns.mattes)
    result.mattes.push_back(picture_of({matte}, clip.width, clip.height, 1));
  for (std::array<double, 3>& colour : result.colours) {
    for (double& value : colour) value *= white;
  }
  return result;
}

}  // namespace

Image temporal_median(const std::vector<Image>& frames) {
  const std::size_t n = frames.size(), middle = n / 2;
  Image median = frames.front();
  std::vector<float> values(n);
  for (std::size_t i = 0; i < median.values.size(); ++i) {
    for (std::size_t k = 0; k < n; ++k) values[k] = frames[k].values[i];
    std::sort(values.begin(), values.end());
    const double low = values[n % 2 == 1 ? middle : middle - 1];
    median.values[i] = static_cast<float>((low + values[middle]) / 2);
  }
  return median;
}

RainMattes rain_mattes(const std::vector<Image>& frames, const MatteSettings& settings,
                       const std::function<void(const std::string&, double)>& progress) {
  check_settings(settings);
  check_frames(frames);
  const MatteClip clip = clip_of(frames, settings.white);
  MatteUnknowns unknowns = starting_point(clip, temporal_median(frames), settings.white);
  MatteSystems systems = {gradient_energy(clip.width, clip.height),
                          fall_energy(clip.width, clip.height, unknowns.lean_deg)};
  const MatteEnergy start = matte_energy(clip, systems, unknowns, settings);
  std::vector<MatteIteration> iterations;
  bool falls = true;
  for (int i = 0; i < settings.iterations && falls; ++i) {
    const double before = (i == 0 ? start : iterations.back().colours).total();
    iterations.push_back(iterate(clip, settings, systems, unknowns));
    falls = before - iterations.back().colours.total() > least_fall * before;
    progress("mattes", falls ? (i + 1.0) / settings.iterations : 1);
  }
  RainMattes result = result_of(clip, unknowns, settings.white);
  result.start = start;
  result.iterations = std::move(iterations);
  return result;
}

}  // namespace pluvia
