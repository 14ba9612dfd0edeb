// Splashes of the rain (raytrace/splash.h, raytrace/splash_space.h): one stroke for each droplet or
// bead of a crown and step of its path, added to what the rain pass adds up. Made only for a scene
// with [splashes].
//
// Light: a droplet is a sphere of water, E P toward the camera from every light
// (raytrace/droplet_light.h) and the mean of the environment; it hides what it covers. Far droplets
// of a splash are drawn as fewer, with the same area together, each at most 0.005 of a pixel: cost
// is linear in what splashes cover, and nothing is left out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raytrace/splash_space.h"
#include "realtime/rain_pass.h"
#include "realtime/splash_inputs.h"
#include "realtime/stroke_record.h"

namespace pluvia {

struct SplashPass {
  const RainSpace* space = nullptr;  // the renderer's
  SplashSpace splashes = {};
  RainUniforms rain = {};  // the rain pass's, without its box
  SplashUniforms values = {};
  std::vector<GpuRainSize> sizes = {};
  std::vector<GpuDropGroup> groups = {};
  std::vector<GpuSplashSize> splash_sizes = {};  // of the rain's sizes
  std::vector<GpuSplashSize> slab_sizes = {};    // of slabs and single drops, as `sizes`
  std::size_t strokes_in_view = 0;
  std::size_t capacity = 0, group_capacity = 0, size_capacity = 0, slab_capacity = 0;
  GlBuffer rain_uniforms = {}, uniforms = {}, size_buffer = {}, splash_size_buffer = {};
  GlBuffer group_buffer = {}, group_starts = {}, hits = {}, strokes = {}, parts = {}, phase = {};
  GlVertexArray no_vertices = {};
  ShaderProgram count = {}, place = {}, draw = {};
};

SplashPass make_splash_pass(const Scene& scene, const RainSpace& space, const RainPass& rain,
                            const ShadowPass& shadows);

// Fills the records for scene.camera as it is now, after place_rain. Throws std::runtime_error when
// the strokes do not fit this OpenGL.
void place_splashes(SplashPass& pass, const Scene& scene, const RainPass& rain,
                    const ShadowPass& shadows, double time_s);

// Adds them to the rain's sums, after draw_rain. Why there is nothing to draw; empty: it was drawn.
std::string draw_splashes(const SplashPass& pass, const RainPass& rain);

PlannedPass plan_of(const SplashPass& pass);

std::vector<StrokeRecord> read_strokes(const SplashPass& pass);

}  // namespace pluvia
