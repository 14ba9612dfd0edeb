#include "raytrace/rain_packets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "raytrace/depth_of_field.h"

namespace pluvia {
namespace {

constexpr double most_tree_cells = 1e8;
constexpr double least_forward_m = 1e-3;  // of the frustum's near plane

const RainSizeSpace& size_of(const RainSpace& space, int size) {
  return space.sizes[static_cast<std::size_t>(size)];
}

long cell_count(const CellRange& cells) {
  return std::max(0L, static_cast<long>(cells.x1) - cells.x0) *
         std::max(0L, static_cast<long>(cells.y1) - cells.y0);
}

double drops_per_cell(const RainSpace& space, const RainSizeSpace& size) {
  return size.drops.drops_per_m3 * space.local_height_m * size.cell_m * size.cell_m;
}

// All cells that the box leaves; nothing where they are too many to be stored.
bool bounded_cells(const RainSizeSpace& size, CellRange& cells) {
  const double width = (size.box_x.high_m - size.box_x.low_m) / size.cell_m;
  const double height = (size.box_y.high_m - size.box_y.low_m) / size.cell_m;
  if (!((width + 1) * (height + 1) <= most_tree_cells)) return false;
  const auto index = [&](double at_m) { return static_cast<int>(std::floor(at_m / size.cell_m)); };
  cells = {index(size.box_x.low_m), index(size.box_y.low_m), index(size.box_x.high_m) + 1,
           index(size.box_y.high_m) + 1};
  return true;
}

// Expected drops of a range of cells within the local height.
double expected_drops(const Rain& rain, const RainSpace& space, const RainPacket& packet) {
  const RainSizeSpace& size = size_of(space, packet.size);
  return rain_area_m2(rain, size, packet.cells) * size.drops.drops_per_m3 * space.local_height_m;
}

struct TreeBuilder {
  const Rain& rain;
  const RainSpace& space;
  double most_drops = 1;
  std::vector<RainPacket> leaves = {};

  // True where the packet is a leaf, kept or dry.
  bool is_leaf(const RainPacket& packet) {
    const double drops = expected_drops(rain, space, packet);
    if (drops == 0) return true;
    if (drops > most_drops && cell_count(packet.cells) > 1) return false;
    leaves.push_back(packet);
    return true;
  }

  // Across the longer side, where half of the drops are on either side.
  void halve(const RainPacket& packet) {
    if (is_leaf(packet)) return;
    const CellRange& c = packet.cells;
    const bool along_x = c.x1 - c.x0 >= c.y1 - c.y0;
    const auto part = [&](int at, bool low) {
      RainPacket half = packet;
      (along_x ? (low ? half.cells.x1 : half.cells.x0) : (low ? half.cells.y1 : half.cells.y0)) =
          at;
      return half;
    };
    const double whole = expected_drops(rain, space, packet);
    int first = (along_x ? c.x0 : c.y0) + 1, last = (along_x ? c.x1 : c.y1) - 1;
    while (first < last) {
      const int middle = first + (last - first) / 2;
      if (expected_drops(rain, space, part(middle, true)) < whole / 2)
        first = middle + 1;
      else
        last = middle;
    }
    halve(part(first, true));
    halve(part(first, false));
  }

