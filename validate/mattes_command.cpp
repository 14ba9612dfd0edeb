#include "validate/mattes_command.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/atomic_folder.h"
#include "atlas/clip_files.h"
#include "atlas/flag_values.h"
#include "atlas/image_io.h"
#include "atlas/json_place.h"
#include "validate/rain_strokes.h"

namespace pluvia {

CLI::App* add_mattes(CLI::App& app, MattesFlags& flags) {
  CLI::App* command = app.add_subcommand("mattes", "take the rain out of a clip");
  command
      ->add_option("video", flags.video,
                   "video, folder of pictures of one kind, or a pattern such as \"frames/*.png\"; "
                   "the camera stands still")
      ->required();
  command
      ->add_option("--out", flags.out,
                   "folder, not there yet: background, mattes, strokes, mattes.json")
      ->required();
  command->add_option("--frames", flags.frames, "the first so many, or all if there are fewer")
      ->check(CLI::Range(3, 10000))
      ->capture_default_str();
  command->add_option("--lambda", flags.settings.lambda, "weight of the background's gradients")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command->add_option("--mu", flags.settings.mu, "weight of the mattes' gradients along the fall")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command->add_option("--iterations", flags.settings.iterations, "at most")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command
      ->add_option(
          "--white", flags.settings.white,
          "light that counts as 1, for pictures of linear values; brighter light is cut to it, "
          "as a camera does")
      ->check(finite_range(1e-30, 1e30))
      ->capture_default_str();
  command->footer(
      "example (after: pluvia render data/scenes/storm.toml --atlas atlas --frames 20 --out "
      "frames):\n  pluvia mattes frames/rain.mp4 --out mattes");
  return command;
}

namespace {

using Json = nlohmann::ordered_json;

Json energy_json(const MatteEnergy& energy) {
  return {{"total", energy.total()},
          {"data", energy.data},
          {"background", energy.background},
          {"mattes", energy.mattes}};
}

Json iterations_json(const std::vector<MatteIteration>& iterations) {
  Json list = Json::array();
  for (const MatteIteration& step : iterations) {
    list.push_back({{"after_mattes", energy_json(step.mattes)},
                    {"after_direction", energy_json(step.direction)},
                    {"after_background", energy_json(step.background)},
                    {"after_colours", energy_json(step.colours)}});
  }
  return list;
}

Json strokes_json(const std::vector<RainStroke>& strokes) {
  Json list = Json::array();
  for (const RainStroke& stroke : strokes) {
    list.push_back({{"file", fmt::format("strokes/{:04}", list.size())},
                    {"frame", stroke.frame},
                    {"x_px", stroke.x_px},
                    {"y_px", stroke.y_px},
                    {"width_px", stroke.width_px},
                    {"length_px", stroke.length_px},
                    {"brightness", stroke.brightness}});
  }
  return list;
}

std::string document(const MattesFlags& flags, const RainMattes& mattes,
                     const std::vector<RainStroke>& strokes) {
  const MatteSettings& settings = flags.settings;
  Json colours = Json::array();
  const auto channels = static_cast<std::size_t>(mattes.background.channels);
  for (const auto& colour : mattes.colours)
    colours.push_back(std::vector<double>(colour.begin(), colour.begin() + channels));
  const Json json = {{"version", 1},
                     {"source", flags.video},
                     {"width_px", mattes.background.width},
                     {"height_px", mattes.background.height},
                     {"frames", mattes.mattes.size()},
                     {"settings",
                      {{"lambda", settings.lambda},
                       {"mu", settings.mu},
                       {"iterations", settings.iterations},
                       {"white", settings.white}}},
                     {"lean_deg", mattes.lean_deg},
                     {"rain_colours", colours},
                     {"energy_at_start", energy_json(mattes.start)},
                     {"iterations", iterations_json(mattes.iterations)},
                     {"strokes", strokes_json(strokes)}};
  return document_text(json, 2);
}

void cut(Image& frame, float most) {
  for (float& value : frame.values) value = std::min(value, most);
}

void write_all(const std::string& folder, const MattesFlags& flags, const RainMattes& mattes,
               const std::vector<RainStroke>& strokes) {
  make_folder(folder + "/mattes");
  make_folder(folder + "/strokes");
  write_exr(folder + "/background.exr", mattes.background);
  write_png(folder + "/background.png", mattes.background, flags.settings.white);
  for (std::size_t k = 0; k < mattes.mattes.size(); ++k)
    write_png(fmt::format("{}/mattes/{:04}.png", folder, k), mattes.mattes[k]);
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const std::string name = fmt::format("{}/strokes/{:04}", folder, i);
    write_exr(name + ".exr", strokes[i].matte);
    write_png(name + ".png", strokes[i].matte);
  }
  write_file_plainly(folder + "/mattes.json", document(flags, mattes, strokes));
}

}  // namespace

std::string find_mattes(const MattesFlags& flags,
                        const std::function<void(const std::string&, double)>& progress) {
  if (std::filesystem::exists(flags.out))  // before the minutes of work
    throw std::runtime_error(flags.out + ": is there already; expected a folder to be made");
  // Uncut, the edge of a lamp a thousand times as bright as the rain would be all of E.
  std::vector<Image> frames = read_clip(flags.video, flags.frames);
  for (Image& frame : frames) cut(frame, static_cast<float>(flags.settings.white));
  RainMattes mattes;
  try {
    mattes = rain_mattes(frames, flags.settings, progress);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(flags.video + ": " + error.what());
  }
  const std::vector<RainStroke> strokes = rain_strokes(mattes.mattes, mattes.lean_deg, {});
  build_folder_atomically(flags.out, [&](const std::string& temporary) {
    write_all(temporary, flags, mattes, strokes);
  });
  return fmt::format("{}: {} mattes, rain leans by {:.1f} degrees, {} strokes, {} iterations\n",
                     flags.out, mattes.mattes.size(), mattes.lean_deg, strokes.size(),
                     mattes.iterations.size());
}

}  // namespace pluvia
