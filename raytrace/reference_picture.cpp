#include "raytrace/reference_picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include "raytrace/reference_tracer.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
const Eigen::Array3d luminance = {0.2126, 0.7152, 0.0722};  // Rec.709

enum Stream : std::uint64_t { of_surfaces = 1, of_drops = 2, of_shifts = 3 };

struct Deposit {  // of one sample of a drop
  std::uint32_t pixel = 0;
  double weight = 0;  // px^2 per sample
  Eigen::Vector3d change = {0, 0, 0};
};

struct Task {  // some of the samples of a drop in a pass
  int drop = 0;
  int first = 0, end = 0;
  int of = 0;  // samples of this drop in the pass
  std::vector<Deposit> deposits = {};
};

constexpr int most_of_a_task = 1024;

// A cone of directions around the drop at a time.
struct DropCone {
  Eigen::Vector3d axis = {0, 1, 0};
  double height = 0;  // 1 - cos of the half angle
};

DropCone cone_of(const MovingDrops& drops, int index, double time_s) {
  const MovingDrop& drop = drops.drops[static_cast<std::size_t>(index)];
  const Eigen::Vector3d centre_m = drop.centre_m + drop.velocity_m_s * time_s;
  const double distance_m = centre_m.norm();
  const double sine =
      std::min(1.0, drops.reach_m[static_cast<std::size_t>(drop.shape)] / distance_m);
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

struct Pass {
  const ReferenceScene& scene;
  const ReferenceSettings& settings;
  std::uint64_t number = 0;

  void run_task(Task& task) const {
    const MovingDrop& drop = scene.drops.drops[static_cast<std::size_t>(task.drop)];
    CounterRandom shifts({settings.seed, of_shifts, number, drop.id});
    const Eigen::Vector3d shift(shifts.next(), shifts.next(), shifts.next());
    // Kronecker sequence in three dimensions: powers of the root of g^4 = g + 1 (Roberts 2018).
    const Eigen::Vector3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
    for (int i = task.first; i < task.end; ++i) {
      const Eigen::Vector3d place = shift + i * step;
      const Eigen::Vector3d unit = place.array() - place.array().floor();
      CounterRandom random({settings.seed, of_drops, number, drop.id, std::uint64_t(i)});
      if (const auto deposit = sample_drop(task.drop, unit, random))
        task.deposits.push_back(*deposit);
    }
  }

  std::optional<Deposit> sample_drop(int index, const Eigen::Vector3d& unit,
                                     CounterRandom& random) const {
    const MovingDrop& drop = scene.drops.drops[static_cast<std::size_t>(index)];
    Moment moment(scene.drops, unit[0] * drop.end_s);
    const DropCone cone = cone_of(scene.drops, index, moment.time_s());
    const Ray ray = {{0, 0, 0}, in_cone(cone, unit[1], unit[2])};
    const auto pixel = pixel_of(scene, ray.direction);
    if (!pixel) return {};
    const auto hit = meet_drop(scene.drops, index, ray, moment);
    if (!hit || scene.surfaces->is_blocked(ray, hit->distance) ||
        scene.falling->nearest(ray, moment, hit->distance, index))
      return {};
    const double cosine = ray.direction.dot(scene.frame.forward);
    const double px2 =
        2 * pi * cone.height * std::pow(scene.frame.focal_px, 2) / std::pow(cosine, 3);
    return Deposit{*pixel, px2 * drop.end_s / scene.drops.exposure_s,
                   drop_radiance(scene, ray, {index, *hit}, moment, random) -
                       background_radiance(scene, ray, random)};
  }

  // Mean over a pixel of what is there without drops.
  Eigen::Vector3d sample_surfaces(int x, int y) const {
    const auto side = static_cast<int>(std::lround(std::sqrt(settings.surface_samples)));
    const auto pixel =
        static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene.camera.width_px) +
        static_cast<std::uint64_t>(x);
    Eigen::Vector3d sum = {0, 0, 0};
    CounterRandom random({settings.seed, of_surfaces, number, pixel});
    for (int k = 0; k < side * side; ++k) {
      const double right = (k % side + random.next()) / side;
      const double down = (k / side + random.next()) / side;
      sum += background_radiance(scene, camera_ray(scene, {x + right, y + down}), random);
    }
    return sum / (side * side);
  }
};

