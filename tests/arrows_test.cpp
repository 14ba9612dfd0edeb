// Who may use whom. The folders of the program form layers; an arrow that points upward makes the
// renderer depend on the tracer that is to judge it. Read from the sources, not from a build.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pluvia {
namespace {

using Names = std::set<std::string>;

// A module is a folder, except that the scene and its drops and the light of the sky are modules of
// their own inside raytrace/, the fits of oscillations one inside oscillation/ (a drop needs no
// Ceres), and the viewer one inside realtime/ (a frame needs no window).
const std::map<std::string, Names> allowed = {
    {"oscillation", {}},
    {"fit", {"oscillation"}},
    {"atlas", {}},
    {"scene", {"oscillation"}},
    {"sky", {"atlas", "scene"}},
    {"raytrace", {"oscillation", "atlas", "scene", "sky"}},
    {"realtime", {"oscillation", "atlas", "scene", "sky"}},
    {"viewer", {"oscillation", "atlas", "scene", "sky", "realtime"}},
    {"validate", {"oscillation", "fit", "atlas", "scene", "sky", "raytrace", "realtime"}},
    {"program",
     {"oscillation", "fit", "atlas", "scene", "sky", "raytrace", "realtime", "viewer", "validate"}},
    {"tests",
     {"oscillation", "fit", "atlas", "scene", "sky", "raytrace", "realtime", "viewer", "validate",
      "tests"}}};

// Libraries that only some modules may see: {what an include or a target looks like, who may use
// it}.
const std::vector<std::pair<std::regex, Names>> fenced = {
    {std::regex("^embree.*"), {"raytrace", "validate", "tests"}},
    {std::regex("^(epoxy|EGL|GL|GLES.|KHR)/.*|.*::epoxy$|^(epoxy|OpenGL::.*)$"),
     {"realtime", "viewer", "tests"}},
    {std::regex("^(GLFW|backends)/.*|^imgui.*|.*::(glfw|imgui)$"), {"viewer", "tests"}},
    {std::regex("^glm.*"), {"realtime", "tests"}},
    {std::regex("^(OpenEXR/|OpenImageIO/|Imf|OpenEXR::|OpenImageIO::).*"),
     {"atlas", "validate", "tests"}},
    {std::regex("^(tiny_gltf|TinyGLTF).*"), {"scene", "tests"}},
    {std::regex("^([Cc]eres).*"), {"fit", "validate", "tests"}}};

std::string contents(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// The files of a target, by the name before the dot: those that its CMake file lists.
Names read_target_files(const std::string& folder, const std::string& target) {
  const std::string text = contents(PLUVIA_SOURCE_DIR "/" + folder + "/CMakeLists.txt");
  const std::regex list("add_library\\s*\\(\\s*" + target + "\\s+STATIC\\s+([^)]*)\\)");
  std::smatch match;
  std::regex_search(text, match, list);
  std::istringstream words(match[1].str());
  Names names;
  for (std::string word; words >> word;) names.insert(std::filesystem::path(word).stem().string());
  return names;
}

// The module of a path such as "raytrace/scene.h"; empty for one that is none of ours.
std::string module_of(const std::filesystem::path& path) {
  const std::string folder = path.begin()->string();
  if (path.generic_string().rfind("realtime/viewer/", 0) == 0) return "viewer";
  if (path == "pluvia.cpp") return "program";
  static const Names scene_files = read_target_files("raytrace", "pluvia_scene");
  static const Names sky_files = read_target_files("raytrace", "pluvia_sky");
  static const Names fit_files = read_target_files("oscillation", "pluvia_fit");
  if (folder == "raytrace" && scene_files.count(path.stem().string()) > 0) return "scene";
  if (folder == "raytrace" && sky_files.count(path.stem().string()) > 0) return "sky";
  if (folder == "oscillation" && fit_files.count(path.stem().string()) > 0) return "fit";
  return allowed.count(folder) > 0 ? folder : "";
}

// Why `module` may not use `used` ("atlas/image.h", "embree3/rtcore.h", "glm::glm"); empty: it may.
std::string objection(const std::string& module, const std::string& used) {
  const std::string other = module_of(used);
  if (!other.empty()) {
    const bool fits = other == module || allowed.at(module).count(other) > 0;
    return fits ? "" : fmt::format("{} may not use {}", module, other);
  }
  for (const auto& [pattern, users] : fenced) {
    if (std::regex_match(used, pattern) && users.count(module) == 0) {
      return fmt::format("{} may not use {}", module, used);
    }
  }
  return "";
}

std::vector<std::string> include_objections(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  const std::regex include("\\s*#\\s*include\\s*([<\"])([^>\"]+)[>\"].*");
  std::smatch match;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!std::regex_match(line, match, include)) continue;
    const std::string used = match[2];
    std::string why = objection(module_of(file), used);
    // Full paths from the root: "image.h" would escape the look at the folder.
    if (match[1] == "\"" && used.find('/') == std::string::npos) why = "a path without its folder";
    if (!why.empty()) found.push_back(fmt::format("{}:{}: {}: {}", file, number, used, why));
  }
  return found;
}

