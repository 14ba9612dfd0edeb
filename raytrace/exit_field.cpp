#include "raytrace/exit_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "raytrace/field_lattice.h"
#include "raytrace/path_shape.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;

// A path counts fully where it passes this share of the light (reflection at normal incidence), or
// gives as much of some light's whole light as the second; with less of both, its map may bend more
// in proportion, and where it breaks, every halving of its light saves one halving of the cell.
// (The second alone would not do: grazing reflection, bright from a thin ring, then comes out
// double.)
constexpr double full_throughput = 0.02;
constexpr double full_share = 0.25;

// How bright lights are is only needed roughly, and known before anything is refined: from the
// exits of the coarsest nodes within this angle of each light. No light is thought to have less
// than the least, per r0^2: a fifth of what water reflects backward.
constexpr double brightness_reach_rad = 15 * pi / 180;
constexpr double least_brightness = 1e-3;

// Third difference of a smooth throughput, over its largest.
constexpr double dim_tolerance = 0.3;

// An error of the beam that meets the last interface grows by the index and by one over the cosine
// of refraction when it leaves: it must be smaller by this share.
constexpr double interface_share = 0.3;

// Where the depth runs out, the polynomial through a cell's nodes is still the best guess while the
// third differences of its directions are below this many tolerances, and those of its light below
// this many times the brightest (a kink, where an inner reflection becomes total, stays below;
// reflection beyond the outline does not); else only the nodes are trusted.
constexpr double trusted_bends = 10;
constexpr double trusted_light = 2;

struct OpenCell {
  LatticePlace origin = {};
  int step = 1, time_step = 1;  // between its nodes, on the finest lattice
  bool surface_done = false;
  std::vector<std::uint64_t> done = {};  // signatures that coarser cells have settled
};

// What a cell, or a path in it, still asks for.
struct Halving {
  bool space = false, time = false;
  bool any() const { return space || time; }
};

struct Refiner {
  FieldLattice& lattice;
  const ConeLights& lights;
  const FieldOptions& options;
  ExitField& field;
  std::vector<OpenCell> next = {};
  std::vector<double> brightness = {};  // of the lights

  int node_count() const { return field.times * cell_side * cell_side; }

  // The light toward each light, per r0^2 and steradian, from the nodes traced so far.
  void measure_brightness() {
    const double cosine = std::cos(brightness_reach_rad);
    const double area = std::pow(lattice.step_rad() * (1 << options.space_depth), 2);
    const double scale = area / (2 * pi * (1 - cosine) * field.times);
    brightness.assign(lights.directions.size(), 0.0);
    for (const FieldNode& node : field.nodes) {
      if (node.facing <= 0) continue;
      for (std::uint32_t e = 0; e < node.exit_count; ++e) {
        const PathExit& exit = field.exits[node.first_exit + e];
        for (std::size_t l = 0; l < brightness.size(); ++l) {
          if (lights.directions[l].dot(exit.direction) < cosine) continue;
          brightness[l] += scale * node.facing * exit.throughput;
        }
      }
    }
    for (double& b : brightness) b = std::max(b, least_brightness);
  }

