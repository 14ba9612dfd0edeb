#include "realtime/moving_sky.h"

#include <algorithm>

#include <fmt/format.h>

namespace pluvia {

MovingSky make_moving_sky(const EnvironmentLight& environment, int degree, const MovingSky& kept) {
  if (environment.frames_per_s == 0) return {};
  if (kept.clip) return {kept.clip, degree, kept.shown};
  return {std::make_shared<EnvironmentClip>(environment.map_file), degree};
}

std::string move_sky(MovingSky& sky, const EnvironmentLight& environment, double time_s,
                     ScenePass& surfaces, RainPass* rain, FogPass* fog) {
  const Image& map = sky.clip->at(clip_picture(environment, time_s));
  const std::string held = sky.clip->held() ? "the clip has ended: its last map is held" : "";
  if (sky.shown == sky.clip->shown()) return held.empty() ? "the same map" : held;
  sky.shown = sky.clip->shown();
  set_sky(surfaces, environment, map);
  if (rain) set_sky(*rain, sky_light(environment, &map, sky.degree));
  if (fog) fog->values.environment = mean_environment(environment, &map);
  return "";
}

PlannedPass plan_of(const MovingSky&, const EnvironmentLight& environment) {
  return {.name = "sky",
          .notes = {fmt::format("{} maps a second from {} s on; the last one is held",
                                environment.frames_per_s, environment.start_s)}};
}

}  // namespace pluvia
