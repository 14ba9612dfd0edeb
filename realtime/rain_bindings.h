// What the shaders of rain_pass.h are told: constants, and where their buffers and textures are.
#pragma once

#include "realtime/gl_objects.h"
#include "realtime/rain_pass.h"
#include "realtime/shader.h"
#include "realtime/shadow_pass.h"

namespace pluvia {

constexpr int quads_per_instance = 1024;  // few instances: each costs a set-up, whatever it draws

// What a shader has to know of the scene's drops to read them (rain_drops.glsl), and of its lens
// (rain_lens.glsl).
ShaderDefines drop_defines(const RainPass& pass);

// Of a pass whose look, sky, drops and lens are known: those of drop_defines too.
ShaderDefines rain_defines(const RainPass& pass, bool shadows);

// Uniforms, buffers and textures of the pass; what only some of its shaders see has its own below.
void bind_rain(const RainPass& pass);

void bind_shadows(const ShadowPass& shadows);
void bind_scene_depth(const RainPass& pass);  // thin streaks
void bind_billboards(const BillboardPass& billboards);
void bind_centres(const GlBuffer& centres);

}  // namespace pluvia
