#include "raytrace/reference_strata.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

constexpr double least_of_a_drop = 16;  // samples in a pass
constexpr double halved_at = 16;        // samples of a stratum

// The area that a drop passes over in the picture, px^2; 0 where none of it can be seen.
double swept_px2(const ReferenceScene& scene, int index) {
  const FallingDrop& drop = scene.drops.drops[static_cast<std::size_t>(index)];
  const double reach_m = scene.drops.reach_m[static_cast<std::size_t>(drop.shape)];
  const CameraFrame& frame = scene.frame;
  const Eigen::Vector3d ends[2] = {drop.centre_m, drop.centre_m + drop.velocity_m_s * drop.end_s};
  // Outside of one plane of the pyramid of sight at both ends is outside all the way.
  const double half[2] = {scene.camera.width_px / 2.0, scene.camera.height_px / 2.0};
  const Eigen::Vector3d across[2] = {frame.right, frame.up};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d inward =
        (half[k / 2] * frame.forward + (k % 2 == 0 ? 1 : -1) * frame.focal_px * across[k / 2])
            .normalized();
    if (std::max(inward.dot(ends[0]), inward.dot(ends[1])) < -reach_m) return 0;
  }
  const double depth_m = std::min(ends[0].dot(frame.forward), ends[1].dot(frame.forward));
  if (depth_m <= 0) return 0;  // behind the camera: moving_drops keeps none that pass its plane
  const double width_px = 2 * reach_m * frame.focal_px / depth_m;
  return width_px * (width_px + (ends[1] - ends[0]).norm() * frame.focal_px / depth_m);
}

double rms(const Stratum& stratum, std::size_t channel) {
  return stratum.samples > 0 ? std::sqrt(stratum.squares[channel] / stratum.samples) : 0;
}

// The half at the lower end; the upper one as well. What was learned holds for both.
std::array<Stratum, 2> halves(const Stratum& whole) {
  const std::size_t side = static_cast<std::size_t>(
      std::min_element(whole.halvings.begin(), whole.halvings.end()) - whole.halvings.begin());
  Stratum low = whole;
  low.halvings[side] += 1;
  low.samples /= 2;
  for (double& squares : low.squares) squares /= 2;
  Stratum high = low;
  high.low[side] += 1u << (most_halvings - low.halvings[side]);
  return {low, high};
}

struct Allocator {
  std::vector<double> by_size = {};      // of each drop
  std::array<double, 3> per_noise = {};  // samples per volume x rms of a channel
  double even_share = 1;                 // of a pass
  std::vector<Stratum> strata = {};
  std::vector<int> samples = {};

  double wanted(const Stratum& stratum) const {
    const double size = by_size[static_cast<std::size_t>(stratum.drop)];
    double share = 0;
    for (std::size_t c = 0; c < 3; ++c) share += per_noise[c] * rms(stratum, c);
    return volume(stratum) * (even_share * size + share);
  }
  void add(const Stratum& stratum) {
    const double count = wanted(stratum);
    const auto finest = *std::min_element(stratum.halvings.begin(), stratum.halvings.end());
    if (count >= halved_at && finest < most_halvings) {
      for (const Stratum& half : halves(stratum)) add(half);
      return;
    }
    strata.push_back(stratum);
    samples.push_back(std::max(1, static_cast<int>(std::lround(count))));
  }
};

}  // namespace

double volume(const Stratum& stratum) {
  return std::ldexp(
      1, -static_cast<int>(stratum.halvings[0] + stratum.halvings[1] + stratum.halvings[2]));
}

Eigen::Vector3d place_in(const Stratum& stratum, const Eigen::Vector3d& unit) {
  Eigen::Vector3d place;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    place[i] = std::ldexp(stratum.low[k], -static_cast<int>(most_halvings)) +
               std::ldexp(unit[i], -static_cast<int>(stratum.halvings[k]));
  }
  return place;
}

std::vector<Stratum> first_strata(const ReferenceScene& scene) {
  std::vector<Stratum> strata;
  for (int i = 0; i < static_cast<int>(scene.drops.drops.size()); ++i) {
    if (swept_px2(scene, i) > 0) strata.push_back({.drop = i});
  }
  return strata;
}

std::vector<int> allocate(const ReferenceScene& scene, double samples_per_px,
                          std::vector<Stratum>& strata) {
  Allocator allocator;
  allocator.by_size.assign(scene.drops.drops.size(), 0.0);
  double size = 0;
  std::array<double, 3> noise = {};
  for (const Stratum& stratum : strata) {
    double& by_size = allocator.by_size[static_cast<std::size_t>(stratum.drop)];
    if (by_size == 0) {
      by_size = std::max(least_of_a_drop, samples_per_px * swept_px2(scene, stratum.drop));
      size += by_size;
    }
    for (std::size_t c = 0; c < 3; ++c) noise[c] += volume(stratum) * rms(stratum, c);
  }
  // What is learned is shared by the channels that rain changes at all.
  const auto bright = std::count_if(noise.begin(), noise.end(), [](double n) { return n > 0; });
  allocator.even_share = bright > 0 ? 0.25 : 1;
  for (std::size_t c = 0; c < 3; ++c) {
    if (noise[c] > 0) allocator.per_noise[c] = 0.75 / static_cast<double>(bright) * size / noise[c];
  }
  for (const Stratum& stratum : strata) allocator.add(stratum);
  strata = std::move(allocator.strata);
  return allocator.samples;
}

}  // namespace pluvia
