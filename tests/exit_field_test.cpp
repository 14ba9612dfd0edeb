#include "raytrace/exit_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/drop_intersect.h"
#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

DropShape oscillating_drop() {
  DropShape drop;
  drop.mean_radius_m = 1e-3;
  drop.modes = {{.n = 2, .amplitude = 0.11}, {.n = 3, .m = 1, .amplitude = 0.1}};
  return drop;
}

ConeLights one_light(const Eigen::Vector3d& direction, double half_angle_rad = 0.05) {
  return {.directions = {direction}, .half_angle_rad = half_angle_rad};
}

TEST(ExitField, ACellsPolynomialIsTheMapAtAnyTimeAndPlace) {
  // Inside a smooth patch, between the nodes of space and time, the tricubic must give what tracing
  // there gives, to a small part of the cone (bend_tolerance 0.3 bounds the third difference; the
  // cubic's own error is less): 5 % of the cone at most.
  DropShape shape = oscillating_drop();
  const View view = view_from_elevation(20);
  const ConeLights lights = one_light(light_direction(10, 150), 0.03);
  const TimeSpan span = {0.8e-3, 1.5e-3};
  const ExitField field = trace_exit_field(shape, span, view, lights, {});
  ASSERT_EQ(field.times, 4);
  int compared = 0;
  for (const FieldPatch& patch : field.patches) {
    if (patch.kind != PatchKind::smooth) continue;
    const FieldCell& cell = field.cells[patch.cell];
    // The middle of the cell in space and time: Lagrange weights of a cubic there.
    constexpr std::array<double, 4> w = {-1.0 / 16, 9.0 / 16, 9.0 / 16, -1.0 / 16};
    Eigen::Vector3d direction = {0, 0, 0};
    Eigen::Vector2d xy = {0, 0};
    double facing = 0;
    for (std::size_t n = 0; n < 64; ++n) {
      const double weight = w[n % 4] * w[n / 4 % 4] * w[n / 16];
      direction += weight * find_exit(field, cell.nodes[n], patch.signature)->direction;
      xy += weight * field.nodes[cell.nodes[n]].xy_m;
      facing += weight * field.nodes[cell.nodes[n]].facing;
    }
    if (facing < 0.1) continue;
    const double share = 0.5 * (cell.first + cell.last);
    const DropInstant drop = drop_at(shape, span.first_s + share * (span.last_s - span.first_s));
    const auto hit =
        intersect_drop(drop, 5e-3 * view.to_camera + xy.x() * view.right + xy.y() * view.up,
                       -view.to_camera, RaySide::outside);
    ASSERT_TRUE(hit);
    std::vector<PathExit> exits;
    trace_exits(drop, hit->position, hit->normal, view.to_camera, {}, exits);
    const auto exit = std::find_if(exits.begin(), exits.end(), [&](const PathExit& e) {
      return e.signature == patch.signature;
    });
    ASSERT_NE(exit, exits.end());
    if (exit->throughput < 0.02) continue;  // fainter paths are followed less finely
    EXPECT_LT((direction.normalized() - exit->direction).norm(), 0.05 * lights.half_angle_rad);
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

TEST(ExitField, PathsOfGoodThroughputCountFully) {
  // A light behind the drop gives nearly all its light by refraction, so that faint paths count for
  // little there; for one before it there is little else.
  const DropShape shape = oscillating_drop();
  const auto mean_of_faint = [&](double azimuth_deg) {
    const ExitField field = trace_exit_field(shape, {0.8e-3, 1.1e-3}, view_from_elevation(0),
                                             one_light(light_direction(0, azimuth_deg)), {});
    double sum = 0;
    int faint = 0;
    for (const FieldPatch& patch : field.patches) {
      EXPECT_GE(patch.importance, least_importance);
      EXPECT_LE(patch.importance, 1);
      double brightest = 0;
      for (const std::uint32_t node : field.cells[patch.cell].nodes) {
        const PathExit* exit = find_exit(field, node, patch.signature);
        if (exit && field.nodes[node].facing > 0) brightest = std::max(brightest, exit->throughput);
      }
      EXPECT_TRUE(brightest < 0.02 || patch.importance == 1) << brightest;
      if (brightest >= 0.02) continue;
      sum += patch.importance;
      ++faint;
    }
    EXPECT_GT(faint, 10);
    return sum / faint;
  };
  EXPECT_GT(mean_of_faint(20), 1.5 * mean_of_faint(160));
}

TEST(ExitField, CellsHoldFourTimesOfAMovingDropAndOneOfARigidOne) {
  const View view = view_from_elevation(0);
  const ConeLights lights = one_light({1, 0, 0});
  EXPECT_EQ(trace_exit_field(oscillating_drop(), {0, 1e-3}, view, lights, {}).times, 4);
  EXPECT_EQ(trace_exit_field(oscillating_drop(), {1e-3, 1e-3}, view, lights, {}).times, 1);
  EXPECT_EQ(trace_exit_field(DropShape{}, {0, 1e-3}, view, lights, {}).times, 1);
}

TEST(ExitField, SurfacesTileTheSpanWithoutOverlap) {
  // Each surface cell covers a square of the map over the whole span: their nodes are distinct but
  // for shared borders, so that N cells have at least 9 N distinct nodes (3 x 3 each) at each time.
  const ExitField field =
      trace_exit_field(concave_drop(), view_from_elevation(20), one_light({1, 0, 0}), {});
  std::set<std::uint32_t> nodes;
  for (const std::uint32_t cell : field.surfaces) {
    for (std::size_t n = 0; n < 16; ++n) nodes.insert(field.cells[cell].nodes[n]);
  }
  EXPECT_GE(nodes.size(), 9 * field.surfaces.size());
}

TEST(ExitField, NodesAreWhatTheCameraSees) {
  const DropInstant drop = concave_drop();
  const View view = view_from_elevation(35);
  const ExitField field = trace_exit_field(drop, view, one_light({0, 1, 0}), {});
  std::size_t visible = 0;
  for (std::uint32_t k = 0; k < field.nodes.size(); ++k) {
    const FieldNode& node = field.nodes[k];
    if (!node.known || node.facing <= 0) continue;
    ++visible;
    const Eigen::Vector3d from =
        5e-3 * view.to_camera + node.xy_m.x() * view.right + node.xy_m.y() * view.up;
    const auto hit = intersect_drop(drop, from, -view.to_camera, RaySide::outside);
    if (!hit || hit->normal.dot(view.to_camera) < 1e-3) continue;  // at the rim either may miss
    std::vector<PathExit> exits;
    trace_exits(drop, hit->position, hit->normal, view.to_camera, {}, exits);
    double sum = 0;
    for (const PathExit& exit : exits) {
      sum += exit.throughput;
      const PathExit* found = find_exit(field, k, exit.signature);
      // Two roads to the point: rounding times the lever of the paths, larger near grazing exits.
      if (!found) continue;
      EXPECT_LT((found->direction - exit.direction).norm(), 1e-4) << k;
    }
    EXPECT_NEAR(node.throughput, sum, 1e-5) << k;
  }
  EXPECT_EQ(visible, field.traced_nodes);
  EXPECT_GT(visible, 700u);
  EXPECT_EQ(find_exit(field, 0, 0xdeadbeef), nullptr);
}

TEST(ExitField, PowerOfAllNodesAddsUpToTheirNumber) {
  const ExitField field =
      trace_exit_field(concave_drop(), view_from_elevation(0), one_light({0, 0, 1}), {});
  double sum = field.remainder.beyond_order + field.remainder.given_up + field.remainder.lost;
  for (const FieldNode& node : field.nodes) {
    if (node.facing > 0) sum += node.throughput;
  }
  EXPECT_NEAR(sum / static_cast<double>(field.traced_nodes), 1, 1e-12);
}

TEST(ExitField, NodesAreSpentWhereALightLooks) {
  // A rainbow's light needs its fold refined; so does a light exactly behind or beside the camera
  // (directions on the axis of the map must not confuse the search).
  const DropInstant drop = concave_drop(0.15, 0.05);
  const View view = view_from_elevation(0);
  FieldOptions coarse;
  coarse.space_depth = 0;
  const auto nodes = [&](const ConeLights& lights, const FieldOptions& options) {
    return trace_exit_field(drop, view, lights, options).traced_nodes;
  };
  const std::size_t dark = nodes({.directions = {}, .half_angle_rad = 0.02}, {});
  for (const double azimuth : {0.0, 40.0, 180.0}) {
    const ConeLights lights = one_light(light_direction(0, azimuth), 0.02);
    EXPECT_GT(nodes(lights, {}), dark + 50) << azimuth;
    EXPECT_LE(nodes(lights, coarse), dark) << azimuth;
  }
}

TEST(ExitField, SmoothPatchesHaveTheirPathAtEveryNode) {
  const ExitField field =
      trace_exit_field(concave_drop(), view_from_elevation(60), one_light({1, 0, 0}), {});
  int smooth = 0;
  for (const FieldPatch& patch : field.patches) {
    ASSERT_LT(patch.cell, field.cells.size());
    if (patch.kind != PatchKind::smooth) continue;
    ++smooth;
    for (std::size_t n = 0; n < 16; ++n) {
      ASSERT_NE(find_exit(field, field.cells[patch.cell].nodes[n], patch.signature), nullptr);
    }
  }
  EXPECT_GT(smooth, 0);
}

TEST(ExitField, ViewsAreRightHandedAndLightsPointWhereTheirAnglesSay) {
  for (double elevation = -90; elevation <= 90; elevation += 15) {
    const View view = view_from_elevation(elevation);
    EXPECT_LT((view.right.cross(view.up) - view.to_camera).norm(), 1e-15) << elevation;
    EXPECT_NEAR(view.to_camera.z(), std::sin(elevation * pi / 180), 1e-15);
    EXPECT_GE(view.up.z(), -1e-15);
  }
  EXPECT_LT((light_direction(0, 90) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((light_direction(90, 17) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((light_direction(-30, 180) - Eigen::Vector3d(-std::sqrt(0.75), 0, -0.5)).norm(), 1e-15);
}

}  // namespace
}  // namespace pluvia
