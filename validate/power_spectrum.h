// How much of a picture varies how finely and in which direction: its power spectrum, averaged over
// rings of frequency and over sectors of direction.
//
//   P(k) = |sum_x h(x) (L(x) - mean) exp(-2 pi i k x)|^2 / sum_x h(x)^2
//
// h: Hann's window, so that the picture's borders are no edges; the mean is that under h, so that
// P(0) = 0. White noise of variance v has P = v.
#pragma once

#include <array>

#include "validate/picture_planes.h"

namespace pluvia {

constexpr int spectrum_rings = 32;    // of equal width up to 0.5 cycles per pixel
constexpr int spectrum_sectors = 36;  // of 5 degrees

struct PowerSpectrum {
  // Ring r: frequencies r .. r + 1 in units of 1/64 cycle per pixel, without frequency 0. A picture
  // of less than 64 pixels a side may have rings without any frequency: 0.
  std::array<double, spectrum_rings> rings = {};
  // Sector s: waves whose crests, as lines in the picture, lean from the vertical by -90 + 5 s ..
  // -85 + 5 s degrees, positive with their lower ends to the right; up to 0.5 cycles per pixel.
  std::array<double, spectrum_sectors> sectors = {};
  // Of noise by which values of the picture's size are rounded to floats: up to 2^-24 of the
  // largest to either side, a variance of a third of that squared.
  double rounding = 0;
};

// P at the frequencies of rows and columns in the order of the Fourier transform: 0 first, then up
// to 0.5 cycles per pixel, then the negative ones. Throws as power_spectrum does.
Plane power_plane(const Plane& luminance);

// Throws std::runtime_error for less than 16 x 16 pixels.
PowerSpectrum power_spectrum(const Plane& luminance);

// Log-spectral distance of two averaged spectra, sqrt(mean (10 log10 (a / b))^2) [dB] (Gray and
// Markel, "Distance Measures for Speech Processing", IEEE Trans. ASSP 24(5), 1976). Power below the
// rounding of either picture counts as that on both sides.
struct SpectralDistance {
  double rings_db = 0, sectors_db = 0;
};
SpectralDistance spectral_distance(const PowerSpectrum& a, const PowerSpectrum& b);

}  // namespace pluvia
