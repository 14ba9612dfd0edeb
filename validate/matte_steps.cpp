#include "validate/matte_steps.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

#include "validate/fall_direction.h"

namespace pluvia {
namespace {

constexpr int newton_steps = 3;  // what they leave is taken up by the next iteration
// Of the clip's brightest light. A matte and its colour trade against each other where the
// background is even, and mu asks for small mattes.
constexpr double brightest_rain = 10;

SparseMatrix with_diagonal(const SparseMatrix& m, double factor, const PixelValues& diagonal) {
  return factor * m + SparseMatrix(diagonal.asDiagonal());
}

// E as a form of one a_k: weights |C - S|^2, right side (C - S) . (I - S).
void improve_matte(const MatteClip& clip, const SparseMatrix& fall, const MatteSettings& settings,
                   std::size_t k, MatteUnknowns& unknowns) {
  PixelValues weights = PixelValues::Zero(unknowns.mattes[k].size()), right = weights;
  for (std::size_t c = 0; c < unknowns.background.size(); ++c) {
    const auto behind = unknowns.background[c].array();
    weights.array() += (unknowns.rain[k][c] - behind).square();
    right.array() += (unknowns.rain[k][c] - behind) * (clip.light[k][c].array() - behind);
  }
  descend(with_diagonal(fall, settings.mu, weights), right, {0, 1}, newton_steps,
          unknowns.mattes[k]);
}

}  // namespace

MatteEnergy matte_energy(const MatteClip& clip, const MatteSystems& systems,
                         const MatteUnknowns& unknowns, const MatteSettings& settings) {
  std::vector<MatteEnergy> frames(clip.light.size());
  tbb::parallel_for(std::size_t{0}, clip.light.size(), [&](std::size_t k) {
    const PixelValues& a = unknowns.mattes[k];
    for (std::size_t c = 0; c < clip.light[k].size(); ++c) {
      const PixelValues& behind = unknowns.background[c];
      const auto shown = behind.array() + a.array() * (unknowns.rain[k][c] - behind.array());
      frames[k].data += (clip.light[k][c].array() - shown).square().sum();
    }
    frames[k].mattes = settings.mu * quadratic(systems.fall, a);
  });
  MatteEnergy energy;
  for (const MatteEnergy& frame : frames) energy.data += frame.data, energy.mattes += frame.mattes;
  for (const PixelValues& behind : unknowns.background)
    energy.background += settings.lambda * quadratic(systems.gradient, behind);
  return energy;
}

void improve_mattes(const MatteClip& clip, const MatteSystems& systems,
                    const MatteSettings& settings, MatteUnknowns& unknowns) {
  tbb::parallel_for(std::size_t{0}, unknowns.mattes.size(), [&](std::size_t k) {
    improve_matte(clip, systems.fall, settings, k, unknowns);
  });
}

void improve_direction(const MatteClip& clip, const MatteSettings& settings, MatteSystems& systems,
                       MatteUnknowns& unknowns) {
  std::vector<Image> mattes;
  for (const PixelValues& matte : unknowns.mattes)
    mattes.push_back(picture_of({matte}, clip.width, clip.height, 1));
  const std::optional<double> lean = fall_lean_deg(mattes);
  if (!lean || *lean == unknowns.lean_deg) return;
  SparseMatrix fall = fall_energy(clip.width, clip.height, *lean);
  double before = 0, after = 0;
  for (const PixelValues& matte : unknowns.mattes) {
    before += quadratic(systems.fall, matte);
    after += quadratic(fall, matte);
  }
  if (settings.mu * after > settings.mu * before) return;
  systems.fall = std::move(fall);
  unknowns.lean_deg = *lean;
}

// E as a form of S: weights sum (1 - a)^2, right side sum (1 - a) (I - a C).
void improve_background(const MatteClip& clip, const MatteSystems& systems,
                        const MatteSettings& settings, MatteUnknowns& unknowns) {
  PixelValues weights = PixelValues::Zero(unknowns.background.front().size());
  for (const PixelValues& a : unknowns.mattes) weights.array() += (1 - a.array()).square();
  const SparseMatrix system = with_diagonal(systems.gradient, settings.lambda, weights);
  tbb::parallel_for(std::size_t{0}, unknowns.background.size(), [&](std::size_t c) {
    PixelValues right = PixelValues::Zero(weights.size());
    for (std::size_t k = 0; k < clip.light.size(); ++k) {
      const auto a = unknowns.mattes[k].array();
      right.array() += (1 - a) * (clip.light[k][c].array() - a * unknowns.rain[k][c]);
    }
    descend(system, right, {0, clip.brightest}, newton_steps, unknowns.background[c]);
  });
}

// E as a form of C_k, alone in its channel: the least squares of I - (1 - a) S over a.
void improve_colours(const MatteClip& clip, MatteUnknowns& unknowns) {
  for (std::size_t k = 0; k < clip.light.size(); ++k) {
    const auto a = unknowns.mattes[k].array();
    const double weight = a.square().sum();
    if (!(weight > 0)) continue;
    for (std::size_t c = 0; c < unknowns.background.size(); ++c) {
      const auto behind = unknowns.background[c].array();
      const double colour = (a * (clip.light[k][c].array() - (1 - a) * behind)).sum() / weight;
      unknowns.rain[k][c] = std::clamp(colour, 0.0, brightest_rain * clip.brightest);
    }
  }
}

Image picture_of(const std::vector<PixelValues>& channels, int width, int height, double white) {
  Image image = make_image(width, height, static_cast<int>(channels.size()));
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const double value =
        channels[i % channels.size()][static_cast<Eigen::Index>(i / channels.size())];
    image.values[i] = static_cast<float>(value * white);
  }
  return image;
}

}  // namespace pluvia
