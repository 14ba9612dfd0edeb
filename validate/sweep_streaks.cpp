#include "validate/sweep_streaks.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include "raytrace/streak_accuracy.h"
#include "validate/batch_judge.h"

namespace pluvia {
std::vector<double> pixels_of(const StreakImage& image) {
  return {image.mean.begin(), image.mean.end()};
}

StreakRequest part_of(StreakRequest request, double share) {
  const double rows_left = (1 - share) * request.frame.path_rows;
  request.exposure_s *= share;
  request.frame.path_rows *= share;
  request.frame.height_px -= static_cast<int>(std::floor(rows_left));
  request.slices = std::max(1, static_cast<int>(std::lround(share * request.slices)));
  request.environment = {.uniform = false};
  return request;
}

std::vector<PictureBatches> trace_truth(const StreakRequest& request) {
  std::vector<TracedStreak> runs(truth_runs);
  tbb::parallel_for(0, truth_runs, [&](int k) {
    StreakRequest other = request;
    other.seed += static_cast<std::uint64_t>(k + 1);
    runs[static_cast<std::size_t>(k)] = trace_streak(other);
  });
  std::vector<PictureBatches> truth(request.lights.size());
  for (const TracedStreak& run : runs) {
    for (std::size_t light = 0; light < run.light.size(); ++light) {
      truth[light].push_back(pixels_of(run.light[light]));
    }
  }
  return truth;
}

JudgedPicture judged(const StreakImage& image, const PictureBatches& truth) {
  const BatchVerdict verdict = judge_picture(pixels_of(image), truth);
  const double noise = std::accumulate(image.variance.begin(), image.variance.end(), 0.0);
  double size = 0;
  for (const auto& batch : truth) {
    size += std::inner_product(batch.begin(), batch.end(), batch.begin(), 0.0);
  }
  // Of the mean square of a batch the noise is a part, which judge_picture takes away.
  size /= static_cast<double>(truth.size()) * (1 + verdict.batch_square);
  return {.square = verdict.square,
          .standard_error = verdict.standard_error,
          .noise_square = size > 0 ? noise / size : 0};
}

void set_error(const std::vector<JudgedPicture>& pictures, SweepPoint& point) {
  assert(!pictures.empty());
  std::vector<JudgedPicture> sorted = pictures;
  std::sort(sorted.begin(), sorted.end(),
            [](const JudgedPicture& a, const JudgedPicture& b) { return a.square < b.square; });
  const JudgedPicture& ranked = sorted[rank_90(sorted.size())];
  const bool seen = ranked.square > ranked.standard_error;
  point.error =
      std::sqrt(seen ? ranked.square : std::max(ranked.square, 0.0) + ranked.standard_error);
  point.standard_error = seen ? ranked.standard_error / (2 * point.error) : point.error;
  std::vector<double> noises;
  for (const JudgedPicture& picture : pictures) noises.push_back(picture.noise_square);
  std::sort(noises.begin(), noises.end());
  point.noise = std::sqrt(noises[rank_90(noises.size())]);
}

}  // namespace pluvia
