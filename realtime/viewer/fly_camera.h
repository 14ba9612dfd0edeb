// A camera flown by hand: pure functions from a camera and what the hand does to the next camera.
// Without input a camera keeps its bits.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "raytrace/scene.h"

namespace pluvia {

struct FlyInput {
  Eigen::Vector3d move = {0, 0, 0};   // right, forward, up: -1 .. 1 each
  Eigen::Vector2d turn_rad = {0, 0};  // to the right, upward
  double speed_m_s = 2;
};

// Steepest view up or down: nearer to the vertical the horizon would spin.
constexpr double steepest_rad = 1.55;

// Right and forward are the view's own, up is the world's (z). The target goes along, as far away
// as before. A turn stops at steepest_rad; a camera that starts steeper keeps its pitch until it is
// turned.
Camera fly(const Camera& camera, const FlyInput& input, double dt_s);

// The camera with another picture size.
Camera resized(const Camera& camera, int width_px, int height_px);

// Where a point is in the picture, x right and y down from its corner; nothing for one behind the
// camera.
std::optional<Eigen::Vector2d> seen_at_px(const Camera& camera, const Eigen::Vector3d& point_m);

// The point, dragged across the picture to a place that keeps its distance along the view.
Eigen::Vector3d dragged_to(const Camera& camera, const Eigen::Vector3d& point_m,
                           const Eigen::Vector2d& to_px);

}  // namespace pluvia
