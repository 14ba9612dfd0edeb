#include "realtime/compose_command.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/atomic_folder.h"
#include "atlas/flag_values.h"
#include "atlas/image_io.h"
#include "atlas/json_place.h"
#include "raytrace/streak_geometry.h"
#include "realtime/background_clip.h"
#include "realtime/frame_layers.h"
#include "realtime/particle_files.h"
#include "realtime/video.h"

namespace pluvia {
namespace {

using Json = nlohmann::ordered_json;
using Progress = std::function<void(const std::string&, double)>;

void check_flags(const ComposeFlags& flags) {
  if (flags.image.empty() == flags.video.empty())
    throw CLI::ValidationError("--image, --video", "expected one of them");
  if (flags.quality.far_streaks > 0)
    throw CLI::ValidationError(
        "--far-streaks", "a few streaks would stand for all; expected 0, as drops are listed");
  if (flags.out.empty() && !flags.plan)
    throw CLI::ValidationError("--out", "is required without --plan");
}

BackgroundFiles background_files(const ComposeFlags& flags) {
  const bool still = flags.video.empty();
  return {.pictures = still ? flags.image : flags.video,
          .still = still,
          .depths = flags.depth,
          .depth_scale_m = flags.depth_scale_m,
          .one_cd_m2 = flags.one_cd_m2};
}

// A run, and what it has made so far.
struct Run {
  const ComposeFlags& flags;
  std::string scene_sha256;  // of the file as it was read
  Scene scene;               // without its surfaces: drops have the renderer's
  const StreakAtlas& atlas;
  RainRenderer& renderer;
  DropNumbers numbers = {};
  Json frames = Json::array();
};

// The files of drops of all frames.
struct DropFiles {
  std::string csv_file = {}, xml_file = {};
  std::ofstream csv = {}, xml = {};
};

DropFiles open_drop_files(const std::string& folder) {
  DropFiles files = {folder + "/drops.csv", folder + "/camera0.xml"};
  files.csv.open(files.csv_file, std::ios::binary);
  files.xml.open(files.xml_file, std::ios::binary);
  return files;
}

void append(DropFiles& files, const std::string& csv_text, const std::string& xml_text) {
  if (!(files.csv << csv_text << std::flush))
    throw std::runtime_error(files.csv_file + ": cannot write; expected room for it");
  if (!(files.xml << xml_text << std::flush))
    throw std::runtime_error(files.xml_file + ": cannot write; expected room for it");
}

void write_layers(const std::string& folder, int k, const FrameLayers& layers, double white,
                  double mask_coverage) {
  const auto file = [&](const char* layer, const char* kind) {
    return fmt::format("{}/{}/{:04}.{}", folder, layer, k, kind);
  };
  write_exr(file("composite", "exr"), layers.color);
  write_png(file("composite", "png"), layers.color, white);
  write_exr(file("background", "exr"), layers.background);
  write_exr(file("rain", "exr"), layers.rain);
  write_exr(file("coverage", "exr"), layers.coverage);
  write_png(file("mask", "png"), rain_mask(layers.coverage, mask_coverage));
}

// Returns how many drops are listed.
std::size_t list_frame(Run& run, DropFiles& files, int k, double time_s, const Image& depth_m) {
  if (!run.renderer.rain_packets()) return 0;  // no drop
  Scene scene = run.scene;
  scene.camera = camera_at(run.scene, time_s);
  const auto sets = static_cast<int>(run.atlas.layers.size());
  auto drops = run.renderer.drops(sets, time_s);
  number_sets(set_numbers(run.atlas), drops);
  const FrameDrops listed = {
      k, time_s, list_drops(scene, streak_geometry(run.atlas), drops, depth_m, run.numbers)};
  append(files, drops_csv_rows(listed), particles_xml_frame(scene, listed));
  return listed.drops.size();
}

Json skipped_passes(const std::vector<PassCost>& costs) {
  Json skipped = Json::object();
  for (const PassCost& cost : costs) {
    if (!cost.skipped.empty()) skipped[cost.pass] = cost.skipped;
  }
  return skipped;
}

void compose_frame(Run& run, const std::string& folder, int k, const Picture& picture,
                   DropFiles& files, std::optional<VideoWriter>& video) {
  const double time_s = run.flags.start_s + static_cast<double>(k) / run.flags.frames_per_s;
  run.renderer.show(picture);
  Frame frame = run.renderer.render(time_s);
  Json entry = {{"frame", k},
                {"time_s", time_s},
                {"streaks_in_view", frame.streaks_in_view},
                {"splash_strokes", frame.splash_strokes},
                {"skipped", skipped_passes(frame.costs)}};
  const FrameLayers layers = frame_layers(std::move(frame));
  const double white = run.scene.camera.white_cd_m2;
  write_layers(folder, k, layers, white, run.flags.mask_coverage);
  if (video) video->add(layers.color, white);
  entry["drops_listed"] = list_frame(run, files, k, time_s, picture.depth_m);
  run.frames.push_back(entry);
}

Json camera_json(const Camera& camera) {
  const auto triple = [](const Eigen::Vector3d& v) {
    return std::vector<double>{v.x(), v.y(), v.z()};
  };
  return {{"position_m", triple(camera.position_m)},
          {"target_m", triple(camera.target_m)},
          {"vertical_fov_deg", camera.vertical_fov_deg},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"exposure_s", camera.exposure_s},
          {"white_cd_m2", camera.white_cd_m2}};
}

Json settings_json(const ComposeFlags& flags) {
  const QualityFlags& quality = flags.quality;
  Json json = {{"look", quality.look},
               {"lookup", quality.lookup},
               {"packets", quality.packets},
               {"sky_degree", quality.sky_degree},
               {"mask_coverage", flags.mask_coverage},
               {"frames_per_s", flags.frames_per_s},
               {"start_s", flags.start_s}};
  if (quality.background_share) json["background_share"] = *quality.background_share;
  if (quality.streak_cd_m2) json["streak_cd_m2"] = *quality.streak_cd_m2;
  if (!quality.strokes.empty()) json["strokes"] = quality.strokes;
  if (!quality.masks.empty()) {
    json["masks"] = quality.masks;
    json["persistence"] = quality.persistence_samples;
    json["capture"] = quality.capture;
    json["capture_px"] = quality.capture_px;
  }
  if (flags.one_cd_m2) json["one_cd_m2"] = *flags.one_cd_m2;
  if (flags.depth_scale_m > 0) json["depth_scale_m"] = flags.depth_scale_m;
  return json;
}

std::string document(const Run& run) {
  const ComposeFlags& flags = run.flags;
  Json passes = Json::array(), notes = Json::array();
  for (const PlannedPass& pass : run.renderer.plan().passes) {
    passes.push_back(pass.name);
    for (const std::string& note : pass.notes) notes.push_back(pass.name + ": " + note);
  }
  const Json json = {{"version", 1},
                     {"pluvia", PLUVIA_VERSION},
                     {"scene", flags.scene},
                     {"scene_sha256", run.scene_sha256},
                     {"picture", flags.image.empty() ? flags.video : flags.image},
                     {"depth", flags.depth},
                     {"database_sha256", run.atlas.database_sha256},
                     {"seed", run.scene.rain.seed},
                     {"layers", "composite = (1 - coverage) background + rain"},
                     {"camera", camera_json(run.scene.camera)},
                     {"settings", settings_json(flags)},
                     {"passes", passes},
                     {"notes", notes},
                     {"frames", run.frames}};
  return document_text(json, 1);
}

// libx264 in its common format takes even sizes only.
bool has_video(int most_frames, const Camera& camera) {
  return most_frames > 1 && camera.width_px % 2 == 0 && camera.height_px % 2 == 0 &&
         ffmpeg_is_present();
}

void compose_all(Run& run, BackgroundClip& background, const std::string& folder,
                 const Progress& progress) {
  for (const char* layer : {"composite", "background", "rain", "coverage", "mask"})
    make_folder(folder + "/" + layer);
  const bool still = run.flags.video.empty();
  const int most = run.flags.frames.value_or(still ? 1 : std::numeric_limits<int>::max());
  const Camera& camera = run.scene.camera;
  std::optional<VideoWriter> video;
  if (has_video(most, camera))
    video.emplace(folder + "/rain.mp4", camera.width_px, camera.height_px, run.flags.frames_per_s);
  DropFiles files = open_drop_files(folder);
  append(files, drops_csv_head(run.scene), particles_xml_head());
  int k = 0;
  for (; k < most && (k == 0 || background.next()); ++k) {
    compose_frame(run, folder, k, background.picture(), files, video);
    progress(fmt::format("frame {:04}", k), run.flags.frames ? (k + 1.0) / most : 0);
  }
  if (run.flags.frames && k < *run.flags.frames && !still)
    throw std::runtime_error(fmt::format("{}: {} frames; expected {}, as --frames says",
                                         run.flags.video, k, *run.flags.frames));
  if (video) video->finish();
  append(files, "", particles_xml_tail());
  write_file_plainly(folder + "/compose.json", document(run));
}

}  // namespace