// Targets of the build by module: pluvia_scene is the module scene, pluvia_sky the module sky,
// pluvia_fit the module fit, pluvia the program.
std::string target_path(const std::string& target) {
  if (target == "pluvia") return "pluvia.cpp";
  if (target == "pluvia_scene") return "raytrace/scene.h";
  if (target == "pluvia_viewer") return "realtime/viewer/.";
  if (target == "pluvia_sky") return "raytrace/sky_light.h";
  if (target == "pluvia_fit") return "oscillation/outline_fit.h";
  return target.rfind("pluvia_", 0) == 0 ? target.substr(7) + "/." : target;
}

std::vector<std::string> link_objections(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  const std::regex call("target_link_libraries\\s*\\(([^)]*)\\)"), comment("#[^\n]*");
  const std::string code = std::regex_replace(text, comment, "");
  for (std::sregex_iterator i(code.begin(), code.end(), call), end; i != end; ++i) {
    std::istringstream words((*i)[1].str());
    std::string target;
    words >> target;
    // In tests/ the target is a variable.
    const std::string module =
        file == "tests/CMakeLists.txt" ? "tests" : module_of(target_path(target));
    for (std::string word; words >> word;) {
      const std::string why = module.empty() ? "" : objection(module, target_path(word));
      if (!why.empty()) found.push_back(fmt::format("{}: {}: {}", file, word, why));
    }
  }
  return found;
}

bool is_source(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".h" || extension == ".cpp" || extension == ".in";
}

