// Streaks as they were drawn in 2010: a yardstick, not a way to better pictures. Creus, "Real-time
// rain simulation", 2010: a geometry shader makes a textured quad of every drop, trilinear mips,
// the nearest light and two views, blended into half floats in the order of the drops. The drops,
// their places and lights are those of the rain pass.
#pragma once

#include "atlas/streak_atlas.h"
#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/shader.h"

namespace pluvia {

constexpr int most_billboard_lights = 8;  // what a geometry shader can hand on

struct BillboardPass {
  GlTexture point = {}, environment = {}, coverage = {};  // R16F arrays: a layer for each set
  GlVertexArray no_vertices = {};
  ShaderProgram program = {};

  bool empty() const { return program.id() == 0; }
};

// The pictures alone; the program comes from the rain pass. Throws std::runtime_error for a scene
// with more lights than most_billboard_lights, and for pictures that this OpenGL cannot hold.
BillboardPass make_billboard_pass(const Scene& scene, const StreakAtlas& atlas, bool environment);

void plan_billboards(const BillboardPass& pass, PlannedPass& plan);

}  // namespace pluvia
