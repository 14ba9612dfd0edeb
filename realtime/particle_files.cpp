#include "realtime/particle_files.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace pluvia {
namespace {

constexpr const char* columns =
    "frame,time_s,id,x_m,y_m,z_m,radius_m,velocity_x_m_s,velocity_y_m_s,velocity_z_m_s,"
    "oscillation,fall_s,start_x_px,start_y_px,start_width_px,start_right_m,start_up_m,"
    "start_forward_m,end_x_px,end_y_px,end_width_px,end_right_m,end_up_m,end_forward_m,"
    "distance_m,shown_share";

using Text = std::back_insert_iterator<std::string>;

void append_triple(Text out, const Eigen::Vector3d& v) {
  fmt::format_to(out, "{},{},{},", v.x(), v.y(), v.z());
}

void append_end(Text out, const Eigen::Vector2d& px, double width_px, const Eigen::Vector3d& m) {
  fmt::format_to(out, "{},{},{},", px.x(), px.y(), width_px);
  append_triple(out, m);
}

// x right, y up, z toward the viewer.
std::string xml_place(const Eigen::Vector3d& camera_m) {
  return fmt::format("({};{};{})", camera_m.x(), camera_m.y(), -camera_m.z());
}

// From the picture's lower left corner, y up.
std::string xml_pixel(const Scene& scene, const Eigen::Vector2d& px) {
  return fmt::format("({};{})", px.x(), scene.camera.height_px - px.y());
}

}  // namespace

std::string drops_csv_head(const Scene& scene) {
  const Camera& camera = scene.camera;
  return fmt::format("# pluvia drops 1, seed {}, exposure {} s, {} x {} px, docs/compose.md\n{}\n",
                     scene.rain.seed, camera.exposure_s, camera.width_px, camera.height_px,
                     columns);
}

std::string drops_csv_rows(const FrameDrops& frame) {
  std::string text;
  const Text out = std::back_inserter(text);
  for (const ListedDrop& listed : frame.drops) {
    const Drop& drop = listed.drop;
    fmt::format_to(out, "{},{},{},", frame.frame, frame.time_s, listed.id);
    append_triple(out, drop.centre_m);
    fmt::format_to(out, "{},", drop.r0_m);
    append_triple(out, drop.velocity_m_s);
    fmt::format_to(out, "{},{},", drop.oscillation, listed.end_s);
    append_end(out, listed.start_px, listed.start_width_px, listed.start_camera_m);
    append_end(out, listed.end_px, listed.end_width_px, listed.end_camera_m);
    const double distance_m = (listed.start_camera_m + listed.end_camera_m).norm() / 2;
    fmt::format_to(out, "{},{}\n", distance_m, listed.shown_share);
  }
  return text;
}

std::string particles_xml_head() {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<simulation>\n";
}

std::string particles_xml_frame(const Scene& scene, const FrameDrops& frame) {
  std::string text;
  const Text out = std::back_inserter(text);
  fmt::format_to(out, " <frame id=\"{}\" t=\"{}\" d=\"{}\" rs=\"{}\">\n", frame.frame,
                 std::lround(1e3 * scene.camera.exposure_s), std::lround(1e3 * frame.time_s),
                 frame.drops.size());
  for (const ListedDrop& listed : frame.drops) {
    const double diameter_m = 2 * listed.drop.r0_m;
    fmt::format_to(out,
                   "  <drop pid=\"{}\" wp1=\"{}\" wp2=\"{}\" wd1=\"{}\" wd2=\"{}\" ip1=\"{}\" "
                   "ip2=\"{}\" iw1=\"{}\" iw2=\"{}\"/>\n",
                   listed.id, xml_place(listed.start_camera_m), xml_place(listed.end_camera_m),
                   diameter_m, diameter_m, xml_pixel(scene, listed.start_px),
                   xml_pixel(scene, listed.end_px), listed.start_width_px, listed.end_width_px);
  }
  return text + " </frame>\n";
}

std::string particles_xml_tail() {
  return "</simulation>\n";
}

}  // namespace pluvia
