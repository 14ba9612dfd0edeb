// The parts that write_report (validate/report.h) is made of.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

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

// The page's first screen: the verdict, what failed, what is trusted, the headlines.
std::string summary_html(const Report& report);

// The table of checks, each with a link to its entry in methods_html, whose text is its `why`.
std::string checks_html(const std::vector<Check>& checks);
std::string methods_html(const std::vector<Check>& checks);

std::string base64(const std::vector<unsigned char>& bytes);

// The page's element for one panel: its caption, and <img> with the picture as a PNG data URI.
std::string panel_html(const Panel& panel);

// A picture of any range for the page's script, which validate/picture.js unpacks. A value is h
// 2^e, h its nearest half float (IEEE 754 binary16) and e one for the picture, with the largest h
// in [2^14, 2^15): a value is off by at most 2^-11 of itself (0.05 %), or by 2^-39 of the largest
// where that is more. Not finite stays not finite.
struct PackedPicture {
  int exponent = 0;  // e
  // A zlib stream (RFC 1950) of the channels one after the other, rows from the top; each h as its
  // bits less those of its left neighbour, modulo 2^16; all high bytes of a channel, then all low.
  std::vector<unsigned char> bytes = {};
};
PackedPicture pack_picture(const Image& image);

// What the page has pictures for, and room for more.
struct PagePictures {
  std::size_t room = page_bytes;          // bytes that may still be put in
  std::vector<std::string> packed = {};   // those that the script unpacks, each once
  std::vector<std::string> skipped = {};  // what had no room
};

// Takes the room for `html`, or returns "" and lists `name` as skipped.
std::string with_room(std::string html, const std::string& name, PagePictures& pictures);

// The page's element for a comparison: the pictures as PNG, for paper and where no script runs, and
// what the script needs to show them in full.
std::string comparison_html(const Comparison& comparison, PagePictures& pictures);

struct PlotDrawing {
  std::string svg = {};      // an <svg> element; empty when there is none, and then
  std::string why_not = {};  // "plot TITLE: ..."
};

// Draws with gnuplot. No drawing: gnuplot is not installed or refuses, or there is nothing to draw
// (no point that is finite, and > 0 on a logarithmic axis). Throws std::runtime_error when x, y and
// bars of a curve differ in length, or when there is no room for temporary files.
PlotDrawing draw_plot(const Plot& plot);

}  // namespace pluvia
