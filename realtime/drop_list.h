// The drops of a frame one by one, as ground truth: where each is and where its streak is seen.
// The drops are those of raytrace/drop_field.h, their places on screen those of
// raytrace/streak_placement.h; splashes are not in the list.
//
// A drop counts as shown by the share of 33 x 3 points of its streak (33 instants evenly from
// shutter-open to shutter-close, or until it hits; centre and both sides, a mean radius off) that
// lie in the picture and before what stands there. Drops that are not shown at all are not listed.
// What streaks hide of each other is not looked at, nor the circle of a lens: streaks are in focus.
#pragma once

#include <map>
#include <vector>

#include "atlas/image.h"
#include "raytrace/drop_field.h"
#include "raytrace/scene.h"
#include "raytrace/streak_placement.h"

namespace pluvia {

struct ListedDrop {
  int id = 0;        // of all drops of a run, in the order in which they come to be shown, from 0
  Drop drop = {};    // at shutter-open
  double end_s = 0;  // after shutter-open: of the exposure, or when it hits
  // Of the first and the last of the 33 instants at which it is drawn at all (not nearer than
  // nearest_depth_m, not in a lamp): centre on screen (x right, y down, pixel (i, j) covers [i,
  // i+1] x [j, j+1]), the width of a sphere of its radius, and its centre in the camera's axes:
  // right, up, forward.
  Eigen::Vector2d start_px = {0, 0}, end_px = {0, 0};
  double start_width_px = 0, end_width_px = 0;
  Eigen::Vector3d start_camera_m = {0, 0, 0}, end_camera_m = {0, 0, 0};
  double shown_share = 0;  // 1 / 99 .. 1
};

// Numbers for drops, the same for the same drop in all frames of a run.
using DropNumbers = std::map<DropName, int>;

// depth_m: of what stands in the picture, of the camera's size. In order of `drops`. The same for
// any number of threads.
std::vector<ListedDrop> list_drops(const Scene& scene, const StreakGeometry& geometry,
                                   const std::vector<Drop>& drops, const Image& depth_m,
                                   DropNumbers& numbers);

}  // namespace pluvia