void require_finite(const Eigen::Vector3d& value, const ReferenceSums& sums, std::size_t pixel) {
  if (value.allFinite()) return;
  throw std::runtime_error(fmt::format("pixel ({}, {}): {}, {}, {} cd/m^2; expected finite values",
                                       pixel % static_cast<std::size_t>(sums.width),
                                       pixel / static_cast<std::size_t>(sums.width), value.x(),
                                       value.y(), value.z()));
}

void add_surfaces(const Pass& pass, ReferenceSums& sums) {
  tbb::parallel_for(0, sums.height, [&](int y) {
    for (int x = 0; x < sums.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(sums.width) +
                         static_cast<std::size_t>(x);
      const Eigen::Vector3d mean = pass.sample_surfaces(x, y);
      require_finite(mean, sums, pixel);
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = mean[static_cast<Eigen::Index>(c)];
        sums.surface[3 * pixel + c] += value;
        sums.surface_squares[3 * pixel + c] += value * value;
      }
      sums.samples[pixel] += pass.settings.surface_samples;
    }
  });
}

// The area that a drop passes over in the picture, px^2; 0 where none of it can be seen.
double swept_px2(const ReferenceScene& scene, int index) {
  const MovingDrop& drop = scene.drops.drops[static_cast<std::size_t>(index)];
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

constexpr int least_samples = 16, most_samples = 1 << 20;

// How many samples each drop gets in the next pass.
std::vector<int> allocation(const ReferenceScene& scene, const ReferenceSettings& settings,
                            const ReferenceSums& sums) {
  const std::size_t count = scene.drops.drops.size();
  std::vector<double> by_size(count), by_noise(count, 0.0);
  double size = 0, noise = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double px2 = swept_px2(scene, static_cast<int>(i));
    by_size[i] = px2 > 0 ? std::max<double>(least_samples, settings.samples_per_px * px2) : 0;
    if (sums.drop_samples[i] > 0)
      by_noise[i] = std::sqrt(sums.drop_squares[i] / sums.drop_samples[i]);
    size += by_size[i];
    noise += by_noise[i];
  }
  std::vector<int> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double share =
        noise > 0 ? 0.25 * by_size[i] + 0.75 * size * by_noise[i] / noise : by_size[i];
    samples[i] = static_cast<int>(std::ceil(std::min<double>(most_samples, share)));
  }
  return samples;
}

std::vector<Task> tasks_of(const std::vector<int>& samples) {
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (int first = 0; first < samples[i]; first += most_of_a_task) {
      tasks.push_back({.drop = static_cast<int>(i),
                       .first = first,
                       .end = std::min(samples[i], first + most_of_a_task),
                       .of = samples[i]});
    }
  }
  return tasks;
}

// The rain and the coverage of one pass.
struct RainPicture {
  std::vector<double> rain = {}, coverage = {};
};

void lay_down(const Task& task, RainPicture& picture, ReferenceSums& sums) {
  const auto drop = static_cast<std::size_t>(task.drop);
  sums.drop_samples[drop] += task.end - task.first;
  for (const Deposit& deposit : task.deposits) {
    const Eigen::Vector3d value = deposit.weight * deposit.change;
    require_finite(value, sums, deposit.pixel);
    for (std::size_t c = 0; c < 3; ++c)
      picture.rain[3 * deposit.pixel + c] += value[static_cast<Eigen::Index>(c)] / task.of;
    picture.coverage[deposit.pixel] += deposit.weight / task.of;
    sums.samples[deposit.pixel] += 1;
    sums.drop_squares[drop] += (luminance * value.array().square()).sum();
  }
}

