// Loose patches: the depth ran out, and only the nodes are known.
#include "raytrace/loose_triangles.h"

namespace pluvia {

void integrate_loose_patch(Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  const std::vector<int> lights = integrator.lights_in_reach(node_directions(field, patch));
  if (lights.empty()) return;
  const auto node_at = [&](std::size_t time, std::size_t place) -> std::optional<Node> {
    const std::uint32_t node = cell.nodes[16 * time + place];
    const PathExit* exit = find_exit(field, node, patch.signature);
    if (!exit) return std::nullopt;
    return integrator.node_values(node, *exit);
  };
  const Motion motion = node_motion(integrator, patch);
  for (const Slice& slice : integrator.slices(cell, motion, patch.importance)) {
    const BetweenNodes t = between_nodes(field, slice.cell_share);
    for_loose_triangles(t, field.times, node_at,
                        [&](const ConeVertex& a, const ConeVertex& b, const ConeVertex& c) {
                          for (const int light : lights)
                            integrator.add_triangle(light, slice, a, b, c);
                        });
  }
}

}  // namespace pluvia