  void quarter(const RainPacket& packet) {
    if (cell_count(packet.cells) == 0 || is_leaf(packet)) return;
    const CellRange& c = packet.cells;
    const int x = c.x0 + (c.x1 - c.x0 + 1) / 2, y = c.y0 + (c.y1 - c.y0 + 1) / 2;
    for (const CellRange& part : {CellRange{c.x0, c.y0, x, y}, CellRange{x, c.y0, c.x1, y},
                                  CellRange{c.x0, y, x, c.y1}, CellRange{x, y, c.x1, c.y1}})
      quarter({packet.size, part});
  }
};

bool build_tree(const Rain& rain, const RainSpace& space, RainPackets& packets) {
  TreeBuilder halves{rain, space, packets.options.most_drops}, quarters = halves;
  for (std::size_t i = 0; i < space.sizes.size(); ++i) {
    if (space.sizes[i].cell_m == 0) continue;
    RainPacket root = {.size = static_cast<int>(i)};
    if (!bounded_cells(space.sizes[i], root.cells)) return false;
    halves.halve(root);
    quarters.quarter(root);
  }
  packets.quarters = quarters.leaves.size() < halves.leaves.size();
  packets.stored = packets.quarters ? std::move(quarters.leaves) : std::move(halves.leaves);
  return true;
}

// What the local space holds in a scheme's packets, about.
double grid_packets(const RainSpace& space, const RainPackets& packets) {
  double count = 0;
  for (std::size_t i = 0; i < space.sizes.size(); ++i) {
    if (space.sizes[i].cell_m == 0) continue;
    const double side_m = packets.grid_cells[i] * space.sizes[i].cell_m;
    count += std::pow(std::ceil(2 * space.culling_radius_m / side_m), 2);
  }
  return count;
}

// Half a space: inside where normal . p <= offset.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset;
};

using Polygon = std::vector<Eigen::Vector3d>;

Polygon clip(const Polygon& polygon, const HalfSpace& half) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = half.normal.dot(a) - half.offset, db = half.normal.dot(b) - half.offset;
    if (da <= 0) result.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) result.push_back(a + da / (da - db) * (b - a));
  }
  return result;
}

