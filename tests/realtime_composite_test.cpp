// Many streaks over each other, against drops put down one by one from back to front.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

struct Errors {
  double mean_tau = 0;
  double composite = 0;  // relative RMSE of frame minus background
  double plain = 0;      // of exp(-tau) B + sum S, each streak as if no other were before it
};

Errors errors_of(Scene scene, const StreakAtlas& atlas) {
  RainRenderer renderer(scene, atlas);
  const Frame frame = renderer.render(0.5);
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0.5);
  const FrameComposite truth = composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
                                               frame.background, frame.depth_m);
  Errors errors;
  double square = 0, plain = 0, all = 0;
  const std::size_t pixels = frame.rain_tau.values.size();
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto tau = static_cast<double>(frame.rain_tau.values[i]);
    errors.mean_tau += tau / static_cast<double>(pixels);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto background = static_cast<double>(frame.background.values[3 * i + c]);
      const auto rain = static_cast<double>(truth.rain.values[3 * i + c]);
      const double ours = static_cast<double>(frame.color.values[3 * i + c]) - background;
      // Every streak's light, undone: S of the frame is scaled by (1 - T) / sum c, about 1 / tau.
      const double hidden = -std::expm1(-tau);
      const double undimmed =
          hidden > 0 ? static_cast<double>(frame.rain.values[3 * i + c]) * tau / hidden : 0;
      square += std::pow(ours - rain, 2);
      plain += std::pow(undimmed - hidden * background - rain, 2);
      all += rain * rain;
    }
  }
  errors.composite = std::sqrt(square / all);
  errors.plain = std::sqrt(plain / all);
  return errors;
}

TEST(RainComposite, HoldsWhereStreaksHideEachOther) {
  PLUVIA_NEEDS_OPENGL();
  // The synthetic streaks are given the coverage of real ones, which over all pixels is the drop's
  // cross-section; drops far larger than any make a few ten thousand hide much of the picture.
  StreakAtlas atlas =
      synthetic_atlas({.cell_width_px = 16, .levels = 4, .path_rows = 247, .margin_rows = 4});
  const CellRect cell = cell_rect(atlas, 0, 0, 0);
  double covered = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x)
      covered += static_cast<double>(atlas.layers[0].coverage[0].at(cell.x + x, cell.y + y));
  }
  const double wanted = std::numbers::pi * std::pow(atlas.mean_radius_m / atlas.pixel_m, 2);
  for (AtlasLayer& layer : atlas.layers) {
    for (auto* pictures : {&layer.coverage, &layer.point, &layer.env}) {
      for (Image& picture : *pictures) {
        for (float& value : picture.values) value *= static_cast<float>(wanted / covered);
      }
    }
  }
  struct Density {
    double drops, r0_m, bound;
  };
  // The bounds hold the error of thin streaks (0.007; realtime_splat_test), and the mean field's:
  // which streak hides which is known in the mean alone, an error that grows with the depth.
  for (const Density& density :
       {Density{3000, 1.6e-3, 0.01}, {20000, 6.4e-3, 0.04}, {40000, 1e-2, 0.06}}) {
    Scene scene = rainy_scene(density.drops);
    scene.rain.sizes[0].r0_m = density.r0_m;
    const Errors errors = errors_of(scene, atlas);
    EXPECT_LT(errors.composite, density.bound) << "mean tau " << errors.mean_tau;
    EXPECT_LT(2.5 * errors.composite, errors.plain + 0.015) << "mean tau " << errors.mean_tau;
  }
}

}  // namespace
}  // namespace pluvia
