#include "realtime/drop_list.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <tbb/parallel_for.h>

namespace pluvia {
namespace {

constexpr int instants = 33, sides = 3;

struct Listing {
  const Scene& scene;
  const StreakGeometry& geometry;
  const Image& depth_m;
  CameraFrame camera = camera_frame(scene.camera);
};

Eigen::Vector3d in_camera(const Listing& listing, const Eigen::Vector3d& place_m) {
  const Eigen::Vector3d from = place_m - listing.scene.camera.position_m;
  return {from.dot(listing.camera.right), from.dot(listing.camera.up),
          from.dot(listing.camera.forward)};
}

Eigen::Vector2d on_screen(const Listing& listing, const Eigen::Vector3d& camera_m) {
  const Camera& camera = listing.scene.camera;
  return {camera.width_px / 2.0 + listing.camera.focal_px * camera_m.x() / camera_m.z(),
          camera.height_px / 2.0 - listing.camera.focal_px * camera_m.y() / camera_m.z()};
}

// Whether any of a path may be in the picture, by the planes of the view; radius_m beside it.
bool may_be_seen(const Listing& listing, const Drop& drop, double end_s) {
  const Eigen::Vector3d a = in_camera(listing, drop.centre_m);
  const Eigen::Vector3d b = in_camera(listing, drop.centre_m + drop.velocity_m_s * end_s);
  const Camera& camera = listing.scene.camera;
  const double focal = listing.camera.focal_px;
  if (std::max(a.z(), b.z()) < nearest_depth_m) return false;
  // Distance from a side plane times at least 1: the pixel's offset from it times depth / f.
  const auto beyond = [&](const Eigen::Vector3d& p, int axis, double sign, double half_px) {
    return sign * p[axis] * focal - half_px * p.z() > 2 * drop.r0_m * std::hypot(focal, half_px);
  };
  for (const double sign : {-1.0, 1.0}) {
    if (beyond(a, 0, sign, camera.width_px / 2.0) && beyond(b, 0, sign, camera.width_px / 2.0))
      return false;
    if (beyond(a, 1, sign, camera.height_px / 2.0) && beyond(b, 1, sign, camera.height_px / 2.0))
      return false;
  }
  return true;
}

bool is_shown(const Image& depth_m, const Eigen::Vector2d& px, double streak_depth_m) {
  const double x = std::floor(px.x()), y = std::floor(px.y());
  if (!(x >= 0 && y >= 0 && x < depth_m.width && y < depth_m.height)) return false;
  return streak_depth_m < static_cast<double>(depth_m.at(static_cast<int>(x), static_cast<int>(y)));
}

// Of the points of one instant those that are shown.
int shown_points(const Listing& listing, const StreakPlacement& placed, const Eigen::Vector2d& px,
                 double r0_m) {
  // column_px is as long as one of the picture's pixels is for a drop of this size.
  const double pixel_m = listing.geometry.pixel_m * r0_m / listing.geometry.mean_radius_m;
  const Eigen::Vector2d side = placed.column_px * (r0_m / pixel_m);
  int shown = 0;
  for (const double k : {-1.0, 0.0, 1.0})
    shown += is_shown(listing.depth_m, px + k * side, placed.depth_m) ? 1 : 0;
  return shown;
}

void add_instant(const Listing& listing, const Drop& drop, double time_s, bool first,
                 ListedDrop& listed) {
  const Eigen::Vector3d place = in_camera(listing, drop.centre_m + drop.velocity_m_s * time_s);
  const Eigen::Vector2d px = on_screen(listing, place);
  const double width_px = 2 * drop.r0_m * listing.camera.focal_px / place.z();
  if (first) {
    listed.start_px = px;
    listed.start_width_px = width_px;
    listed.start_camera_m = place;
  }
  listed.end_px = px;
  listed.end_width_px = width_px;
  listed.end_camera_m = place;
}

std::optional<ListedDrop> listed_drop(const Listing& listing, const Drop& drop) {
  const double exposure_s = listing.scene.camera.exposure_s;
  ListedDrop listed = {.drop = drop, .end_s = std::min(exposure_s, drop.hit_time_s)};
  if (!(drop.hit_time_s > 0) || !may_be_seen(listing, drop, listed.end_s)) return {};
  const SegmentTimes times = segment_times(exposure_s, drop.r0_m, listing.geometry);
  int segment = -1, shown = 0, drawn = 0;
  std::optional<StreakPlacement> placed;
  for (int i = 0; i < instants; ++i) {
    const double time_s = listed.end_s * i / (instants - 1);
    const int now = std::min(static_cast<int>(time_s / times.each_s), times.count - 1);
    if (now != segment) placed = place_streak(listing.scene, drop, listing.geometry, now);
    segment = now;
    if (!placed) continue;
    add_instant(listing, drop, time_s, drawn == 0, listed);
    ++drawn;
    shown += shown_points(listing, *placed, listed.end_px, drop.r0_m);
  }
  if (shown == 0) return {};
  listed.shown_share = static_cast<double>(shown) / (instants * sides);
  return listed;
}

}  // namespace

std::vector<ListedDrop> list_drops(const Scene& scene, const StreakGeometry& geometry,
                                   const std::vector<Drop>& drops, const Image& depth_m,
                                   DropNumbers& numbers) {
  const Listing listing = {scene, geometry, depth_m};
  std::vector<std::optional<ListedDrop>> found(drops.size());
  tbb::parallel_for(std::size_t{0}, drops.size(),
                    [&](std::size_t i) { found[i] = listed_drop(listing, drops[i]); });
  std::vector<ListedDrop> list;
  for (std::optional<ListedDrop>& drop : found) {
    if (!drop) continue;
    const auto [place, is_new] =
        numbers.try_emplace(drop->drop.name, static_cast<int>(numbers.size()));
    drop->id = place->second;
    list.push_back(*drop);
  }
  return list;
}

}  // namespace pluvia
