#include "realtime/frame_layers.h"

#include <cmath>
#include <utility>

namespace pluvia {

FrameLayers frame_layers(Frame frame) {
  FrameLayers layers = {.background = std::move(frame.background),
                        .rain = std::move(frame.rain),
                        .coverage = std::move(frame.rain_tau),
                        .color = std::move(frame.color)};
  for (float& tau : layers.coverage.values)
    tau = static_cast<float>(-std::expm1(-static_cast<double>(tau)));
  const auto channels = static_cast<std::size_t>(layers.color.channels);
  for (std::size_t i = 0; i < layers.color.values.size(); ++i) {
    const double left = 1 - static_cast<double>(layers.coverage.values[i / channels]);
    layers.color.values[i] =
        static_cast<float>(left * static_cast<double>(layers.background.values[i]) +
                           static_cast<double>(layers.rain.values[i]));
  }
  return layers;
}

Image rain_mask(const Image& coverage, double least_coverage) {
  Image mask = coverage;
  for (float& value : mask.values)
    value = static_cast<double>(value) >= least_coverage ? 1.0f : 0.0f;
  return mask;
}

}  // namespace pluvia
