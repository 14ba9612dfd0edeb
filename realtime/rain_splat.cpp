#include "realtime/rain_splat.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "realtime/group_passes.h"

namespace pluvia {
namespace {

// The finest level in which a bin of the widest streak is at most an eighth of a pixel long, as
// rain_splat.comp wants it: rows of a cell are as far apart as its columns. Beyond the level that
// has each cell in one bin all are alike.
int finest_profile(const StreakAtlas& atlas, double widest_px) {
  int rows = 1;
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view)
    rows = std::max(rows, cell_rect(atlas, view, 0, 0).height);
  const double row_px = widest_px / atlas.cell_width_px;
  return static_cast<int>(
      std::clamp(std::floor(std::log2(0.125 / row_px)), 0.0, std::ceil(std::log2(rows))));
}

std::size_t sums_bytes(const Camera& camera) {
  return 5 * static_cast<std::size_t>(camera.width_px) *
         static_cast<std::size_t>(camera.height_px) * sizeof(GLint);
}

}  // namespace

std::string why_all_quads(const Camera& camera, std::size_t most_bytes) {
  if (sums_bytes(camera) <= most_bytes) return "";
  return fmt::format("streaks are all quads: sums of {} x {} pixels need {} bytes, of {}",
                     camera.width_px, camera.height_px, sums_bytes(camera), most_bytes);
}

RainSplat make_rain_splat(const Scene& scene, const StreakAtlas& atlas,
                          const RenderOptions& options, const RainLook& look, int sky_cells,
                          std::shared_ptr<const GpuProfiles> kept, SplatUniforms& uniforms) {
  if (!(options.widest_splat_px >= 0 && options.widest_splat_px <= 16))
    throw std::runtime_error(
        fmt::format("widest_splat_px = {}; expected 0 .. 16", options.widest_splat_px));
  if (options.widest_splat_px == 0 || !why_all_quads(scene.camera, most_storage_bytes()).empty())
    return {};
  RainSplat splat;
  splat.atlas = upload_profiles(atlas, finest_profile(atlas, options.widest_splat_px), sky_cells,
                                std::move(kept));
  splat.widest_px = options.widest_splat_px;
  splat.radiance_quantum_cd_m2 = scene.camera.white_cd_m2 / quanta_of_white;
  splat.sums = make_buffer(nullptr, sums_bytes(scene.camera));
  uniforms.splat = {options.widest_splat_px, longest_splat_px, 1 / splat.radiance_quantum_cd_m2,
                    quanta_of_share};
  splat.overflow = make_buffer(nullptr, sizeof(GLuint));
  const double brightest_per_lux =
      look.traced() ? splat.atlas->brightest_per_lux : look.brightest_per_lux;
  uniforms.most.x = static_cast<float>(
      std::min(1e30, most_streak_quanta * splat.radiance_quantum_cd_m2 / brightest_per_lux));
  uniforms.levels = {splat.atlas->first, splat.atlas->levels, 0, 0};
  return splat;
}

void clear_splat(const RainSplat& splat) {
  for (const GlBuffer* buffer : {&splat.sums, &splat.overflow})
    glClearNamedBufferData(buffer->id(), GL_R32I, GL_RED_INTEGER, GL_INT, nullptr);
}

bool splat_overflowed(const RainSplat& splat) {
  GLuint flag = 0;
  glGetNamedBufferSubData(splat.overflow.id(), 0, sizeof(flag), &flag);
  return flag != 0;
}

void plan_splat(const RainSplat& splat, PlannedPass& plan) {
  if (splat.empty()) return;
  plan.add(splat.program);
  plan.add("thin streaks: profiles", splat.atlas->profiles);
  plan.add("thin streaks: spans", splat.atlas->spans);
  plan.add("thin streaks: sums", splat.sums);
  plan.add("thin streaks: overflow", splat.overflow);
}

}  // namespace pluvia
