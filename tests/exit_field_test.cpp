#include "raytrace/exit_field.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/drop_intersect.h"
#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

ConeLights one_light(const Eigen::Vector3d& direction, double half_angle_rad = 0.05) {
  return {.directions = {direction}, .half_angle_rad = half_angle_rad};
}

double triangle_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a, ac = c - a;
  return 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
}

// Area of the leaves in the picture; of a leaf with a missing corner the triangle that is left.
double projected_area(const ExitField& field) {
  double sum = 0;
  for (const auto& quad : field.quads) {
    std::vector<Eigen::Vector2d> p;
    for (const std::uint32_t k : quad) {
      if (field.nodes[k].visible) p.push_back(field.nodes[k].xy_m);
    }
    sum += triangle_area(p[0], p[1], p[2]);
    if (p.size() == 4) sum += triangle_area(p[0], p[2], p[3]);
  }
  return sum;
}

FieldOptions fine_silhouette() {
  FieldOptions options;
  options.silhouette_depth = 5;
  return options;
}

TEST(ExitField, ASphereCoversItsDiscFromAnyElevation) {
  // Leaves tile the outline but where fine cells meet coarse ones: there the fine nodes stand out
  // of the coarse chord by up to h^2 / 8 = 1.4e-3 (h = 0.106 rad), of which an area of twice that
  // at most is left out. At the rim itself cells of 3e-3 rad lose their square.
  const DropInstant sphere = frozen_drop({});
  for (const double elevation : {-90.0, -30.0, 0.0, 45.0, 90.0}) {
    const View view = view_from_elevation(elevation);
    const ExitField field =
        trace_exit_field(sphere, view, one_light(view.to_camera), fine_silhouette());
    EXPECT_NEAR(projected_area(field) / (pi * 1e-6), 1, 2e-3) << elevation;
  }
}

// Area of the outline of a convex body from its support function h(a) = max over the surface of
// the width across: (1/2) int (h^2 - h'^2) da, here of a rotational body seen from the side.
double outline_area(const DropInstant& drop, const View& view) {
  const int angles = 1000, points = 1000;
  std::vector<double> h;
  for (int k = 0; k < angles; ++k) {
    const double a = 2 * pi * k / angles;
    const Eigen::Vector3d across = std::cos(a) * view.right + std::sin(a) * view.up;
    double most = 0;
    for (int i = 0; i <= points; ++i) {
      const double theta = pi * i / points;
      const double r = surface_radius_m(drop, theta, 0);
      // On its circle of radius r sin theta the rotational body reaches farthest along `across`.
      most = std::max(most, r * std::sin(theta) * std::hypot(across.x(), across.y()) +
                                r * std::cos(theta) * across.z());
    }
    h.push_back(most);
  }
  double sum = 0;
  for (std::size_t k = 0; k < h.size(); ++k) {
    const double slope = (h[(k + 1) % h.size()] - h[k]) * angles / (2 * pi);
    sum +=
        0.5 * (std::pow(0.5 * (h[k] + h[(k + 1) % h.size()]), 2) - slope * slope) * 2 * pi / angles;
  }
  return sum;
}

TEST(ExitField, AFlattenedDropCoversItsOutlineFromAnyElevation) {
  // The support function's sampling errs by (pi / 1000)^2: 1e-5; the leaves as for the sphere.
  const DropInstant drop = frozen_drop({{.n = 2, .amplitude = -0.1}});
  for (const double elevation : {0.0, 30.0, 80.0}) {
    const View view = view_from_elevation(elevation);
    const ExitField field =
        trace_exit_field(drop, view, one_light(view.to_camera), fine_silhouette());
    EXPECT_NEAR(projected_area(field) / outline_area(drop, view), 1, 2e-3) << elevation;
  }
  // From above the outline is the equator's circle, r0 (1 + 0.05).
  const ExitField above =
      trace_exit_field(drop, view_from_elevation(90), one_light({0, 0, 1}), fine_silhouette());
  EXPECT_NEAR(projected_area(above) / (pi * 1.05 * 1.05e-6), 1, 2e-3);
}

TEST(ExitField, TheOutlineDoesNotDependOnTheGridsTurnAndShift) {
  // What cracks leave out differs little from grid to grid: a fifth of it.
  const DropInstant drop = concave_drop(0.2, 0.1);
  const View view = view_from_elevation(20);
  FieldOptions options = fine_silhouette();
  const double area =
      projected_area(trace_exit_field(drop, view, one_light(view.to_camera), options));
  for (const double shift : {-0.5, 0.23, 0.5}) {
    options.shift = shift;
    options.rotation_rad = 2 + shift;
    const ExitField field = trace_exit_field(drop, view, one_light(view.to_camera), options);
    EXPECT_NEAR(projected_area(field) / area, 1, 3e-4) << shift;
  }
}

TEST(ExitField, NodesAreWhatTheCameraSees) {
  const DropInstant drop = concave_drop();
  const View view = view_from_elevation(35);
  const ExitField field = trace_exit_field(drop, view, one_light({0, 1, 0}), {});
  std::size_t visible = 0;
  for (std::uint32_t k = 0; k < field.nodes.size(); ++k) {
    const FieldNode& node = field.nodes[k];
    if (!node.visible) continue;
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
  EXPECT_GT(visible, 300u);
  EXPECT_EQ(find_exit(field, 0, 0xdeadbeef), nullptr);
}

TEST(ExitField, PowerOfAllNodesAddsUpToTheirNumber) {
  const ExitField field =
      trace_exit_field(concave_drop(), view_from_elevation(0), one_light({0, 0, 1}), {});
  double sum = field.remainder.beyond_order + field.remainder.given_up + field.remainder.lost;
  for (const FieldNode& node : field.nodes) sum += node.throughput;
  EXPECT_NEAR(sum / static_cast<double>(field.traced_nodes), 1, 1e-12);
}

TEST(ExitField, NodesAreSpentWhereALightLooks) {
  // A rainbow's light needs its fold refined; so does a light exactly behind or beside the camera
  // (directions on the axis of the map must not confuse the search).
  const DropInstant drop = concave_drop(0.15, 0.05);
  const View view = view_from_elevation(0);
  FieldOptions coarse;
  coarse.bend_depth = coarse.break_depth = 0;
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

TEST(ExitField, LeavesNameNodesThatExistWithThreeCornersAtLeast) {
  const ExitField field =
      trace_exit_field(concave_drop(), view_from_elevation(60), one_light({1, 0, 0}), {});
  for (const auto& quad : field.quads) {
    int visible = 0;
    for (const std::uint32_t k : quad) {
      ASSERT_LT(k, field.nodes.size());
      visible += field.nodes[k].visible ? 1 : 0;
    }
    ASSERT_GE(visible, 3);
  }
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
