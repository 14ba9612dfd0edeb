#include "realtime/render_command.h"

#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/flag_values.h"
#include "atlas/image_io.h"
#include "realtime/rain_look.h"
#include "realtime/video.h"

namespace pluvia {

void add_quality(CLI::App& command, QualityFlags& flags) {
  command.add_option("--lookup", flags.lookup, "cells that a streak mixes for a light: 1, 2 or 8")
      ->check(CLI::IsMember({"nearest", "view-linear", "trilinear"}))
      ->capture_default_str();
  command
      .add_option("--look", flags.look,
                  "light in a streak: as traced, as in a sphere, as published in 2006, none, or "
                  "refracted by masks")
      ->check(CLI::IsMember({"traced", "sphere", "sphere-published", "white", "refraction"}))
      ->capture_default_str();
  command.add_option("--strokes", flags.strokes,
                     "of spheres and white streaks: folder of mattes (pluvia mattes) whose strokes "
                     "are the streaks' shapes");
  command.add_option("--masks", flags.masks, "of refraction: folder of the masks (pluvia masks)");
  command
      .add_option("--persistence", flags.persistence_samples,
                  "of refraction: samples of the drop in a pixel of its streak")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  command
      .add_option("--capture", flags.capture,
                  "of refraction: the scene that drops see, all around or 165 degrees before the "
                  "camera")
      ->check(CLI::IsMember({"cube", "wide"}))
      ->capture_default_str();
  command.add_option("--capture-px", flags.capture_px, "of refraction: its sides")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command
      .add_option("--background-share", flags.background_share,
                  "of spheres: the share of the background that is added to them; default 0, "
                  "sphere-published 0.7")
      ->check(finite_range(0, 0.99));
  command
      .add_option("--streak-cd-m2", flags.streak_cd_m2,
                  "radiance of white streaks; default: the scene's white")
      ->check(finite_range(0, 1e9));
  command
      .add_option(
          "--sky-degree", flags.sky_degree,
          "spherical harmonics by which streaks see an environment map, as far as the atlas "
          "has them; 0: its mean from everywhere")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  command
      .add_option("--far-streaks", flags.far_streaks,
                  "streaks that cross a pixel within an e-fold of the distance; where there are "
                  "more, a few stand for all (1 .. 1e6); 0: every drop is drawn")
      ->check(CLI::IsMember({0}) | finite_range(1, 1e6))
      ->capture_default_str();
  command.add_option("--packets", flags.packets, "in which drops are selected; the same picture")
      ->check(CLI::IsMember({"automatic", "world", "tree", "grid"}))
      ->capture_default_str();
}

namespace {

StreakLook look_of(const QualityFlags& flags) {
  const std::map<std::string, StreakLook> looks = {
      {"traced", StreakLook::traced},
      {"sphere", StreakLook::sphere},
      {"sphere-published", StreakLook::sphere_published},
      {"white", StreakLook::white},
      {"refraction", StreakLook::refraction}};
  return looks.at(flags.look);
}

}  // namespace

RenderOptions render_options(const QualityFlags& flags) {
  const std::map<std::string, LookupMode> lookups = {{"nearest", LookupMode::nearest},
                                                     {"view-linear", LookupMode::view_linear},
                                                     {"trilinear", LookupMode::trilinear}};
  const std::map<std::string, PacketScheme> schemes = {{"automatic", PacketScheme::automatic},
                                                       {"world", PacketScheme::world},
                                                       {"tree", PacketScheme::tree},
                                                       {"grid", PacketScheme::grid}};
  return {.far_streaks = flags.far_streaks,
          .packets = {.scheme = schemes.at(flags.packets)},
          .lookup = lookups.at(flags.lookup),
          .look = look_of(flags),
          .background_share = flags.background_share,
          .streak_cd_m2 = flags.streak_cd_m2,
          .sky_degree = flags.sky_degree,
          .persistence_samples = flags.persistence_samples,
          .capture = flags.capture == "cube" ? SceneCapture::cube : SceneCapture::wide,
          .capture_px = flags.capture_px};
}

StreakAtlas read_atlas(const std::string& folder, const QualityFlags& flags) {
  if (!flags.masks.empty() && flags.look != "refraction")
    throw CLI::ValidationError("--masks", "the look has none; expected --look refraction");
  if (!flags.strokes.empty() && !takes_strokes(look_of(flags)))
    throw CLI::ValidationError(
        "--strokes", "the look takes none; expected --look sphere, sphere-published or white");
  // Before the seconds that an atlas takes to read.
  StreakStrokes strokes;
  if (!flags.strokes.empty()) strokes = read_streak_strokes(flags.strokes);
  StreakAtlas atlas = read_atlas(folder);
  if (!flags.masks.empty()) atlas.masks = read_refraction_masks(flags.masks);
  atlas.strokes = std::move(strokes);
  return atlas;
}

CLI::App* add_render(CLI::App& app, RenderFlags& flags) {
  CLI::App* command = app.add_subcommand("render", "render rain in a scene, in real time");
  command->add_option("scene", flags.scene, "scene, TOML")->required();
  command->add_option("--atlas", flags.atlas, "folder of the atlas")->required();
  command->add_option("--out", flags.out,
                      "folder of the frames: EXR, PNG, rain.mp4, costs.json (of each pass)");
  command->add_flag("--plan", flags.plan,
                    "only print the passes, shaders and bytes that the scene calls for");
  add_quality(*command, flags.quality);
  command->add_option("--frames", flags.frames, "number of frames")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option("--frames-per-s", flags.frames_per_s, "frame rate")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--start-s", flags.start_s, "time of the first frame")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command->footer("example: pluvia render data/scenes/street.toml --atlas atlas --out frames");
  return command;
}

namespace {

std::string frame_name(const RenderFlags& flags, int k) {
  return fmt::format("{}/frame_{:04d}", flags.out, k);
}

// Whether a video can stand beside the frames: libx264 in its common format takes even sizes only.
bool has_video(const RenderFlags& flags, const Camera& camera) {
  const bool even = camera.width_px % 2 == 0 && camera.height_px % 2 == 0;
  return flags.frames > 1 && even && ffmpeg_is_present();
}

// What an earlier run has left of frames that this one has not, and its video where there is none.
void remove_what_is_left(const RenderFlags& flags, bool has_video) {
  for (int k = flags.frames;; ++k) {
    const std::string name = frame_name(flags, k);
    const bool exr = std::filesystem::remove(name + ".exr");
    const bool png = std::filesystem::remove(name + ".png");
    if (!exr && !png) break;
  }
  if (!has_video) std::filesystem::remove(flags.out + "/rain.mp4");
}

std::string mean_costs(const std::vector<std::vector<PassCost>>& costs) {
  std::string text;
  for (std::size_t i = 0; i < costs.front().size(); ++i) {
    double seconds = 0;
    for (const auto& frame : costs) seconds += frame[i].wall_s / static_cast<double>(costs.size());
    text += fmt::format(", {} {:.0f} ms", costs.front()[i].pass, 1e3 * seconds);
  }
  return text;
}

}  // namespace

std::string render_frames(const RenderFlags& flags,
                          const std::function<void(const std::string&, double)>& progress) {
  const Scene scene = read_scene(flags.scene);
  RainRenderer renderer(scene, read_atlas(flags.atlas, flags.quality),
                        render_options(flags.quality));
  if (flags.plan) return plan_text(renderer.plan());
  if (flags.out.empty()) throw CLI::ValidationError("--out", "is required without --plan");
  make_folder(flags.out);
  // Written last: a folder without it is not of one run.
  std::filesystem::remove(flags.out + "/costs.json");
  std::optional<VideoWriter> video;
  if (has_video(flags, scene.camera))
    video.emplace(flags.out + "/rain.mp4", scene.camera.width_px, scene.camera.height_px,
                  flags.frames_per_s);
  std::vector<std::vector<PassCost>> costs;
  for (int k = 0; k < flags.frames; ++k) {
    const Frame frame =
        renderer.render(flags.start_s + static_cast<double>(k) / flags.frames_per_s);
    costs.push_back(frame.costs);
    const std::string name = frame_name(flags, k);
    write_exr(name + ".exr", frame.color);
    write_png(name + ".png", frame.color, scene.camera.white_cd_m2);
    if (video) video->add(frame.color, scene.camera.white_cd_m2);
    progress(name, static_cast<double>(k + 1) / flags.frames);
  }
  if (video) video->finish();
  remove_what_is_left(flags, video.has_value());
  write_file_atomically(flags.out + "/costs.json", costs_json(renderer.plan(), costs));
  std::string text =
      fmt::format("{}: {} frames{}{} a frame on {}\n", flags.out, flags.frames,
                  video ? " and rain.mp4" : "", mean_costs(costs), renderer.gl_info().renderer);
  for (const PlannedPass& pass : renderer.plan().passes) {
    for (const std::string& note : pass.notes)
      text += fmt::format("{}: {}: {}\n", flags.out, pass.name, note);
  }
  return text;
}

}  // namespace pluvia