// Andrew's monotone chain.
PlanePolygon convex_hull(PlanePolygon points) {
  const auto before = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::tie(a.x(), a.y()) < std::tie(b.x(), b.y());
  };
  std::sort(points.begin(), points.end(), before);
  if (points.size() < 3) return points;
  PlanePolygon hull;
  const auto turns_right = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d &a = hull[hull.size() - 2], &b = hull.back();
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x()) <= 0;
  };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= first + 2 && turns_right(p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// The frustum as far as anything of the local space can be, its faces seen from the camera.
std::vector<Polygon> frustum_faces(const Camera& camera, double far_m) {
  const CameraFrame frame = camera_frame(camera);
  // A streak that touches the picture may have its path a little beside it, and its circle reaches
  // into a few pixels more.
  const double margin_px = camera.depth_of_field ? 5 : 2;
  const double x = (camera.width_px / 2.0 + margin_px) / frame.focal_px;
  const double y = (camera.height_px / 2.0 + margin_px) / frame.focal_px;
  std::array<Eigen::Vector3d, 8> corner;
  const double signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (std::size_t i = 0; i < 8; ++i) {
    const double depth_m = i < 4 ? least_forward_m : far_m;
    const auto* sign = signs[i % 4];
    const double beside_m = beside_view_m(camera, depth_m);
    corner[i] = depth_m * frame.forward + sign[0] * (depth_m * x + beside_m) * frame.right +
                sign[1] * (depth_m * y + beside_m) * frame.up;
  }
  const int faces[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                           {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<Polygon> polygons;
  for (const auto& face : faces) {
    Polygon polygon;
    for (const int i : face) polygon.push_back(corner[static_cast<std::size_t>(i)]);
    polygons.push_back(polygon);
  }
  return polygons;
}

struct Rect {
  Eigen::Vector2d low, high;
};

Rect bounds(const PlanePolygon& polygon) {
  Rect rect = {polygon.front(), polygon.front()};
  for (const Eigen::Vector2d& p : polygon) rect = {rect.low.cwiseMin(p), rect.high.cwiseMax(p)};
  return rect;
}

bool meet(const Rect& a, const Rect& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

// By the separating axes: the rectangle's sides and the polygon's edges.
bool meet(const Rect& rect, const PlanePolygon& polygon) {
  if (!meet(rect, bounds(polygon))) return false;
  const Eigen::Vector2d middle = (rect.low + rect.high) / 2, half = (rect.high - rect.low) / 2;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    const Eigen::Vector2d outward(edge.y(), -edge.x());
    if (outward.dot(middle - polygon[i]) > outward.cwiseAbs().dot(half)) return false;
  }
  return true;
}

bool meets_prism(const Rect& rect, const Eigen::Vector2d& centre, double radius_m) {
  const Eigen::Vector2d nearest = centre.cwiseMax(rect.low).cwiseMin(rect.high);
  return (nearest - centre).norm() <= radius_m;
}

struct SizeView {  // what is asked of a packet of one size
  LocalSpace local = {};
  PlanePolygon shadow = {};
  PacketSelection selection = PacketSelection::hull;

  bool takes(const Rain& rain, const RainSpace& space, int size, const CellRange& cells) const {
    if (shadow.empty() || cell_count(cells) == 0) return false;
    if (rain_area_m2(rain, size_of(space, size), cells) == 0) return false;
    const double cell_m = size_of(space, size).cell_m;
    // A streak is wider than its path.
    const double beside_m = 4 * size_of(space, size).drops.r0_m;
    const Rect rect = {cell_m * Eigen::Vector2d(cells.x0, cells.y0).array() - beside_m,
                       cell_m * Eigen::Vector2d(cells.x1, cells.y1).array() + beside_m};
    const double radius_m = space.culling_radius_m;
    if (selection == PacketSelection::rectangle) {
      const Eigen::Vector2d reach(radius_m, radius_m);
      return meet(rect, Rect{local.centre_m - reach, local.centre_m + reach}) &&
             meet(rect, bounds(shadow));
    }
    return meets_prism(rect, local.centre_m, radius_m) && meet(rect, shadow);
  }
};

int floor_divided(int a, int b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

void select_grid(const Rain& rain, const RainSpace& space, int size, int side, const SizeView& view,
                 PacketChoice& choice) {
  const CellRange all = local_cells(space, size, view.local);
  for (int y = floor_divided(all.y0, side) * side; y < all.y1; y += side) {
    for (int x = floor_divided(all.x0, side) * side; x < all.x1; x += side) {
      const CellRange cells = {std::max(x, all.x0), std::max(y, all.y0), std::min(x + side, all.x1),
                               std::min(y + side, all.y1)};
      ++choice.looked_at;
      if (view.takes(rain, space, size, cells)) choice.packets.push_back({size, cells});
    }
  }
}

CellRange common(const CellRange& a, const CellRange& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

}  // namespace

RainPackets make_rain_packets(const Rain& rain, const RainSpace& space,
                              const PacketOptions& options) {
  if (!(options.most_drops >= 1))
    throw std::runtime_error(
        fmt::format("packets of {} drops; expected 1 or more", options.most_drops));
  RainPackets packets = {.options = options};
  for (const RainSizeSpace& size : space.sizes) {
    const double cells =
        size.cell_m > 0 ? std::sqrt(options.most_drops / drops_per_cell(space, size)) : 1;
    packets.grid_cells.push_back(static_cast<int>(std::clamp(std::floor(cells), 1.0, 1e6)));
  }
  PacketScheme& scheme = packets.options.scheme;
  if (scheme == PacketScheme::automatic && space.expected_drops <= options.most_drops)
    scheme = PacketScheme::world;
  if (scheme == PacketScheme::automatic || scheme == PacketScheme::tree) {
    const bool built = build_tree(rain, space, packets);
    if (!built && scheme == PacketScheme::tree)
      throw std::runtime_error(
          "packets: a tree over a rain without bounds; expected rain.box_min_m and box_max_m, or "
          "another scheme");
    if (scheme == PacketScheme::automatic) {
      const bool fewer = static_cast<double>(packets.stored.size()) <= grid_packets(space, packets);
      scheme = built && fewer ? PacketScheme::tree : PacketScheme::grid;
    }
    if (scheme != PacketScheme::tree) packets.stored.clear();
  }
  return packets;
}

PlanePolygon view_shadow(const RainSpace& space, int size_index, const LocalSpace& local,
                         const Camera& camera) {
  const RainSizeSpace& size = size_of(space, size_index);
  const FallFrame& frame = size.frame;
  const double camera_z = camera.position_m.dot(frame.z);
  // A drop of the slab is seen while it falls, and is as wide as itself.
  const double path_m = size.speed_m_s * camera.exposure_s;
  const double low = local.floor_m - camera_z - path_m - 4 * size.drops.r0_m;
  const double high = local.floor_m - camera_z + space.local_height_m + 4 * size.drops.r0_m;
  // As far as the farthest drop of the local space.
  const double reach_z = std::max(std::abs(low), std::abs(high));
  const double reach_xy = space.culling_radius_m + 2 * size.cell_m;
  PlanePolygon shadow;
  for (Polygon face : frustum_faces(camera, std::hypot(reach_z, reach_xy))) {
    face = clip(clip(face, {frame.z, high}), {-frame.z, -low});
    for (const Eigen::Vector3d& p : face)
      shadow.push_back(Eigen::Vector2d(p.dot(frame.x), p.dot(frame.y)) + local.centre_m);
  }
  // Every corner of what frustum and slab have in common lies on a face of the frustum.
  return convex_hull(std::move(shadow));
}

PacketChoice select_packets(const Rain& rain, const RainSpace& space, const RainPackets& packets,
                            const Camera& camera, double time_s) {
  PacketChoice choice;
  std::vector<SizeView> views;
  for (std::size_t i = 0; i < space.sizes.size(); ++i) {
    const int size = static_cast<int>(i);
    SizeView view = {.local = local_space(space, size, camera.position_m, time_s),
                     .selection = packets.options.selection};
    if (space.sizes[i].cell_m > 0) {
      view.shadow = view_shadow(space, size, view.local, camera);
      if (packets.options.scheme == PacketScheme::world) {
        choice.packets.push_back({size, local_cells(space, size, view.local)});
        ++choice.looked_at;
      } else if (packets.options.scheme == PacketScheme::grid) {
        select_grid(rain, space, size, packets.grid_cells[i], view, choice);
      }
    }
    views.push_back(std::move(view));
  }
  for (const RainPacket& leaf : packets.stored) {
    const SizeView& view = views[static_cast<std::size_t>(leaf.size)];
    ++choice.looked_at;
    if (view.takes(rain, space, leaf.size, leaf.cells))
      choice.packets.push_back(
          {leaf.size, common(leaf.cells, local_cells(space, leaf.size, view.local))});
  }
  return choice;
}

std::vector<SizedCell> packet_cells(const Rain& rain, const RainSpace& space,
                                    const PacketChoice& choice, const Camera& camera,
                                    double time_s) {
  std::vector<SizedCell> cells;
  for (const RainPacket& packet : choice.packets) {
    const LocalSpace local = local_space(space, packet.size, camera.position_m, time_s);
    for (int y = packet.cells.y0; y < packet.cells.y1; ++y) {
      for (int x = packet.cells.x0; x < packet.cells.x1; ++x) {
        const RainSizeSpace& size = size_of(space, packet.size);
        if (in_prism(space, packet.size, local, x, y) &&
            rain_area_m2(rain, size, {x, y, x + 1, y + 1}) > 0)
          cells.push_back({packet.size, rain_cell(size, x, y)});
      }
    }
  }
  std::sort(cells.begin(), cells.end(), [](const SizedCell& a, const SizedCell& b) {
    return std::tie(a.size, a.cell.y, a.cell.x) < std::tie(b.size, b.cell.y, b.cell.x);
  });
  return cells;
}

std::string packet_scheme_name(PacketScheme scheme) {
  switch (scheme) {
    case PacketScheme::world:
      return "world";
    case PacketScheme::tree:
      return "tree";
    case PacketScheme::grid:
      return "grid";
    default:
      return "automatic";
  }
}

}  // namespace pluvia
