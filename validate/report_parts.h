// The parts that write_report (validate/report.h) is made of.
#pragma once

#include <string>
#include <string_view>

#include "validate/report.h"

namespace pluvia {

// The text of report.json.
std::string report_json(const Report& report);

// The text of index.html; `folder` is where it will lie: the video is shown when it is there.
std::string report_page(const Report& report, const std::string& folder);

// Text with the five characters that mean something in HTML replaced: & < > " '.
std::string html_text(std::string_view text);

// Four significant digits; "not finite" for NaN and infinity.
std::string number_text(double value);

// The page's element for one panel: its caption, and <img> with the picture as a PNG data URI.
std::string panel_html(const Panel& panel);

struct PlotDrawing {
  std::string svg = {};      // an <svg> element; empty when there is none, and then
  std::string why_not = {};  // "plot TITLE: ..."
};

// Draws with gnuplot. No drawing: gnuplot is not installed or refuses, or there is nothing to draw
// (no point that is finite, and > 0 on a logarithmic axis). Throws std::runtime_error when x, y and
// y_error of a curve differ in length, or when there is no room for temporary files.
PlotDrawing draw_plot(const Plot& plot);

}  // namespace pluvia
