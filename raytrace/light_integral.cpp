#include "raytrace/light_integral.h"

#include <cmath>
#include <numbers>

#include "raytrace/light_integrator.h"

namespace pluvia {

void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      const SpanSlices& slices, StreakWindow& window,
                      const EnvironmentRequest& environment) {
  Integrator integrator{.field = field, .frame = frame, .span = slices, .window = window};
  for (const Eigen::Vector3d& axis : lights.directions) {
    integrator.cones.push_back(make_cone(axis, lights.half_angle_rad));
  }
  integrator.flat_picture_px = std::min(flat_px, flat_radii * field.radius_m / frame.pixel_m);
  integrator.is_delta = lights.half_angle_rad == 0;
  integrator.slice_direction = slices.motion_tolerance * lights.half_angle_rad;
  if (!integrator.is_delta) {
    const double sine = std::sin(lights.half_angle_rad);
    integrator.weight = 1 / (std::numbers::pi * sine * sine);
  }
  for (const FieldPatch& patch : field.patches) {
    switch (patch.kind) {
      case PatchKind::smooth:
        integrate_smooth_patch(integrator, patch);
        break;
      case PatchKind::edge:
        integrate_edge_patch(integrator, patch);
        break;
      case PatchKind::loose:
        integrate_loose_patch(integrator, patch);
        break;
    }
  }
  integrate_surfaces(integrator, environment);
}

}  // namespace pluvia
