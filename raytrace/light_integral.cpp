#include "raytrace/light_integral.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pluvia {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

// The triangles of a quad that have all their corners: two, or one when a corner is missing.
struct Triangles {
  std::array<Triangle, 2> list = {};
  int count = 0;
};

template <typename Present>
Triangles triangles_of(const std::array<std::uint32_t, 4>& quad, Present present) {
  std::array<bool, 4> here = {};
  int missing = 0;
  std::size_t gap = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    here[k] = present(k);
    if (!here[k]) {
      ++missing;
      gap = k;
    }
  }
  Triangles t;
  if (missing == 0) {
    t.list = {Triangle{quad[0], quad[1], quad[2]}, Triangle{quad[0], quad[2], quad[3]}};
    t.count = 2;
  } else if (missing == 1) {
    t.list[0] = {quad[(gap + 1) % 4], quad[(gap + 2) % 4], quad[(gap + 3) % 4]};
    t.count = 1;
  }
  return t;
}

struct Integrator {
  const ExitField& field;
  const ConeLights& lights;
  const StreakFrame& frame;
  const Travel& travel;
  double time_share;
  StreakWindow& window;
  std::vector<Cone> cones = {};

  ConeVertex vertex(std::uint32_t node) const {
    const Eigen::Vector2d& xy = field.nodes[node].xy_m;
    ConeVertex v = {};
    v.x = frame.centre_column + xy.x() / frame.pixel_m;
    v.y = -xy.y() / frame.pixel_m;
    return v;
  }

  void add_surface(const std::array<std::uint32_t, 4>& quad) {
    const int env = static_cast<int>(cones.size());
    const Triangles t =
        triangles_of(quad, [&](std::size_t k) { return field.nodes[quad[k]].visible; });
    for (int i = 0; i < t.count; ++i) {
      ConePolygon polygon;
      polygon.count = 0;
      for (const std::uint32_t node : t.list[static_cast<std::size_t>(i)]) {
        ConeVertex v = vertex(node);
        v.throughput = field.nodes[node].throughput;
        polygon.vertices[static_cast<std::size_t>(polygon.count++)] = v;
      }
      deposit(window, env, travel, polygon, time_share);
      for (int k = 0; k < 3; ++k) polygon.vertices[static_cast<std::size_t>(k)].throughput = 1;
      deposit(window, env + 1, travel, polygon, time_share);
    }
  }

  void add_triangle(const Triangle& triangle, std::uint64_t signature, const Cone& cone,
                    int plane) {
    ConePolygon polygon;
    polygon.count = 0;
    for (const std::uint32_t node : triangle) {
      ConeVertex v = vertex(node);
      const PathExit* exit = find_exit(field, node, signature);
      if (!gnomonic(cone, exit->direction, v)) return;
      v.throughput = exit->throughput;
      polygon.vertices[static_cast<std::size_t>(polygon.count++)] = v;
    }
    clip_to_cone(cone, polygon);
    const double sine = std::sin(cone.half_angle_rad);
    deposit(window, plane, travel, polygon, time_share / (std::numbers::pi * sine * sine));
  }

  void add_path(const std::array<std::uint32_t, 4>& quad, std::uint64_t signature) {
    Eigen::Vector3d centre = {0, 0, 0};
    std::array<const PathExit*, 4> exits = {};
    bool lit = false;
    for (std::size_t k = 0; k < 4; ++k) {
      exits[k] = find_exit(field, quad[k], signature);
      if (!exits[k]) continue;
      centre += exits[k]->direction;
      lit = lit || exits[k]->throughput > 0;
    }
    if (!lit) return;
    const double length = centre.norm();
    if (length < 1e-6) return;  // directions all around: no linear map; the depth ran out
    centre /= length;
    double radius = 0;
    for (const PathExit* exit : exits) {
      if (exit) radius = std::max(radius, (exit->direction - centre).norm());
    }
    // Chords are shorter than arcs, and the 16-gon's corners stand out.
    const double reach = 1.05 * radius + 1.02 * lights.half_angle_rad;
    const double cosine = std::cos(std::min(reach, std::numbers::pi));
    const Triangles t = triangles_of(quad, [&](std::size_t k) { return exits[k] != nullptr; });
    for (std::size_t light = 0; light < cones.size(); ++light) {
      if (centre.dot(cones[light].axis) < cosine) continue;
      for (int i = 0; i < t.count; ++i) {
        add_triangle(t.list[static_cast<std::size_t>(i)], signature, cones[light],
                     static_cast<int>(light));
      }
    }
  }

  void add_quad(const std::array<std::uint32_t, 4>& quad) {
    add_surface(quad);
    for (std::size_t k = 0; k < 4; ++k) {
      const FieldNode& node = field.nodes[quad[k]];
      for (std::uint32_t e = 0; e < node.exit_count; ++e) {
        const std::uint64_t signature = field.exits[node.first_exit + e].signature;
        bool seen = false;
        for (std::size_t before = 0; before < k && !seen; ++before) {
          seen = find_exit(field, quad[before], signature) != nullptr;
        }
        if (!seen) add_path(quad, signature);
      }
    }
  }
};

}  // namespace

void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      const Travel& travel, double time_share, StreakWindow& window) {
  Integrator integrator{field, lights, frame, travel, time_share, window};
  for (const Eigen::Vector3d& axis : lights.directions) {
    integrator.cones.push_back(make_cone(axis, lights.half_angle_rad));
  }
  for (const auto& quad : field.quads) integrator.add_quad(quad);
}

}  // namespace pluvia
