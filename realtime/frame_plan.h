// What a renderer has made for its scene: every pass, its shaders, what it keeps on the GPU.
// Derived from the objects themselves, so that an effect that a scene does not call for can be seen
// to contribute nothing.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "realtime/gl_objects.h"
#include "realtime/shader.h"

namespace pluvia {

struct PlannedResource {
  std::string name = {};
  std::size_t bytes = 0;
};

struct PlannedPass {
  std::string name = {};                        // "surfaces", "shadows", "rain", ..
  std::vector<std::string> shaders = {};        // files of realtime/shaders, each once
  std::vector<PlannedResource> resources = {};  // buffers and textures
  std::vector<std::string> notes = {};  // what of the scene it shows in a lesser way, or how

  void add(const ShaderProgram& program);
  void add(const std::string& resource, const GlBuffer& buffer);  // nothing for one never made
  void add(const std::string& resource, const GlTexture& texture);
};

struct FramePlan {
  std::vector<PlannedPass> passes = {};  // in the order of drawing
};

std::size_t bytes_of(const PlannedPass& pass);

// What a pass cost in one frame, on a steady clock around glFinish.
struct PassCost {
  std::string pass = {};
  double wall_s = 0;
  double cpu_s = 0;          // of the whole process: a software rasteriser's threads
  std::string skipped = {};  // why there was nothing to draw; empty: it was drawn
};

// As text, a line for each pass, shader and resource; and both as JSON.
std::string plan_text(const FramePlan& plan);
std::string costs_json(const FramePlan& plan, const std::vector<std::vector<PassCost>>& frames);

}  // namespace pluvia