CLI::App* add_compose(CLI::App& app, ComposeFlags& flags) {
  CLI::App* command = app.add_subcommand("compose", "put rain over a photograph or a video");
  command
      ->add_option("scene", flags.scene,
                   "scene, TOML: camera, lights, environment, rain; its "
                   "surfaces are not drawn")
      ->required();
  command->add_option("--image", flags.image, "photograph: PNG, JPEG, EXR, HDR");
  command->add_option("--video", flags.video,
                      "video, folder of pictures, or a pattern such as \"frames/*.png\"");
  command
      ->add_option("--depth", flags.depth,
                   "along the camera's axis: EXR in m, or PNG of 16 bits; of a video one, or a "
                   "folder or pattern of one for each frame")
      ->required();
  command->add_option("--depth-scale-m", flags.depth_scale_m, "metres of 1 in a PNG of depths")
      ->check(finite_range(1e-9, 1e3));
  command
      ->add_option("--one-cd-m2", flags.one_cd_m2,
                   "radiance of 1 in the picture; default: the scene's white for whole numbers, 1 "
                   "for floats")
      ->check(finite_range(1e-9, 1e10));
  command->add_option("--atlas", flags.atlas, "folder of the atlas")->required();
  command->add_option("--out", flags.out,
                      "folder, not there yet: composite, layers, mask, drops, compose.json");
  command->add_flag("--plan", flags.plan,
                    "only print the passes, shaders and bytes that the scene calls for");
  add_quality(*command, flags.quality);
  command->add_option("--mask-coverage", flags.mask_coverage, "least coverage that the mask shows")
      ->check(finite_range(1e-6, 1))
      ->capture_default_str();
  command->add_option("--frames", flags.frames, "number of frames; default: 1, or the video's")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--frames-per-s", flags.frames_per_s, "frame rate")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--start-s", flags.start_s, "time of the first frame")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command->footer(
      "example: pluvia compose data/scenes/picture.toml --image data/pictures/street.png "
      "--depth data/pictures/street_depth.png --depth-scale-m 0.001 --atlas atlas --out rain");
  return command;
}

