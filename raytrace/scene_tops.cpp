#include "raytrace/scene_tops.h"

#include <algorithm>
#include <cmath>

#include "raytrace/local_size.h"
#include "raytrace/moving_parts.h"

namespace pluvia {
namespace {

constexpr double finest_texel_m = 0.05;
constexpr double most_texels = 1 << 22;

// Of the surfaces at all times along an axis; low > high without any.
Extent surfaces_along(const Scene& scene, const Eigen::Vector3d& axis) {
  Extent extent = no_extent;
  for (std::size_t i = 0; i < resting_vertices(scene); ++i) {
    const double at_m = scene.mesh.positions_m[i].cast<double>().dot(axis);
    extent = joined(extent, {at_m, at_m});
  }
  for (const MovingPart& part : scene.moving) {
    const Bounds reach = reach_of(part);
    const double middle_m = axis.dot(reach.low_m + reach.high_m) / 2;
    const double half_m = axis.cwiseAbs().dot(reach.high_m - reach.low_m) / 2;
    extent = joined(extent, {middle_m - half_m, middle_m + half_m});
  }
  return extent;
}

// The surfaces in the frame's plane, as far as drops are.
PlaneRect top_rect(const Scene& scene, const FallFrame& frame, bool of_box) {
  if (scene.mesh.positions_m.empty()) return {};
  Extent x = surfaces_along(scene, frame.x), y = surfaces_along(scene, frame.y);
  if (of_box) {
    const Extent box_x = box_along(scene.rain, frame.x), box_y = box_along(scene.rain, frame.y);
    x = {std::max(x.low_m, box_x.low_m), std::min(x.high_m, box_x.high_m)};
    y = {std::max(y.low_m, box_y.low_m), std::min(y.high_m, box_y.high_m)};
  }
  return {x.low_m, y.low_m, x.high_m, y.high_m};
}

// All directions of fall share one budget of texels.
double texels_for_each(const Scene& scene) {
  std::vector<Eigen::Vector3d> velocities;
  for (const RainSize& size : scene.rain.sizes) velocities.push_back(size.velocity_m_s);
  for (const SingleDrop& drop : scene.drops) velocities.push_back(drop.velocity_m_s);
  return most_texels / static_cast<double>(distinct_falls(velocities).size());
}

TexelRect joined(const TexelRect& a, const TexelRect& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

void lay_parts(const Scene& scene, TopHeight& top) {
  for (const MovingPart& part : scene.moving)
    top.covered.push_back(cover(top, scene.mesh, part.first_index, part.index_count));
}

TopHeight top_over(const Scene& scene, const FallFrame& frame, const PlaneRect& rect) {
  const double width = std::max(0.0, rect.max_x_m - rect.min_x_m);
  const double height = std::max(0.0, rect.max_y_m - rect.min_y_m);
  const double texel_m =
      std::max(finest_texel_m, std::sqrt(width * height / texels_for_each(scene)));
  const std::size_t resting = resting_indices(scene);
  TopHeight top = top_height(scene.mesh, frame, rect, texel_m, resting);
  // Heights are told from the lowest, at any pose.
  if (resting == 0 && !scene.moving.empty()) top.lowest_m = surfaces_along(scene, frame.z).low_m;
  lay_parts(scene, top);
  return top;
}

}  // namespace

TopHeight scene_top(const Scene& scene, const FallFrame& frame) {
  // A single drop falls anywhere.
  return top_over(scene, frame, top_rect(scene, frame, scene.drops.empty()));
}

TopHeight box_top(const Scene& scene) {
  return top_over(scene, {}, top_rect(scene, {}, true));
}

void uncover_all(TopHeight& top) {
  for (auto patch = top.covered.rbegin(); patch != top.covered.rend(); ++patch)
    uncover(top, *patch);
  top.covered.clear();
}

std::vector<TexelRect> move_top(const Scene& scene, TopHeight& top) {
  std::vector<TexelRect> changed;
  for (const TopPatch& patch : top.covered) changed.push_back(patch.rect);
  uncover_all(top);
  lay_parts(scene, top);
  for (std::size_t i = 0; i < changed.size(); ++i)
    changed[i] = joined(changed[i], top.covered[i].rect);
  std::erase_if(changed, [](const TexelRect& rect) { return rect.empty(); });
  return changed;
}

}  // namespace pluvia