std::string joined(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

TEST(Arrows, NoSourceIncludesAgainstThem) {
  const std::filesystem::path root(PLUVIA_SOURCE_DIR);
  std::vector<std::string> found;
  Names seen;
  for (const char* folder :
       {"oscillation", "atlas", "raytrace", "realtime", "validate", "tests", "pluvia.cpp"}) {
    std::vector<std::filesystem::path> files = {root / folder};
    if (std::filesystem::is_directory(root / folder)) {
      const std::filesystem::recursive_directory_iterator tree(root / folder);
      files.assign(begin(tree), end(tree));
    }
    for (const auto& file : files) {
      if (!is_source(file) || !std::filesystem::is_regular_file(file)) continue;
      const std::string name = file.lexically_relative(root).generic_string();
      seen.insert(module_of(name));
      const auto objections = include_objections(name, contents(file));
      found.insert(found.end(), objections.begin(), objections.end());
    }
  }
  EXPECT_TRUE(found.empty()) << joined(found);
  for (const auto& [module, others] : allowed) EXPECT_EQ(seen.count(module), 1u) << module;
}

// Two types of one name are one to the linker, which keeps the templates of either.
TEST(Arrows, NoTypeOfAHeaderHasTheNameOfAnother) {
  const std::filesystem::path root(PLUVIA_SOURCE_DIR);
  const std::regex type("(^|\n)(struct|class|enum class) ([A-Z][A-Za-z0-9]*)[^;\n]*\\{");
  std::map<std::string, std::string> homes;
  for (const char* folder : {"oscillation", "atlas", "raytrace", "realtime", "validate"}) {
    for (const auto& file : std::filesystem::recursive_directory_iterator(root / folder)) {
      if (file.path().extension() != ".h") continue;
      const std::string text = contents(file.path());
      const std::string name = file.path().lexically_relative(root).generic_string();
      for (std::sregex_iterator i(text.begin(), text.end(), type), end; i != end; ++i) {
        const auto [home, is_new] = homes.emplace((*i)[3].str(), name);
        EXPECT_TRUE(is_new) << (*i)[3] << " is in " << home->second << " and in " << name;
      }
    }
  }
  EXPECT_GT(homes.size(), 200u);
}

TEST(Arrows, NoTargetLinksAgainstThem) {
  const std::filesystem::path root(PLUVIA_SOURCE_DIR);
  std::vector<std::string> found;
  for (const char* folder : {".", "oscillation", "atlas", "raytrace", "realtime", "realtime/viewer",
                             "validate", "tests"}) {
    const auto file = (std::filesystem::path(folder) / "CMakeLists.txt").lexically_normal();
    const std::string text = contents(root / file);
    EXPECT_NE(text.find("target_link_libraries"), std::string::npos) << file;
    const auto objections = link_objections(file.generic_string(), text);
    found.insert(found.end(), objections.begin(), objections.end());
  }
  EXPECT_TRUE(found.empty()) << joined(found);
}

TEST(Arrows, AWrongArrowIsFound) {
  const auto include = [](const char* file, const char* line) {
    return joined(include_objections(file, line));
  };
  EXPECT_EQ(include("realtime/a.cpp", "#include \"raytrace/scene.h\"\n#include <vector>"), "");
  EXPECT_EQ(include("realtime/a.cpp", "\n#include \"raytrace/optics.h\""),
            "realtime/a.cpp:2: raytrace/optics.h: realtime may not use raytrace");
  EXPECT_EQ(include("realtime/a.cpp", "#include \"raytrace/sky_light.h\""), "");
  EXPECT_NE(include("raytrace/sky_light.cpp", "#include \"raytrace/optics.h\""), "");
  EXPECT_NE(include("raytrace/scene.cpp", "# include <embree3/rtcore.h>"), "");
  EXPECT_EQ(include("raytrace/tracer.cpp", "#include <embree3/rtcore.h>"), "");
  EXPECT_NE(include("raytrace/scene.h", "#include \"raytrace/optics.h\""), "");
  EXPECT_NE(include("atlas/image.h", "#include \"oscillation/drop_shape.h\""), "");
  EXPECT_NE(include("atlas/image.cpp", "#include <glm/glm.hpp>"), "");
  EXPECT_NE(include("oscillation/outline_fit.cpp", "#include \"atlas/image.h\""), "");
  EXPECT_EQ(include("oscillation/outline_fit.cpp", "#include <ceres/ceres.h>"), "");
  EXPECT_NE(include("oscillation/drop_shape.cpp", "#include <ceres/ceres.h>"), "");
  EXPECT_NE(include("raytrace/tracer.cpp", "#include \"validate/check.h\""), "");
  EXPECT_NE(include("validate/report.cpp", "#include <epoxy/gl.h>"), "");
  EXPECT_NE(include("atlas/image_io.cpp", "#include \"image.h\""), "");
  EXPECT_NE(include("realtime/a.cpp", "#include \"realtime/viewer/viewer.h\""), "");
  EXPECT_EQ(include("realtime/viewer/a.cpp", "#include \"realtime/rain_renderer.h\""), "");
  EXPECT_NE(include("realtime/a.cpp", "#include <GLFW/glfw3.h>"), "");
  EXPECT_EQ(include("realtime/viewer/window.cpp", "#include <GLFW/glfw3.h>"), "");
  const auto link = [](const char* text) { return joined(link_objections("a", text)); };
  EXPECT_EQ(link("target_link_libraries(pluvia_realtime PRIVATE pluvia_scene glm::glm)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_realtime\n  PRIVATE pluvia_raytrace)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_scene PUBLIC embree)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_atlas PUBLIC pluvia_oscillation)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_atlas PUBLIC pluvia_fit)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_fit PUBLIC pluvia_atlas)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_oscillation PUBLIC Ceres::ceres)"), "");
  EXPECT_EQ(link("target_link_libraries(pluvia_fit PUBLIC pluvia_oscillation Ceres::ceres)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_raytrace PRIVATE PkgConfig::epoxy)"), "");
  EXPECT_EQ(link("target_link_libraries(pluvia_viewer PRIVATE PkgConfig::glfw)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_realtime PRIVATE PkgConfig::glfw)"), "");
  EXPECT_NE(link("target_link_libraries(pluvia_realtime PUBLIC pluvia_viewer)"), "");
}

}  // namespace
}  // namespace pluvia