void add_rain(const Pass& pass, ReferenceSums& sums) {
  std::vector<Task> tasks = tasks_of(allocation(pass.scene, pass.settings, sums));
  RainPicture picture = {std::vector<double>(sums.rain.size(), 0.0),
                         std::vector<double>(sums.coverage.size(), 0.0)};
  // Batches bound the memory; within one, tasks run in any order and are laid down in theirs.
  constexpr std::size_t batch = 256;
  for (std::size_t begin = 0; begin < tasks.size(); begin += batch) {
    const std::size_t end = std::min(begin + batch, tasks.size());
    tbb::parallel_for(begin, end, [&](std::size_t i) { pass.run_task(tasks[i]); });
    for (std::size_t i = begin; i < end; ++i) {
      lay_down(tasks[i], picture, sums);
      tasks[i].deposits = {};
    }
  }
  for (std::size_t i = 0; i < sums.rain.size(); ++i) {
    sums.rain[i] += picture.rain[i];
    sums.rain_squares[i] += picture.rain[i] * picture.rain[i];
  }
  for (std::size_t i = 0; i < sums.coverage.size(); ++i) sums.coverage[i] += picture.coverage[i];
}

double relative_error(const ReferenceLayer& layer) {
  double noise = 0, signal = 0;
  for (std::size_t i = 0; i < layer.mean.size(); ++i) {
    noise += layer.variance[i];
    signal += layer.mean[i] * layer.mean[i] - layer.variance[i];
  }
  if (noise == 0) return 0;
  return signal > 0 ? std::sqrt(noise / signal) : std::numeric_limits<double>::infinity();
}

}  // namespace

ReferenceSums empty_sums(const ReferenceScene& scene) {
  ReferenceSums sums = {.width = scene.camera.width_px, .height = scene.camera.height_px};
  const std::size_t pixels =
      static_cast<std::size_t>(sums.width) * static_cast<std::size_t>(sums.height);
  for (auto* layer : {&sums.surface, &sums.surface_squares, &sums.rain, &sums.rain_squares})
    layer->assign(3 * pixels, 0.0);
  for (auto* layer : {&sums.coverage, &sums.samples}) layer->assign(pixels, 0.0);
  for (auto* list : {&sums.drop_samples, &sums.drop_squares})
    list->assign(scene.drops.drops.size(), 0.0);
  return sums;
}

void add_pass(const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums) {
  const Pass pass = {scene, settings, static_cast<std::uint64_t>(sums.passes)};
  add_surfaces(pass, sums);
  add_rain(pass, sums);
  ++sums.passes;
}

ReferenceErrors estimated_errors(const ReferenceSums& sums) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  if (sums.passes < 2) return {unknown, unknown};
  return {relative_error(layer_of(sums.surface, sums.surface_squares, sums.passes)),
          relative_error(layer_of(sums.rain, sums.rain_squares, sums.passes))};
}

void trace_reference(
    const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums,
    const std::function<void(const ReferenceSums&, const ReferenceErrors&)>& after_pass) {
  const auto start = std::chrono::steady_clock::now();
  const auto is_done = [&](const ReferenceErrors& errors) {
    if (sums.passes >= settings.most_passes) return true;
    if (sums.passes < settings.least_passes) return false;
    return errors.surface <= settings.error && errors.rain <= settings.error;
  };
  while (!is_done(estimated_errors(sums))) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    if (settings.budget_s > 0 && passed.count() > settings.budget_s) return;
    add_pass(scene, settings, sums);
    if (after_pass) after_pass(sums, estimated_errors(sums));
  }
}

ReferenceLayer layer_of(const std::vector<double>& sums, const std::vector<double>& squares,
                        int passes) {
  ReferenceLayer layer;
  const double n = passes;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double mean = sums[i] / n;
    layer.mean.push_back(mean);
    // Rounding may leave a little less than nothing of equal passes.
    layer.variance.push_back(std::max(0.0, squares[i] - n * mean * mean) / (n * (n - 1)));
  }
  return layer;
}

}  // namespace pluvia