  // Of the dimmest light within an angle of a direction; none: infinite.
  double dimmest_light(const Eigen::Vector3d& centre, double angle_rad) const {
    const double cosine = angle_rad >= pi ? -2 : std::cos(angle_rad);
    double dimmest = std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < brightness.size(); ++l) {
      if (lights.directions[l].dot(centre) > cosine) dimmest = std::min(dimmest, brightness[l]);
    }
    return dimmest;
  }

  // FieldPatch::importance; 0 where no light is near. The path's own light is spread over its
  // directions and, around them, a cone. Where nodes are missing, what is missing may lie beyond
  // what is seen; nothing more was found with three times this slack.
  double importance(const PathShape& shape, const OpenCell& cell) const {
    const bool whole = shape.known == node_count();
    const double slack =
        whole ? 0.2 * shape.radius_rad + 0.5 * std::max(shape.map.space, shape.map.time)
              : shape.radius_rad + 3 * cell.step * lattice.step_rad();
    const double cone = lights.half_angle_rad;
    const double dimmest = dimmest_light(shape.centre, shape.radius_rad + slack + cone);
    if (std::isinf(dimmest)) return 0;
    const double light = shape.mean_light * std::pow(3 * cell.step * lattice.step_rad(), 2);
    const double seen = static_cast<double>(shape.seen) / node_count();
    const double spread = seen * shape.spread_sr + 4 * shape.radius_rad * cone + pi * cone * cone;
    const double share = light / spread / (full_share * dimmest);
    return std::clamp(std::max(share, shape.brightest / full_throughput), least_importance, 1.0);
  }

  // Third differences over what is tolerated; 1 or less is smooth.
  struct Roughness {
    double space = 0, time = 0;  // of directions or light, whichever is worse
    double direction = 0;        // in space or time
    double light = 0;            // .. over its brightest
    double worst() const { return std::max(space, time); }
    bool to_be_trusted() const { return direction < trusted_bends && light < trusted_light; }
  };

  Roughness roughness(const PathShape& shape, const PathShape::Bends& bends, double importance,
                      double share) const {
    const double bend = share * options.bend_tolerance * lights.half_angle_rad / importance;
    const double dim =
        share * std::min(dim_tolerance / importance, trusted_light) * shape.brightest;
    return {std::max(bends.space / bend, bends.dim / dim),
            std::max(bends.time / bend, bends.time_dim / dim),
            std::max(bends.space, bends.time) / bend,
            std::max(bends.dim, bends.time_dim) / shape.brightest};
  }

  struct Verdict {
    PatchKind kind = PatchKind::loose;
    Halving wanted = {};  // of what is left
  };

  Verdict judge(const PathShape& shape, const CellExits& exits, const OpenCell& cell,
                double importance) const {
    const Halving left = {cell.step > 1, field.times > 1 && cell.time_step > 1};
    if (shape.known < node_count()) {
      const int most = 1 << static_cast<int>(std::log2(1 / importance));
      return {PatchKind::loose, {cell.step > most, left.time && cell.time_step > most}};
    }
    const Roughness map = roughness(shape, shape.map, importance, 1);
    if (map.worst() <= 1) return {PatchKind::smooth, {}};
    const Roughness end =
        roughness(shape, interface_bends(exits, field.times), importance, interface_share);
    const bool map_is_better = map.worst() <= end.worst();
    const Roughness& better = map_is_better ? map : end;
    const Halving wanted = {better.space > 1 && left.space, better.time > 1 && left.time};
    if (better.to_be_trusted()) {
      return {map_is_better ? PatchKind::smooth : PatchKind::edge, wanted};
    }
    const Roughness& other = map_is_better ? end : map;
    if (!other.to_be_trusted()) return {PatchKind::loose, wanted};
    return {map_is_better ? PatchKind::edge : PatchKind::smooth, wanted};
  }

  template <typename Take>  // take(place) for each node of a cell, in the order of its list
  void for_nodes(const OpenCell& open, Take take) const {
    for (int k = 0; k < field.times; ++k) {
      for (int j = 0; j < cell_side; ++j) {
        for (int i = 0; i < cell_side; ++i) {
          take(LatticePlace{open.origin.i + i * open.step, open.origin.j + j * open.step,
                            open.origin.k + k * open.time_step});
        }
      }
    }
  }

  FieldCell ask(const OpenCell& open) const {
    FieldCell cell;
    std::size_t n = 0;
    for_nodes(open, [&](const LatticePlace& place) { cell.nodes[n++] = ask_node(lattice, place); });
    const double times = static_cast<double>(lattice.drops.size() - 1);
    if (field.times > 1) {
      cell.first = open.origin.k / times;
      cell.last = (open.origin.k + (cell_side - 1) * open.time_step) / times;
    }
    return cell;
  }

  // The signatures in a cell that no coarser cell has settled.
  std::vector<std::uint64_t> open_signatures(const OpenCell& open, const FieldCell& cell) const {
    std::vector<std::uint64_t> found;
    for (int n = 0; n < node_count(); ++n) {
      const FieldNode& node = field.nodes[cell.nodes[static_cast<std::size_t>(n)]];
      for (std::uint32_t e = 0; e < node.exit_count; ++e) {
        const std::uint64_t s = field.exits[node.first_exit + e].signature;
        if (std::find(open.done.begin(), open.done.end(), s) == open.done.end() &&
            std::find(found.begin(), found.end(), s) == found.end()) {
          found.push_back(s);
        }
      }
    }
    return found;
  }

  // Settles the surface: true when the camera sees something here and some nodes are not known.
  bool surface_is_open(const FieldCell& cell, const OpenCell& open) {
    bool whole = true, visible = false;
    for (int n = 0; n < node_count(); ++n) {
      const FieldNode& node = field.nodes[cell.nodes[static_cast<std::size_t>(n)]];
      whole = whole && node.known;
      visible = visible || (node.known && node.facing > 0);
    }
    if (!visible) return false;
    if (!whole && open.step > 1) return true;
    field.surfaces.push_back(static_cast<std::uint32_t>(field.cells.size()));
    return false;
  }

  void settle(OpenCell open, const FieldCell& cell) {
    const std::size_t patches = field.patches.size(), surfaces = field.surfaces.size();
    const auto index = static_cast<std::uint32_t>(field.cells.size());
    Halving halving;
    if (!open.surface_done) {
      const bool still_open = surface_is_open(cell, open);
      open.surface_done = !still_open;
      halving.space = still_open;
    }
    std::vector<std::uint64_t> signatures;
    if (!lights.directions.empty()) signatures = open_signatures(open, cell);
    for (const std::uint64_t signature : signatures) {
      CellExits exits = {};
      const PathShape shape = path_shape(field, cell, signature, exits);
      bool done = true;
      const double counts = shape.dark ? 0 : importance(shape, open);
      if (counts > 0) {
        const Verdict verdict = judge(shape, exits, open, counts);
        done = !verdict.wanted.any();
        halving.space = halving.space || verdict.wanted.space;
        halving.time = halving.time || verdict.wanted.time;
        if (done) field.patches.push_back({index, signature, verdict.kind, counts});
      }
      if (done) open.done.push_back(signature);
    }
    if (field.patches.size() > patches || field.surfaces.size() > surfaces) {
      field.cells.push_back(cell);
    }
    if (halving.any()) halve(open, halving);
  }

  void halve(const OpenCell& open, const Halving& halving) {
    OpenCell child = open;
    if (halving.space) child.step /= 2;
    if (halving.time) child.time_step /= 2;
    const int shift = (cell_side - 1) * child.step, time_shift = (cell_side - 1) * child.time_step;
    for (int c = 0; c <= (halving.time ? 1 : 0); ++c) {
      for (int b = 0; b <= (halving.space ? 1 : 0); ++b) {
        for (int a = 0; a <= (halving.space ? 1 : 0); ++a) {
          child.origin = {open.origin.i + a * shift, open.origin.j + b * shift,
                          open.origin.k + c * time_shift};
          next.push_back(child);
        }
      }
    }
  }
};

