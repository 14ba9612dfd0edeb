#include "raytrace/splash_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "raytrace/moving_parts.h"
#include "raytrace/rain_packets.h"
#include "raytrace/ray_stretch.h"
#include "raytrace/scene_tops.h"

namespace pluvia {
namespace {

Eigen::Vector3d normal_of(const FallFrame& frame, double slope_x, double slope_y) {
  return (frame.z - slope_x * frame.x - slope_y * frame.y).normalized();
}

constexpr int block_texels = 16;
// Of a texel's plane over all of the texel.
Extent heights(const TopHeight& top, const TopTexel& texel) {
  if (texel.z_m < -1e29f) return no_extent;
  const double beside_m =
      0.5 * top.texel_m * static_cast<double>(std::abs(texel.slope_x) + std::abs(texel.slope_y));
  const double z_m = static_cast<double>(texel.z_m);
  return {z_m - beside_m, z_m + beside_m};
}

Extent block_heights(const TopHeight& top, int block_x, int block_y) {
  Extent extent = no_extent;
  const int end_x = std::min((block_x + 1) * block_texels, top.width);
  const int end_y = std::min((block_y + 1) * block_texels, top.height);
  for (int j = block_y * block_texels; j < end_y; ++j) {
    for (int i = block_x * block_texels; i < end_x; ++i) {
      const auto texel = static_cast<std::size_t>(j) * static_cast<std::size_t>(top.width) +
                         static_cast<std::size_t>(i);
      extent = joined(extent, heights(top, top.texels[texel]));
    }
  }
  return extent;
}

// Those that a rectangle of texels touches.
void set_blocks(const TopHeight& top, const TexelRect& rect, HeightBlocks& blocks) {
  if (rect.empty()) return;
  for (int y = rect.y0 / block_texels; y <= (rect.y1 - 1) / block_texels; ++y) {
    for (int x = rect.x0 / block_texels; x <= (rect.x1 - 1) / block_texels; ++x)
      blocks.extents[static_cast<std::size_t>(y * blocks.width + x)] = block_heights(top, x, y);
  }
  blocks.all = no_extent;
  for (const Extent& extent : blocks.extents) blocks.all = joined(blocks.all, extent);
}

HeightBlocks height_blocks(const TopHeight& top) {
  HeightBlocks blocks = {.width = (top.width + block_texels - 1) / block_texels,
                         .height = (top.height + block_texels - 1) / block_texels,
                         .all = no_extent};
  blocks.extents.resize(static_cast<std::size_t>(blocks.width * blocks.height), no_extent);
  set_blocks(top, {0, 0, top.width, top.height}, blocks);
  return blocks;
}

// Heights of the surfaces below a cell.
Extent heights(const HeightBlocks& blocks, const TopHeight& top, const RainSizeSpace& size,
               const RainCell& cell) {
  const double block_m = block_texels * top.texel_m;
  const auto block = [&](int number, double origin_m, int count) {
    const double at = std::floor((number * size.cell_m - origin_m) / block_m);
    return static_cast<int>(std::clamp<double>(at, -1, count));
  };
  Extent extent = no_extent;
  const int x1 = std::min(block(cell.x + 1, top.min_x_m, blocks.width), blocks.width - 1);
  const int y1 = std::min(block(cell.y + 1, top.min_y_m, blocks.height), blocks.height - 1);
  for (int y = std::max(0, block(cell.y, top.min_y_m, blocks.height)); y <= y1; ++y) {
    for (int x = std::max(0, block(cell.x, top.min_x_m, blocks.width)); x <= x1; ++x)
      extent = joined(extent, blocks.extents[static_cast<std::size_t>(y * blocks.width + x)]);
  }
  return extent;
}

// Whether a box along a frame's axes, seen from the camera, may be in the picture: not wholly
// beyond one of the view's sides.
bool may_be_seen(const Camera& camera, const FallFrame& axes, const Eigen::Vector3d& low,
                 const Eigen::Vector3d& high) {
  const CameraFrame frame = camera_frame(camera);
  const double x = (camera.width_px / 2.0 + 2) / frame.focal_px;
  const double y = (camera.height_px / 2.0 + 2) / frame.focal_px;
  const Eigen::Vector3d inward[5] = {frame.forward, frame.right + x * frame.forward,
                                     -frame.right + x * frame.forward, frame.up + y * frame.forward,
                                     -frame.up + y * frame.forward};
  for (const Eigen::Vector3d& side : inward) {
    const Eigen::Vector3d slopes(side.dot(axes.x), side.dot(axes.y), side.dot(axes.z));
    const double farthest = slopes.cwiseProduct(low).cwiseMax(slopes.cwiseProduct(high)).sum() -
                            side.dot(camera.position_m);
    if (farthest < 0) return false;
  }
  return true;
}

// What splash_duration_s asks of a surface; infinite where it does not face up.
double lean_of(const Eigen::Vector3d& normal, const FallFrame& frame) {
  return normal.dot(frame.z) / std::max(normal.z(), 0.0);
}

double steepest_lean(const TopHeight& top, const FallFrame& frame) {
  double lean = 0;
  for (const TopTexel& texel : top.texels) {
    if (texel.z_m < -1e29f) continue;
    const Eigen::Vector3d normal =
        normal_of(frame, static_cast<double>(texel.slope_x), static_cast<double>(texel.slope_y));
    lean = std::max(lean, lean_of(normal, frame));
  }
  return lean;
}

// The same of a triangle that moves, at any heading, so that no step changes it: a normal of height
// n_z and width n_xy leans by at most f_z + (n_xy / n_z) f_xy against the fall f, and does not face
// up at all where its back may be what the fall meets. One so steep that it stands for a level one
// leans by 1 / f_z.
double steepest_lean(const Eigen::Vector3d& normal, const FallFrame& frame) {
  const double high = std::abs(normal.z()) * frame.z.z();
  const double wide = normal.head<2>().norm() * frame.z.head<2>().norm();
  if (wide > high) return std::numeric_limits<double>::infinity();
  const double lean = high > 0 ? frame.z.z() * (1 + wide / high) : 0;
  const bool steep = high - wide < normal.norm() / std::hypot(1, steepest_slope);
  return steep ? std::max(lean, 1 / frame.z.z()) : lean;
}

double steepest_lean(const Scene& scene, const FallFrame& frame) {
  double lean = 0;
  const Mesh& mesh = scene.mesh;
  for (std::size_t t = resting_indices(scene); t < mesh.indices.size(); t += 3) {
    Eigen::Vector3d corner[3];
    for (std::size_t i = 0; i < 3; ++i)
      corner[i] = mesh.positions_m[mesh.indices[t + i]].cast<double>();
    const Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    lean = std::max(lean, steepest_lean(normal, frame));
  }
  return lean;
}

// Of everything that stands still, and the moving parts wherever they are.
double steepest_lean(const Scene& scene, const TopHeight& top, const FallFrame& frame) {
  if (scene.moving.empty()) return steepest_lean(top, frame);
  TopHeight resting = top;
  uncover_all(resting);
  return std::max(steepest_lean(resting, frame), steepest_lean(scene, frame));
}

struct Finder {
  const Scene& scene;
  const RainSpace& space;
  const SplashSpace& splashes;
  std::vector<Splash> found = {};

