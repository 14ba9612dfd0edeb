// Draws a scene without its rain, as a photograph that `pluvia compose` can put rain over:
//   make_picture SCENE.toml PICTURE.png DEPTH.png
// DEPTH in millimetres, 16 bits; what is farther than 65.534 m counts as sky.
#include <cmath>
#include <cstdio>
#include <exception>

#include "atlas/atomic_file.h"
#include "atlas/gray_png.h"
#include "atlas/image_io.h"
#include "realtime/rain_renderer.h"

namespace {

std::string depth_png(const pluvia::Image& depth_m) {
  pluvia::GrayPicture picture = {depth_m.width, depth_m.height};
  for (const float along_m : depth_m.values) {
    const double millimetres = std::min(65535.0, 1e3 * static_cast<double>(along_m));
    picture.values.push_back(static_cast<std::uint16_t>(std::lround(millimetres)));
  }
  return pluvia::gray_png_bytes(picture);
}

void make_picture(const char* scene_file, const char* picture_file, const char* depth_file) {
  pluvia::Scene scene = pluvia::read_scene(scene_file);
  scene.rain = {};
  scene.splashes.reset();
  const pluvia::Frame frame = pluvia::RainRenderer(scene, {}).render(0);
  pluvia::write_png(picture_file, frame.color, scene.camera.white_cd_m2);
  pluvia::write_file_atomically(depth_file, depth_png(frame.depth_m));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("make_picture: expected SCENE.toml PICTURE.png DEPTH.png\n", stderr);
    return 2;
  }
  try {
    make_picture(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_picture: %s\n", error.what());
    return 1;
  }
  return 0;
}
