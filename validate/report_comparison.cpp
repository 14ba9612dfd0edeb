#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/picture_planes.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

bool same_size(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height;
}

void require_comparison(const Comparison& comparison) {
  const Panel &a = comparison.picture, &b = comparison.reference;
  if (!same_size(a.image, b.image) || a.image.channels != b.image.channels || a.white != b.white) {
    throw std::runtime_error(fmt::format(
        "comparison \"{}\": {} x {} x {} with white = {} against {} x {} x {} with white = {}; "
        "expected one size and one white",
        comparison.title, a.image.width, a.image.height, a.image.channels, a.white, b.image.width,
        b.image.height, b.image.channels, b.white));
  }
  for (const Panel& map : comparison.maps) {
    if (same_size(map.image, a.image) && map.image.channels == 1) continue;
    throw std::runtime_error(
        fmt::format("comparison \"{}\", map \"{}\": {} x {} x {}; expected {} x {} x 1",
                    comparison.title, map.caption, map.image.width, map.image.height,
                    map.image.channels, a.image.width, a.image.height));
  }
  const double stops = std::log2(comparison.gain);
  if (!(stops >= 0 && stops <= 10) || stops != std::floor(stops)) {
    throw std::runtime_error(fmt::format("comparison \"{}\": gain = {}; expected 1, 2, 4 .. 1024",
                                         comparison.title, comparison.gain));
  }
}

Panel difference_panel(const Comparison& comparison) {
  const Panel &a = comparison.picture, &b = comparison.reference;
  return {.image = image_of(luminance_of(a.image) - luminance_of(b.image)),
          .white = a.white / comparison.gain,
          .caption = fmt::format("difference{}, \u00d7{}",
                                 a.image.channels == 3 ? " of luminance" : "", comparison.gain),
          .signed_difference = true};
}

// What the script knows a picture by; a picture that is there already is not put in again.
std::string layer_html(const Panel& panel, std::vector<std::string>& packed) {
  const PackedPicture picture = pack_picture(panel.image);
  std::string text = fmt::format(
      "data-width=\"{}\" data-height=\"{}\" data-channels=\"{}\" data-exponent=\"{}\">{}",
      panel.image.width, panel.image.height, panel.image.channels, picture.exponent,
      base64(picture.bytes));
  const auto found = std::find(packed.begin(), packed.end(), text);
  const bool is_new = found == packed.end();
  const auto index = found - packed.begin();
  std::string html =
      is_new
          ? fmt::format("<script type=\"text/plain\" id=\"packed-{}\" {}</script>\n", index, text)
          : "";
  if (is_new) packed.push_back(std::move(text));
  return html + fmt::format("<i data-packed=\"packed-{}\" data-white=\"{}\" title=\"{}\"></i>\n",
                            index, panel.white, html_text(panel.caption));
}

std::string layers_html(const Comparison& comparison, std::vector<std::string>& packed) {
  std::string layers = layer_html(comparison.picture, packed);
  layers += layer_html(comparison.reference, packed);
  for (const Panel& map : comparison.maps) layers += layer_html(map, packed);
  return fmt::format("<div class=\"layers\" hidden data-gain=\"{}\" data-unit=\"{}\">\n{}</div>\n",
                     comparison.gain, html_text(comparison.unit), layers);
}

}  // namespace

std::string with_room(std::string html, const std::string& name, PagePictures& pictures) {
  if (html.size() > pictures.room) {
    pictures.skipped.push_back(fmt::format(
        "{}: {:.1f} MB of pictures; the page has room for {:.1f} MB more", name,
        static_cast<double>(html.size()) / 1e6, static_cast<double>(pictures.room) / 1e6));
    return "";
  }
  pictures.room -= html.size();
  return html;
}

std::string comparison_html(const Comparison& comparison, PagePictures& pictures) {
  require_comparison(comparison);
  std::string stills = panel_html(comparison.picture) + panel_html(comparison.reference) +
                       panel_html(difference_panel(comparison));
  for (const Panel& map : comparison.maps) stills += panel_html(map);
  stills =
      with_room("<div class=\"row stills\">\n" + stills + "</div>\n", comparison.title, pictures);
  if (stills.empty()) return "";
  std::vector<std::string> packed = pictures.packed;
  const std::string layers = with_room(layers_html(comparison, packed),
                                       comparison.title + ", at other exposures", pictures);
  if (!layers.empty()) pictures.packed = std::move(packed);
  return fmt::format("<article class=\"comparison\">\n<h3>{}</h3>\n<p>{}</p>\n{}{}</article>\n",
                     html_text(comparison.title), html_text(comparison.text), stills, layers);
}

}  // namespace pluvia