  void add(int size_index, std::uint32_t key, const Eigen::Vector3d& centre_m, bool of_rain) {
    const auto index = static_cast<std::size_t>(size_index);
    const RainSizeSpace& size = space.sizes[index];
    const FallFrame& frame = size.frame;
    const TopHeight& top = space.tops[static_cast<std::size_t>(size.top)];
    const double x_m = centre_m.dot(frame.x), y_m = centre_m.dot(frame.y);
    const double below_m = height_at(top, x_m, y_m) - centre_m.dot(frame.z);
    const auto bits = rain_hash(key, 0, 0);
    Splash splash = {.size = size_index,
                     .variant = static_cast<int>(bits[0] % splash_variants),
                     .turn_rad = std::ldexp(2 * std::numbers::pi * bits[1], -32),
                     .since_s = below_m / size.speed_m_s};
    if (splashes.duration_s[index] == 0) return;  // too small to splash
    if (!(splash.since_s < splashes.duration_s[index] && splash.since_s > -scene.camera.exposure_s))
      return;
    splash.place_m = centre_m + below_m * frame.z;
    const TopTexel& texel = *texel_at(top, x_m, y_m);
    splash.normal =
        normal_of(frame, static_cast<double>(texel.slope_x), static_cast<double>(texel.slope_y));
    if (!of_rain || through_box(splash.place_m, frame)) found.push_back(splash);
  }

