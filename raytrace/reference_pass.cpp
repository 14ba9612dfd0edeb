#include "raytrace/reference_pass.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "raytrace/reference_tracer.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
const Eigen::Array3d luminance = {0.2126, 0.7152, 0.0722};  // Rec.709

enum Stream : std::uint64_t { of_surfaces = 1, of_drops = 2, of_shifts = 3 };

// A cone of directions around the drop at a time.
struct DropCone {
  Eigen::Vector3d axis = {0, 1, 0};
  double height = 0;  // 1 - cos of the half angle
};

DropCone cone_of(const FallingDrops& drops, int index, double time_s) {
  const FallingDrop& drop = drops.drops[static_cast<std::size_t>(index)];
  const Eigen::Vector3d centre_m = drop.centre_m + drop.velocity_m_s * time_s;
  const double distance_m = centre_m.norm();
  const double reach_m = drops.reach_m[static_cast<std::size_t>(drop.shape)];
  const double sine = std::min(1.0, reach_m / distance_m);
  return {centre_m / distance_m, sine * sine / (1 + std::sqrt(1 - sine * sine))};
}

Eigen::Vector3d in_cone(const DropCone& cone, double u, double v) {
  const double height = u * cone.height, ring = std::sqrt(height * (2 - height));
  const Eigen::Vector3d x = cone.axis.unitOrthogonal(), y = cone.axis.cross(x);
  const double turn = 2 * pi * v;
  return ((1 - height) * cone.axis + ring * (std::cos(turn) * x + std::sin(turn) * y)).normalized();
}

// Where a direction is in the picture; nothing outside.
std::optional<std::uint32_t> pixel_of(const ReferenceScene& scene,
                                      const Eigen::Vector3d& direction) {
  const double forward = direction.dot(scene.frame.forward);
  if (forward <= 0) return {};
  const double scale = scene.frame.focal_px / forward;
  const double x = scene.camera.width_px / 2.0 + scale * direction.dot(scene.frame.right);
  const double y = scene.camera.height_px / 2.0 - scale * direction.dot(scene.frame.up);
  if (!(x >= 0 && x < scene.camera.width_px && y >= 0 && y < scene.camera.height_px)) return {};
  return static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(scene.camera.width_px) +
         static_cast<std::uint32_t>(x);
}

// The sample at a place of a drop's unit cube; nothing where the drop is not met first.
std::optional<Deposit> sample_drop(const ReferenceScene& scene, int index,
                                   const Eigen::Vector3d& place, CounterRandom& random) {
  const FallingDrop& drop = scene.drops.drops[static_cast<std::size_t>(index)];
  Moment moment(scene.drops, place[0] * drop.end_s);
  const DropCone cone = cone_of(scene.drops, index, moment.time_s());
  const Ray ray = {{0, 0, 0}, in_cone(cone, place[1], place[2])};
  const auto pixel = pixel_of(scene, ray.direction);
  if (!pixel) return {};
  const auto hit = meet_drop(scene.drops, index, ray, moment);
  if (!hit || scene.surfaces->is_blocked(ray, hit->distance) ||
      scene.falling->nearest(ray, moment, hit->distance, index))
    return {};
  const double cosine = ray.direction.dot(scene.frame.forward);
  const double px2 = 2 * pi * cone.height * std::pow(scene.frame.focal_px, 2) / std::pow(cosine, 3);
  return Deposit{*pixel, px2 * drop.end_s / scene.drops.exposure_s,
                 drop_radiance(scene, ray, {index, *hit}, moment, random) -
                     background_radiance(scene, ray, random)};
}

void sample_stratum(const ReferenceScene& scene, const PassKey& key,
                    const std::vector<double>& pixel_weights, Stratum& stratum, int count,
                    std::vector<Deposit>& deposits) {
  // Kronecker sequence in three dimensions: powers of the root of g^4 = g + 1 (Roberts 2018).
  static const Eigen::Vector3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
  const std::uint64_t drop = scene.drops.drops[static_cast<std::size_t>(stratum.drop)].id;
  const std::uint64_t corner = (std::uint64_t{stratum.low[0]} << 40) |
                               (std::uint64_t{stratum.low[1]} << 20) | stratum.low[2];
  CounterRandom shifts({key.seed, of_shifts, key.pass, drop, corner});
  const Eigen::Vector3d shift(shifts.next(), shifts.next(), shifts.next());
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d unit = shift + i * step;
    CounterRandom random(
        {key.seed, of_drops, key.pass, drop, corner, static_cast<std::uint64_t>(i)});
    const Eigen::Vector3d inside = unit.array() - unit.array().floor();
    auto deposit = sample_drop(scene, stratum.drop, place_in(stratum, inside), random);
    if (!deposit) continue;
    const Eigen::Array3d brought = deposit->weight * deposit->change;
    for (std::size_t c = 0; c < 3; ++c)
      stratum.squares[c] +=
          pixel_weights[deposit->pixel] * std::pow(brought[static_cast<Eigen::Index>(c)], 2);
    deposit->weight *= volume(stratum) / count;
    deposits.push_back(*deposit);
  }
  stratum.samples += count;
}

}  // namespace

PixelSample sample_pixel(const ReferenceScene& scene, const PassKey& key, int x, int y, int side) {
  const auto pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene.camera.width_px) +
      static_cast<std::uint64_t>(x);
  CounterRandom random({key.seed, of_surfaces, key.pass, pixel});
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = Eigen::Array3d::Zero();
  for (int k = 0; k < side * side; ++k) {
    const double right = (k % side + random.next()) / side;
    const double down = (k / side + random.next()) / side;
    const Eigen::Array3d radiance =
        background_radiance(scene, camera_ray(scene, {x + right, y + down}), random);
    sum += radiance;
    squares += radiance.square();
  }
  const double count = side * side;
  const Eigen::Array3d mean = sum / count;
  return {mean, (luminance * mean).sum(),
          (luminance * (squares / count - mean.square()).max(0)).sum()};
}

std::vector<Deposit> sample_strata(const ReferenceScene& scene, const PassKey& key,
                                   const std::vector<double>& pixel_weights,
                                   std::span<Stratum> strata, std::span<const int> samples) {
  std::vector<Deposit> deposits;
  for (std::size_t i = 0; i < strata.size(); ++i)
    sample_stratum(scene, key, pixel_weights, strata[i], samples[i], deposits);
  return deposits;
}

}  // namespace pluvia