// A field without content, but with the memory of another.
ExitField emptied(ExitField other) {
  const auto take = [](auto& list) {
    list.clear();
    return std::move(list);
  };
  ExitField field;
  field.nodes = take(other.nodes);
  field.exits = take(other.exits);
  field.cells = take(other.cells);
  field.patches = take(other.patches);
  field.surfaces = take(other.surfaces);
  return field;
}

ExitField trace(std::vector<DropInstant> drops, const View& view, const ConeLights& lights,
                const FieldOptions& options, ExitField storage) {
  assert(lights.directions.empty() || lights.half_angle_rad > 0);
  ExitField field = emptied(std::move(storage));
  field.times = drops.size() > 1 ? cell_side : 1;
  field.refractive_index = options.paths.refractive_index;
  field.radius_m = drops.front().surface.scale;
  FieldLattice lattice = make_field_lattice(std::move(drops), view, options, field);
  Refiner refiner{.lattice = lattice, .lights = lights, .options = options, .field = field};
  const int step = 1 << options.space_depth;
  const int span = (cell_side - 1) * step;
  const int time_step = field.times == 1 ? 1 : 1 << options.time_depth;
  for (int j = 0; j < options.base_cells; ++j) {
    for (int i = 0; i < options.base_cells; ++i) {
      refiner.next.push_back(
          {.origin = {i * span, j * span, 0}, .step = step, .time_step = time_step});
    }
  }
  while (!refiner.next.empty()) {
    const std::vector<OpenCell> now = std::move(refiner.next);
    refiner.next.clear();
    std::vector<FieldCell> cells;
    cells.reserve(now.size());
    for (const OpenCell& open : now) cells.push_back(refiner.ask(open));
    trace_asked(lattice);
    if (!lights.directions.empty() && refiner.brightness.empty()) refiner.measure_brightness();
    for (std::size_t n = 0; n < now.size(); ++n) refiner.settle(now[n], cells[n]);
  }
  return field;
}

}  // namespace

View view_from_elevation(double elevation_deg) {
  const double e = elevation_deg * pi / 180;
  return {{std::cos(e), 0, std::sin(e)}, {0, 1, 0}, {-std::sin(e), 0, std::cos(e)}};
}

Eigen::Vector3d light_direction(double elevation_deg, double azimuth_deg) {
  const double v = elevation_deg * pi / 180, h = azimuth_deg * pi / 180;
  return {std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v)};
}

const PathExit* find_exit(const ExitField& field, std::uint32_t node, std::uint64_t signature) {
  const FieldNode& n = field.nodes[node];
  for (std::uint32_t k = 0; k < n.exit_count; ++k) {
    const PathExit& exit = field.exits[n.first_exit + k];
    if (exit.signature == signature) return &exit;
  }
  return nullptr;
}

ExitField trace_exit_field(const DropShape& drop, const TimeSpan& span, const View& view,
                           const ConeLights& lights, const FieldOptions& options,
                           ExitField storage) {
  std::vector<DropInstant> drops;
  if (is_rigid(drop) || span.first_s == span.last_s) {
    drops.push_back(drop_at(drop, span.first_s));
  } else {
    const int steps = (cell_side - 1) << options.time_depth;
    for (int k = 0; k <= steps; ++k) {
      drops.push_back(drop_at(drop, span.first_s + (span.last_s - span.first_s) * k / steps));
    }
  }
  return trace(std::move(drops), view, lights, options, std::move(storage));
}

ExitField trace_exit_field(const DropInstant& drop, const View& view, const ConeLights& lights,
                           const FieldOptions& options) {
  return trace({drop}, view, lights, options, {});
}

}  // namespace pluvia