  bool through_box(const Eigen::Vector3d& place_m, const FallFrame& frame) const {
    RayStretch stretch;
    for (int axis = 0; axis < 3; ++axis)
      clip(place_m[axis], frame.z[axis], scene.rain.box_min_m[axis], scene.rain.box_max_m[axis],
           stretch);
    return stretch.from < stretch.to;
  }
};

}  // namespace

SplashSpace make_splash_space(const Scene& scene, const RainSpace& space) {
  SplashSpace splashes;
  const auto seed = static_cast<std::uint32_t>(scene.rain.seed);
  for (const RainSizeSpace& size : space.sizes) {
    const auto index = static_cast<std::uint32_t>(splashes.tables.size());
    const TopHeight& top = space.tops[static_cast<std::size_t>(size.top)];
    const SplashTable table =
        splash_table(size.drops.r0_m, size.speed_m_s, rain_hash(seed, index, 0)[0]);
    const double lean = steepest_lean(scene, top, size.frame);
    const double whole_s = std::isinf(lean) ? most_splash_s : splash_duration_s(table, lean);
    splashes.duration_s.push_back(table.droplets > 0 ? std::min(whole_s, most_splash_s) : 0);
    splashes.reach_m.push_back(splash_reach_m(table, splashes.duration_s.back()));
    splashes.tables.push_back(table);
  }
  for (const TopHeight& top : space.tops) splashes.blocks.push_back(height_blocks(top));
  return splashes;
}

void move_splashes(const TopHeight& top, const std::vector<TexelRect>& changed,
                   HeightBlocks& blocks) {
  for (const TexelRect& rect : changed) set_blocks(top, rect, blocks);
}

std::vector<SplashSlab> splash_slabs(const Scene& scene, const RainSpace& space,
                                     const SplashSpace& splashes, double time_s) {
  std::vector<SplashSlab> slabs;
  for (std::size_t i = 0; i < space.sizes.size(); ++i) {
    const RainSizeSpace& size = space.sizes[i];
    const Extent& surfaces = splashes.blocks[static_cast<std::size_t>(size.top)].all;
    if (size.cell_m == 0 || splashes.duration_s[i] == 0) continue;
    const double end_m = surfaces.high_m + size.speed_m_s * scene.camera.exposure_s;
    double floor_m = surfaces.low_m - size.speed_m_s * splashes.duration_s[i];
    for (; floor_m < end_m; floor_m += space.local_height_m)
      slabs.push_back(
          {static_cast<int>(i),
           local_space_at(space, static_cast<int>(i), scene.camera.position_m, floor_m, time_s)});
  }
  return slabs;
}

std::vector<RainCell> splash_cells(const Scene& scene, const RainSpace& space,
                                   const SplashSpace& splashes, const SplashSlab& slab) {
  const auto index = static_cast<std::size_t>(slab.size);
  const RainSizeSpace& size = space.sizes[index];
  const auto top = static_cast<std::size_t>(size.top);
  const double reach_m = splashes.reach_m[index];
  const double before_m = size.speed_m_s * scene.camera.exposure_s;
  const double after_m = size.speed_m_s * splashes.duration_s[index];
  std::vector<RainCell> cells;
  const CellRange all = local_cells(space, slab.size, slab.local);
  for (int y = all.y0; y < all.y1; ++y) {
    for (int x = all.x0; x < all.x1; ++x) {
      if (!in_prism(space, slab.size, slab.local, x, y)) continue;
      const Extent surfaces =
          heights(splashes.blocks[top], space.tops[top], size, {.x = x, .y = y});
      const bool in_slab = surfaces.low_m - after_m <= slab.local.floor_m + space.local_height_m &&
                           surfaces.high_m + before_m >= slab.local.floor_m;
      const Eigen::Vector3d reach = Eigen::Vector3d::Constant(reach_m);
      const Eigen::Vector3d low(x * size.cell_m, y * size.cell_m, surfaces.low_m);
      const Eigen::Vector3d high((x + 1) * size.cell_m, (y + 1) * size.cell_m, surfaces.high_m);
      if (in_slab && may_be_seen(scene.camera, size.frame, low - reach, high + reach) &&
          rain_area_m2(scene.rain, size, {x, y, x + 1, y + 1}) > 0)
        cells.push_back(rain_cell(size, x, y));
    }
  }
  return cells;
}

std::vector<Splash> splash_field(const Scene& scene, const RainSpace& space,
                                 const SplashSpace& splashes, double time_s) {
  Finder finder{scene, space, splashes};
  for (const SplashSlab& slab : splash_slabs(scene, space, splashes, time_s)) {
    const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(slab.size)];
    const CellRange cells = local_cells(space, slab.size, slab.local);
    for (int y = cells.y0; y < cells.y1; ++y) {
      for (int x = cells.x0; x < cells.x1; ++x) {
        if (!in_prism(space, slab.size, slab.local, x, y)) continue;
        for (const CellDrop& drop :
             drops_of_cell(scene.rain, space, size, slab.local, rain_cell(size, x, y)))
          finder.add(slab.size, drop.bits >> 16, drop.centre_m, true);
      }
    }
  }
  for (std::size_t i = 0; i < scene.drops.size(); ++i) {
    const SingleDrop& drop = scene.drops[i];
    finder.add(space.single_sizes[i], single_splash_key(i),
               drop.centre_m + time_s * drop.velocity_m_s, false);
  }
  return std::move(finder.found);
}

}  // namespace pluvia
