// Shaders: the files of realtime/shaders, built into the program, so that it runs from anywhere;
// their errors still name file and line.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <epoxy/gl.h>

#include "realtime/gl_objects.h"

namespace pluvia {

using ShaderFiles = std::map<std::string, std::string>;    // name in realtime/shaders -> text
using ShaderDefines = std::map<std::string, std::string>;  // constants shared with C++

const ShaderFiles& embedded_shaders();  // written by realtime/cmake/embed_shaders.cmake

struct ShaderSource {
  std::string text = {};
  std::vector<std::string> files = {};  // by what #line says
};

// The file with every #include "NAME" replaced by that file (once each), #include NAME by the file
// that the define of that name names, #line directives that
// number the files, and the defines after #version. Throws std::runtime_error
// "realtime/shaders/NAME:LINE: ..." for a missing file.
ShaderSource flatten_shader(const std::string& name, const ShaderDefines& defines,
                            const ShaderFiles& files = embedded_shaders());

// Throws std::runtime_error "realtime/shaders/NAME:LINE: what the compiler says; expected ...".
GlShader compile_shader(GLenum stage, const ShaderSource& source);

struct ShaderProgram {
  GlProgram handle = {};
  std::vector<std::string> files = {};  // of realtime/shaders, with those they include

  GLuint id() const { return handle.id(); }
};

// Stage by the ending of the name: .vert, .geom, .frag, .comp.
ShaderProgram build_program(const std::vector<std::string>& names, const ShaderDefines& defines);

}  // namespace pluvia
