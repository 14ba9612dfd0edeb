// Structural similarity of two pictures:
//
//   SSIM = l c s,  l = (2 m_a m_b + C1) / (m_a^2 + m_b^2 + C1),
//                 cs = (2 s_ab + C2) / (s_a^2 + s_b^2 + C2),
//
// m, s^2, s_ab: means, variances and covariance under a Gaussian of 1.5 pixels cut to 11 x 11 and
// of sum 1, C1 = (0.01 L)^2, C2 = (0.03 L)^2, L the range of values. Wang, Bovik, Sheikh and
// Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE
// Trans. Image Processing 13(4), 2004. The mean is over the pixels whose whole window lies in the
// picture, and nothing is made smaller first.
//
//   MS-SSIM = l_5^0.1333 prod_j cs_j^w_j,  w = 0.0448, 0.2856, 0.3001, 0.2363, 0.1333,
//
// means over the picture at five scales, each the means of 2 x 2 pixels of the one before (a last
// odd row or column is left out). Wang, Simoncelli and Bovik, "Multiscale Structural Similarity
// for Image Quality Assessment", Asilomar 2003. A mean below zero, where the pictures are rather
// each other's negatives, has no such power: the product counts it as 0.
#pragma once

#include <optional>

#include "atlas/image.h"
#include "validate/metrics.h"

namespace pluvia {

struct Ssim {
  Image map = {};  // 1 - SSIM, 0 .. 2, one channel of the picture's size; near the border,
                   // where a window reaches out, the picture continues with its border pixels
  MapSummary error = {};               // of the map where windows lie inside
  double mean = 0;                     // SSIM, 1 - error.mean
  std::optional<double> ms_ssim = {};  // none below 176 x 176 pixels: the fifth scale has no window
};

// Of luminance; values in any encoding, `range` = L > 0 (1 for srgb_of). Symmetric. Throws
// std::runtime_error as validate/metrics.h does, for channels other than 1 or 3 and for pictures
// of less than 11 x 11 pixels.
Ssim ssim(const Image& a, const Image& b, double range);

}  // namespace pluvia
