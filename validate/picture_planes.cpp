#include "validate/picture_planes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/rec709.h"

namespace pluvia {

Plane plane_of(const Image& image, int channel, double factor) {
  return Plane::NullaryExpr(image.height, image.width, [&](Eigen::Index y, Eigen::Index x) {
    return factor * image.at(static_cast<int>(x), static_cast<int>(y), channel);
  });
}

Plane luminance_of(const Image& image) {
  if (image.channels == 1) return plane_of(image, 0);
  if (image.channels != 3) {
    throw std::runtime_error(
        fmt::format("luminance_of: {} channels; expected 1 or 3", image.channels));
  }
  return plane_of(image, 0, rec709_luminance[0]) + plane_of(image, 1, rec709_luminance[1]) +
         plane_of(image, 2, rec709_luminance[2]);
}

Image image_of(const Plane& plane) {
  Image image = make_image(static_cast<int>(plane.cols()), static_cast<int>(plane.rows()));
  std::transform(plane.data(), plane.data() + plane.size(), image.values.begin(),
                 [](double value) { return static_cast<float>(value); });
  return image;
}

Kernel offsets(int radius) {
  return Kernel::LinSpaced(2 * radius + 1, -radius, radius);
}

Kernel gaussian(int radius, double sigma_px) {
  return (-0.5 * (offsets(radius) / sigma_px).square()).exp();
}

Kernel unit_sum(const Kernel& kernel) {
  return kernel / kernel.sum();
}

Plane filtered(const Plane& plane, const Kernel& across, const Kernel& down) {
  const Eigen::Index radius = across.size() / 2, reach = down.size() / 2;
  Plane wide(plane.rows(), plane.cols() + 2 * radius);
  wide << plane.col(0).replicate(1, radius), plane, plane.rightCols(1).replicate(1, radius);
  Plane rows = Plane::Zero(plane.rows(), plane.cols());
  for (Eigen::Index k = 0; k < across.size(); ++k) {
    rows += across[k] * wide.middleCols(k, plane.cols());
  }
  Plane tall(plane.rows() + 2 * reach, plane.cols());
  tall << rows.row(0).replicate(reach, 1), rows, rows.bottomRows(1).replicate(reach, 1);
  Plane sum = Plane::Zero(plane.rows(), plane.cols());
  for (Eigen::Index k = 0; k < down.size(); ++k) sum += down[k] * tall.middleRows(k, plane.rows());
  return sum;
}

void require_pair(const char* who, const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels || a.values.empty() ||
      a.values.size() != b.values.size()) {
    throw std::runtime_error(
        fmt::format("{}: pictures of {} x {} x {} and {} x {} x {}; expected equal sizes > 0", who,
                    a.width, a.height, a.channels, b.width, b.height, b.channels));
  }
  const auto finite = [](float value) { return std::isfinite(value); };
  for (const Image* image : {&a, &b}) {
    if (!std::all_of(image->values.begin(), image->values.end(), finite)) {
      throw std::runtime_error(
          fmt::format("{}: a value is not finite; expected finite pictures", who));
    }
  }
}

}  // namespace pluvia
