#include "realtime/viewer/view_command.h"

#include "atlas/flag_values.h"

namespace pluvia {

CLI::App* add_view(CLI::App& app, ViewFlags& flags) {
  CLI::App* command = app.add_subcommand("view", "fly through rain in a scene, in a window");
  command->add_option("scene", flags.scene, "scene, TOML")->required();
  command->add_option("--atlas", flags.atlas, "folder of the atlas")->required();
  command->add_option("--out", flags.options.out_folder, "folder of screenshots and camera paths")
      ->capture_default_str();
  command->add_option("--width-px", flags.width_px, "of the window")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command->add_option("--height-px", flags.height_px, "of the window")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command
      ->add_option("--pixel-px", flags.options.pixel_px,
                   "of the window, along a side of the picture's pixel: more is faster")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  add_quality(*command, flags.quality);
  command->add_option("--start-s", flags.options.start_s, "time of the first frame")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--frames", flags.options.frames,
                   "draw so many, 1/24 s apart, leave pictures of the last and of the window in "
                   "--out, and close; 0: until the window is closed")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->footer("example: pluvia view data/scenes/street.toml --atlas atlas");
  return command;
}

void view_scene(const ViewFlags& flags) {
  const Scene scene = read_scene(flags.scene);
  // Before the seconds that an atlas takes to read.
  Window window("Pluvia: " + flags.scene, {flags.width_px, flags.height_px});
  ViewOptions options = flags.options;
  options.render = render_options(flags.quality);
  view(window, scene, read_atlas(flags.atlas, flags.quality), options);
}

}  // namespace pluvia
