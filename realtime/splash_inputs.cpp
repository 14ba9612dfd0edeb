#include "realtime/splash_inputs.h"

#include "realtime/to_glm.h"

namespace pluvia {

std::vector<GpuSplashPart> gpu_splash_parts(const SplashSpace& splashes) {
  std::vector<GpuSplashPart> parts;
  for (const SplashTable& table : splashes.tables) {
    const auto of_variant = static_cast<std::size_t>(crown_beads + table.droplets);
    double squares = 0;
    for (std::size_t i = 0; i < table.parts.size(); ++i) {
      const SplashPart& part = table.parts[i];
      const std::size_t place = i % of_variant;
      if (place == 0 || place == crown_beads) squares = 0;
      squares += part.radius_m * part.radius_m;
      parts.push_back({to_glm(part.first, part.radius_m), to_glm(part.velocity_m_s, part.drag_s),
                       to_glm({part.delay_s, squares, 0}, 0)});
    }
  }
  return parts;
}

std::vector<GpuSplashSize> gpu_splash_sizes(const SplashSpace& splashes) {
  std::vector<GpuSplashSize> sizes;
  int first = 0;
  for (std::size_t i = 0; i < splashes.tables.size(); ++i) {
    const SplashTable& table = splashes.tables[i];
    const CrownSize& crown = table.crown;
    sizes.push_back(
        {.crown = to_glm({crown.life_s, crown.height_m, crown.first_radius_m}, crown.last_radius_m),
         .impact = to_glm({table.weber, splash_threshold_weber, droplets_a_threshold},
                          splashes.duration_s[i]),
         .parts = {first, table.droplets, 0, 0}});
    first += static_cast<int>(table.parts.size());
  }
  return sizes;
}

}  // namespace pluvia
