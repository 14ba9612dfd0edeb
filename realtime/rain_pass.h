// Rain over a scene: drops from their seed, one record per visible drop, one quad per record, added
// up into radiance and optical depth.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/streak_atlas.h"
#include "raytrace/rain_packets.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "raytrace/sky_light.h"
#include "realtime/billboard_pass.h"
#include "realtime/gl_objects.h"
#include "realtime/gpu_atlas.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_look.h"
#include "realtime/rain_renderer.h"
#include "realtime/rain_splat.h"
#include "realtime/refraction_look.h"
#include "realtime/scene_pass.h"
#include "realtime/shadow_pass.h"
#include "realtime/streak_record.h"
#include "realtime/wind_pass.h"

namespace pluvia {

struct RainPass {
  Eigen::Vector3d origin_m = {0, 0, 0};  // of the shadow maps
  const RainSpace* space = nullptr;      // the renderer's
  const WindPass* wind = nullptr;        // the renderer's; of drops that move by steps
  RainPackets packets = {};
  double far_streaks = 0;
  PacketCounts counts = {};  // of the last frame
  RainUniforms uniforms = {};
  std::vector<GpuRainSize> sizes = {};
  std::vector<GpuDropGroup> groups = {};
  std::shared_ptr<const GpuSums> atlas = {};
  std::size_t capacity = 0;        // streaks that the record buffers hold
  std::size_t group_capacity = 0;  // groups that their buffers hold
  GlBuffer uniform_buffer = {}, size_buffer = {}, group_buffer = {}, top_heights = {},
           densities = {};
  GlBuffer group_starts = {}, streaks = {}, lit_streaks = {};
  GlBuffer lights = {}, atlas_lights = {}, atlas_layers = {}, atlas_views = {};
  GlBuffer light_rows = {}, light_entries = {};  // with eight taps
  GlBuffer sky = {}, sky_streaks = {};           // of one that differs by direction
  GlBuffer quad_indices = {};
  GlBuffer light_candidates = {};       // with one
  BillboardPass billboards = {};        // empty: streaks
  RainSplat splat = {};                 // empty: every streak is a quad
  GLuint scene_depth_m = 0;             // the surfaces'
  bool lens = false;                    // streaks are out of focus
  int taps = 1;                         // lit records of a streak and light
  std::vector<std::string> notes = {};  // what the plan should say
  RainLook look = {};
  int shapes_of_set = 0;                          // layers of an oscillation; 0: no strokes
  std::optional<RefractionLook> refraction = {};  // of streaks that refract
  int sky_cells = 0;   // of the atlas and sky, that a streak mixes: none, uniform, or harmonics
  int view_taps = 2;   // views that a streak mixes
  GlTexture sum = {};  // of all streaks: RGBA32F, weighted radiance and tau
  GlTexture coverage = {};  // R32F, weighted coverage
  GlTexture seen = {};      // RGBA32F: what they add to the picture (realtime/composite_pass.h)
  GlFramebuffer target = {};
  GlVertexArray quads = {};
  ShaderProgram count = {}, place = {}, draw = {}, centres = {};
};

// wind: nullptr for drops of the closed form. sky: of at most sky_degree's degree
// (realtime/rain_inputs.h). kept: of an earlier pass of the same atlas (realtime/gpu_atlas.h).
// Throws std::runtime_error when scene and atlas do not agree or do not fit this OpenGL.
RainPass make_rain_pass(const Scene& scene, const RainSpace& space, const StreakAtlas& atlas,
                        const RenderOptions& options, const SkyLight& sky,
                        const ScenePass& surfaces, const ShadowPass& shadows,
                        const WindPass* wind = nullptr, const GpuAtlas& kept = {});

// Another sky of as many harmonics.
void set_sky(RainPass& pass, const SkyLight& sky);

// What another pass of the same atlas may keep.
GpuAtlas atlas_of(const RainPass& pass);

// Fills the records for a shutter that opens at time_s, which drops that move by steps have been
// brought to, for scene.camera as it is now, and adds up
// thin streaks; returns how many streaks are in view. Throws std::runtime_error for a time that
// local_space refuses.
long place_rain(RainPass& pass, const Scene& scene, const ShadowPass& shadows, double time_s);

// Where the pass has billboards: puts them over a picture of the size of the scene's, behind its
// surfaces. The groups of drops are those of place_rain.
void draw_billboards(const RainPass& pass, const GlFramebuffer& picture);

// Adds the records up, those behind surfaces left out.
void draw_rain(const RainPass& pass);

PlannedPass plan_of(const RainPass& pass);

StreakRecords read_records(const RainPass& pass);

// Three floats a drop, from the camera, of the drops that were looked at.
std::vector<float> read_centres_m(RainPass& pass, const Scene& scene, const ShadowPass& shadows,
                                  double time_s);

}  // namespace pluvia
