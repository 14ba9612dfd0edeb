#include "realtime/shader.h"

#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

constexpr const char* folder = "realtime/shaders/";

// File n's line i is line n lines_per_file + i of the flat text: Mesa drops the source number that
// #line may carry.
constexpr std::size_t lines_per_file = 10000;

struct Flattener {
  const ShaderFiles& files;
  const ShaderDefines& defines;
  ShaderSource source = {};
  std::set<std::string> included = {};

  void append_defines() {
    for (const auto& [name, value] : defines)
      source.text += fmt::format("#define {} {}\n", name, value);
  }

  std::string defined(const std::string& name) const {
    const auto define = defines.find(name);
    return define == defines.end() ? name : define->second;
  }

  void append(const std::string& name, const std::string& asked_at) {
    if (!included.insert(name).second) return;
    const auto file = files.find(name);
    if (file == files.end())
      throw std::runtime_error(fmt::format("{}: there is no shader \"{}\"; expected a file of {}",
                                           asked_at, name, folder));
    const auto number = source.files.size();
    source.files.push_back(folder + name);
    // #version must come first: no #line before the root file's own.
    if (number > 0) source.text += fmt::format("#line {}\n", number * lines_per_file + 1);
    append_lines(file->second, number);
  }

  void append_lines(const std::string& text, std::size_t number) {
    static const std::regex include(R"re(\s*#include\s+(?:"([^"]+)"|([A-Z_]+))\s*)re");
    std::istringstream lines(text);
    std::string line;
    for (std::size_t i = 1; std::getline(lines, line); ++i) {
      std::smatch match;
      const bool version = line.starts_with("#version");
      if (std::regex_match(line, match, include))
        append(match[1].matched ? match[1].str() : defined(match[2]),
               fmt::format("{}:{}", source.files[number], i));
      else if (version)
        source.text += line + "\n", append_defines();
      else
        source.text += line + "\n";
      if (version || !match.empty())
        source.text += fmt::format("#line {}\n", number * lines_per_file + i + 1);
    }
  }
};

// Mesa writes "SOURCE:LINE(COLUMN): error: TEXT", NVIDIA "SOURCE(LINE) : error CODE: TEXT".
std::string first_error(const std::string& log, const ShaderSource& source) {
  static const std::regex mesa(R"(\d+:(\d+)\(\d+\): error: ([^\n]*))");
  static const std::regex nvidia(R"(\d+\((\d+)\) : error ([^\n]*))");
  std::smatch match;
  if (std::regex_search(log, match, mesa) || std::regex_search(log, match, nvidia)) {
    const std::size_t line = std::stoul(match[1]), number = line / lines_per_file;
    if (number < source.files.size())
      return fmt::format("{}:{}: {}", source.files[number], line % lines_per_file, match[2].str());
  }
  return source.files.front() + ": " + log.substr(0, log.find('\n'));
}

GLenum stage_of(const std::string& name) {
  if (name.ends_with(".vert")) return GL_VERTEX_SHADER;
  if (name.ends_with(".geom")) return GL_GEOMETRY_SHADER;
  if (name.ends_with(".frag")) return GL_FRAGMENT_SHADER;
  return GL_COMPUTE_SHADER;
}

}  // namespace

ShaderSource flatten_shader(const std::string& name, const ShaderDefines& defines,
                            const ShaderFiles& files) {
  Flattener flattener{files, defines};
  flattener.append(name, folder + name);
  return std::move(flattener.source);
}

GlShader compile_shader(GLenum stage, const ShaderSource& source) {
  GlShader shader(glCreateShader(stage));
  const char* text = source.text.c_str();
  glShaderSource(shader.id(), 1, &text, nullptr);
  glCompileShader(shader.id());
  GLint compiled = 0, length = 0;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  glGetShaderiv(shader.id(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetShaderInfoLog(shader.id(), length, nullptr, log.data());
  throw std::runtime_error(first_error(log.c_str(), source) + "; expected GLSL 4.50 core");
}

ShaderProgram build_program(const std::vector<std::string>& names, const ShaderDefines& defines) {
  ShaderProgram program = {.handle = GlProgram(glCreateProgram())};
  for (const std::string& name : names) {
    const ShaderSource source = flatten_shader(name, defines);
    const GlShader shader = compile_shader(stage_of(name), source);
    glAttachShader(program.id(), shader.id());
    for (const std::string& file : source.files)
      program.files.push_back(file.substr(std::string(folder).size()));
  }
  glLinkProgram(program.id());
  GLint linked = 0, length = 0;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &linked);
  if (linked) return program;
  glGetProgramiv(program.id(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetProgramInfoLog(program.id(), length, nullptr, log.data());
  throw std::runtime_error(folder + names.front() + ": does not link: " +
                           log.substr(0, log.find('\n')) + "; expected stages that fit");
}

}  // namespace pluvia
