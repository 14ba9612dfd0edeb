#include "raytrace/drop_field.h"

#include <cassert>
#include <cmath>

namespace pluvia {
namespace {

// In [0, 1): 32 bits are exact in a double.
double fraction(std::uint32_t bits) {
  return std::ldexp(bits, -32);
}

// Whether the density map leaves that drop.
bool is_rained_on(const DensityMap& map, const RainSizeSpace& size, const RainCell& cell,
                  const std::array<std::uint32_t, 3>& place, std::uint32_t k, std::uint32_t round) {
  if (map.share.empty()) return true;
  const Eigen::Vector2d at =
      size.density_origin +
      size.density_axes *
          (size.cell_m * Eigen::Vector2d(cell.x + fraction(place[0]), cell.y + fraction(place[1])));
  return fraction(rain_hash(cell.keys[2], k, round)[0]) < density_of_texel(map, at);
}

double hit_time_s(const RainSpace& space, const RainSizeSpace& size, const Eigen::Vector3d& at_m) {
  const double top_m = height_at(space.tops[static_cast<std::size_t>(size.top)],
                                 at_m.dot(size.frame.x), at_m.dot(size.frame.y));
  return (at_m.dot(size.frame.z) - top_m) / size.speed_m_s;
}

Drop make_drop(const RainSpace& space, const RainSizeSpace& size, const DropName& name,
               const Eigen::Vector3d& centre_m, int oscillation) {
  return {.name = name,
          .centre_m = centre_m,
          .velocity_m_s = size.drops.velocity_m_s,
          .r0_m = size.drops.r0_m,
          .oscillation = oscillation,
          .hit_time_s = hit_time_s(space, size, centre_m)};
}

struct Field {
  const Scene& scene;
  const RainSpace& space;
  int oscillation_count = 1;
  std::vector<Drop> drops = {};

  void add(const Drop& drop) {
    drops.push_back(drop);
    drops.back().id = drops.size() - 1;
  }
  void add_cell(int size_index, const LocalSpace& local, const RainCell& cell);
  void add_size(int size_index, double time_s);
  void add_single(std::size_t i, double time_s);
  void add_singles(double time_s);
  void add_moving(const DropMotion& motion, double time_s);
};

void Field::add_cell(int size_index, const LocalSpace& local, const RainCell& cell) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  for (const CellDrop& drop : drops_of_cell(scene.rain, space, size, local, cell)) {
    const bool in_box = (drop.centre_m.array() >= scene.rain.box_min_m.array()).all() &&
                        (drop.centre_m.array() <= scene.rain.box_max_m.array()).all();
    if (!in_box) continue;
    const auto sets = static_cast<std::uint64_t>(oscillation_count);
    const auto oscillation = static_cast<int>((std::uint64_t{drop.bits} * sets) >> 32);
    const DropName name = {size_index, cell.x, cell.y, drop.number, drop.round};
    add(make_drop(space, size, name, drop.centre_m, oscillation));
  }
}

void Field::add_size(int size_index, double time_s) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const LocalSpace local = local_space(space, size_index, scene.camera.position_m, time_s);
  if (size.cell_m == 0) return;
  const CellRange cells = local_cells(space, size_index, local);
  for (int y = cells.y0; y < cells.y1; ++y) {
    for (int x = cells.x0; x < cells.x1; ++x) {
      if (in_prism(space, size_index, local, x, y))
        add_cell(size_index, local, rain_cell(size, x, y));
    }
  }
}

void Field::add_single(std::size_t i, double time_s) {
  const SingleDrop& drop = scene.drops[i];
  const int size_index = space.single_sizes[i];
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const DropName name = {
      .size = size_index, .number = static_cast<std::uint32_t>(i), .single = true};
  add(make_drop(space, size, name, drop.centre_m + time_s * drop.velocity_m_s,
                drop.oscillation % oscillation_count));
}

void Field::add_singles(double time_s) {
  for (std::size_t i = 0; i < scene.drops.size(); ++i) add_single(i, time_s);
}

void Field::add_moving(const DropMotion& motion, double time_s) {
  for (std::size_t s = 0; s < motion.sizes.size(); ++s) {
    const MovingSize& size = motion.sizes[s];
    const TopHeight& top = space.tops[static_cast<std::size_t>(space.sizes[s].top)];
    for (std::uint32_t k = 0; k < size.count; ++k) {
      const MovingDrop& drop = motion.drops[size.first + k];
      const DropNow now = drop_now(motion, drop, top, time_s);
      const auto sets = static_cast<std::uint64_t>(oscillation_count);
      add({.name = {.size = static_cast<int>(s), .number = k, .round = drop.fall},
           .centre_m = now.centre_m,
           .velocity_m_s = now.velocity_m_s,
           .r0_m = size.drops.r0_m,
           .oscillation = static_cast<int>((bits_of(size, k, drop) * sets) >> 32),
           .hit_time_s = now.hit_time_s});
    }
  }
}

}  // namespace

std::vector<CellDrop> drops_of_cell(const Rain& rain, const RainSpace& space,
                                    const RainSizeSpace& size, const LocalSpace& local,
                                    const RainCell& cell) {
  std::vector<CellDrop> drops;
  for (std::uint32_t k = 0; k < cell.count; ++k) {
    const std::uint32_t start = rain_hash(cell.keys[0], k, 0)[0];
    const std::uint32_t up = start - local.phase;
    const std::uint32_t round = local.round + (start < local.phase ? 1 : 0);
    const auto place = rain_hash(cell.keys[1], k, round);
    if (!is_rained_on(rain.density, size, cell, place, k, round)) continue;
    drops.push_back({k, round, place[2],
                     (cell.x + fraction(place[0])) * size.cell_m * size.frame.x +
                         (cell.y + fraction(place[1])) * size.cell_m * size.frame.y +
                         (local.floor_m + space.local_height_m * fraction(up)) * size.frame.z});
  }
  return drops;
}

std::vector<Drop> drop_field(const Scene& scene, const RainSpace& space, int oscillation_count,
                             double time_s) {
  assert(oscillation_count >= 1);
  if (needs_motion(scene.rain)) {
    Scene posed = scene;
    DropMotion motion = make_drop_motion(scene);
    move_drops(motion, posed, time_s);
    return drop_field(scene, space, oscillation_count, motion, time_s);
  }
  Field field{scene, space, oscillation_count};
  for (std::size_t i = 0; i < space.sizes.size(); ++i) field.add_size(static_cast<int>(i), time_s);
  field.add_singles(time_s);
  return std::move(field.drops);
}

std::vector<Drop> drop_field(const Scene& scene, const RainSpace& space, int oscillation_count,
                             const DropMotion& motion, double time_s) {
  assert(oscillation_count >= 1);
  Field field{scene, space, oscillation_count};
  field.add_moving(motion, time_s);
  field.add_singles(time_s);
  return std::move(field.drops);
}

void number_sets(const std::vector<int>& sets, std::vector<Drop>& drops) {
  for (Drop& drop : drops) drop.oscillation = sets.at(static_cast<std::size_t>(drop.oscillation));
}

std::vector<Drop> drops_with_sets(const Scene& scene, const std::vector<int>& sets, double time_s) {
  auto drops = drop_field(scene, make_rain_space(scene), static_cast<int>(sets.size()), time_s);
  number_sets(sets, drops);
  return drops;
}

}  // namespace pluvia
