// A frame's picture on a screen (realtime/shaders/show.frag): for a window, without a way through
// the CPU.
#pragma once

#include "realtime/gl_objects.h"
#include "realtime/shader.h"

namespace pluvia {

struct ShowPass {
  GlVertexArray no_vertices = {};
  ShaderProgram program = {};
};

ShowPass make_show_pass();

// Fills width x height px of the framebuffer (0: the window's own) with the picture; a picture of
// another size is shown larger or smaller, texel by texel. white: the radiance shown as white, > 0.
void show_picture(const ShowPass& pass, const GlTexture& picture, double white, GLuint framebuffer,
                  int width, int height);

}  // namespace pluvia
