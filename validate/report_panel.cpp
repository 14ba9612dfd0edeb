#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/image_io.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

void require_panel(const Panel& panel) {
  const Image& image = panel.image;
  const auto size = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                    static_cast<std::size_t>(image.channels);
  const bool channels_fit =
      image.channels == 1 || (image.channels == 3 && !panel.signed_difference);
  if (image.width < 1 || image.height < 1 || !channels_fit || image.values.size() != size) {
    throw std::runtime_error(fmt::format(
        "panel \"{}\": {} x {} pixels, {} channels, {} values; expected at least one pixel, 1 or 3 "
        "channels (1 for a signed difference) and all their values",
        panel.caption, image.width, image.height, image.channels, image.values.size()));
  }
  if (!(panel.white > 0) || !std::isfinite(panel.white) || panel.zoom < 1) {
    throw std::runtime_error(
        fmt::format("panel \"{}\": white = {}, zoom = {}; expected white > 0 and zoom >= 1",
                    panel.caption, panel.white, panel.zoom));
  }
}

// What a viewer sees: a signed picture in two colours, and magenta where there is no number.
struct Shown {
  Image image = {};
  long not_finite = 0;
};

Shown shown_picture(const Panel& panel) {
  const Image& from = panel.image;
  const auto white = static_cast<float>(panel.white);
  Shown shown{make_image(from.width, from.height, 3)};
  for (int y = 0; y < from.height; ++y) {
    for (int x = 0; x < from.width; ++x) {
      float rgb[3];
      bool finite = true;
      for (int c = 0; c < 3; ++c) {
        rgb[c] = from.at(x, y, from.channels == 3 ? c : 0);
        finite = finite && std::isfinite(rgb[c]);
      }
      if (panel.signed_difference) {
        rgb[2] = std::fmax(-rgb[0], 0.0f);
        rgb[0] = std::fmax(rgb[0], 0.0f);
        rgb[1] = 0;
      }
      const float magenta[3] = {white, 0, white};
      for (int c = 0; c < 3; ++c) shown.image.at(x, y, c) = finite ? rgb[c] : magenta[c];
      shown.not_finite += finite ? 0 : 1;
    }
  }
  return shown;
}

}  // namespace

std::string panel_html(const Panel& panel) {
  require_panel(panel);
  const Shown shown = shown_picture(panel);
  std::string range = panel.signed_difference
                          ? fmt::format("red +{0}, blue \u2212{0}", number_text(panel.white))
                          : fmt::format("white = {}", number_text(panel.white));
  if (panel.zoom > 1) range += fmt::format(", \u00d7{}", panel.zoom);
  if (shown.not_finite > 0) {
    range += fmt::format(", {} pixels not finite (magenta)", shown.not_finite);
  }
  return fmt::format(
      "<figure class=\"panel{6}\"><figcaption>{0} <small>{1}</small></figcaption>"
      "<img alt=\"{0}\" width=\"{2}\" height=\"{3}\"{4} "
      "src=\"data:image/png;base64,{5}\"></figure>\n",
      html_text(panel.caption), range, panel.image.width * panel.zoom,
      panel.image.height * panel.zoom, panel.zoom > 1 ? " class=\"pixels\"" : "",
      base64(png_bytes(shown.image, panel.white)),
      panel.image.width * panel.zoom >= 200 ? " wide" : "");
}

}  // namespace pluvia