std::string compose_frames(const ComposeFlags& flags, const Progress& progress) {
  check_flags(flags);
  if (!flags.plan && std::filesystem::exists(flags.out))
    throw std::runtime_error(flags.out + ": is there already; expected a folder to be made");
  const std::string scene_sha256 = sha256(read_file(flags.scene));
  Scene scene = read_scene(flags.scene);
  BackgroundClip background(background_files(flags), scene.camera, flags.scene);
  if (!background.next())
    throw std::runtime_error(flags.video + ": has no frame; expected one or more");
  const StreakAtlas atlas = read_atlas(flags.atlas, flags.quality);
  RenderOptions options = render_options(flags.quality);
  options.over_picture = true;
  RainRenderer renderer(scene, atlas, options);
  if (flags.plan) return plan_text(renderer.plan());
  scene.mesh = {};
  scene.moving.clear();
  Run run = {.flags = flags,
             .scene_sha256 = scene_sha256,
             .scene = std::move(scene),
             .atlas = atlas,
             .renderer = renderer};
  build_folder_atomically(flags.out, [&](const std::string& temporary) {
    compose_all(run, background, temporary, progress);
  });
  return fmt::format("{}: {} frames, {} drops, on {}\n", flags.out, run.frames.size(),
                     run.numbers.size(), renderer.gl_info().renderer);
}

}  // namespace pluvia
