#include "realtime/moving_surfaces.h"

#include "raytrace/moving_parts.h"
#include "raytrace/scene_tops.h"
#include "realtime/rain_inputs.h"

namespace pluvia {
namespace {

// first: the top's first texel in the buffer of all tops.
void upload_rows(const TopHeight& top, const TexelRect& changed, std::size_t first,
                 const GlBuffer& buffer) {
  const std::size_t row =
      first + static_cast<std::size_t>(changed.y0) * static_cast<std::size_t>(top.width);
  update_values(buffer, 3 * row, gpu_top_rows(top, changed.y0, changed.y1));
}

}  // namespace

std::string move_surfaces(Scene& scene, RainSpace& space, double time_s, const ScenePass& surfaces,
                          const ShadowPass& shadows, const RainPass* rain, SplashPass* splashes) {
  if (!pose(scene, time_s)) return "nothing has moved";
  move_vertices(surfaces, scene);
  draw_shadow_maps(shadows, surfaces);
  std::size_t first = 0;
  for (std::size_t i = 0; i < space.tops.size(); ++i) {
    TopHeight& top = space.tops[i];
    const std::vector<TexelRect> changed = move_top(scene, top);
    for (const TexelRect& rect : changed) {
      if (rain) upload_rows(top, rect, first, rain->top_heights);
    }
    if (splashes) move_splashes(top, changed, splashes->splashes.blocks[i]);
    first += top.texels.size();
  }
  return "";
}

}  // namespace pluvia
