// The fidelity report: report.json for machines, index.html for people (one file, no network,
// pictures inside).
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "atlas/image.h"
#include "validate/check.h"

namespace pluvia {

struct Panel {       // one picture with its caption
  Image image = {};  // linear, 1 or 3 channels
  double white = 1;  // value shown as white
  std::string caption = {};
  bool signed_difference =
      false;     // 1 channel: shown blue (negative) - black - red (positive), +-white
  int zoom = 1;  // integer enlargement, nearest neighbour (small streak pictures)
};

struct Figure {  // a row of panels side by side
  std::string title = {};
  std::string text = {};  // what to see in it
  std::vector<Panel> panels = {};
};

// Two pictures of one size, channels and white that the page lays over each other: a slider between
// them, one after the other, side by side, their difference, at any exposure and zoom.
struct Comparison {
  std::string title = {};
  std::string text = {};  // what to see in it
  std::string unit = {};  // of the pictures
  Panel picture = {};     // what is judged
  Panel reference = {};   // what it should be
  double gain = 1;        // by which their difference is first shown; a power of 2, 1 .. 1024
  std::vector<Panel> maps = {};  // more of the same size, 1 channel
};

// Points joined by a line, alone, only the line, or rings that mark points of other curves.
enum class CurveStyle { joined, points, line, rings };

struct Curve {
  std::string label = {};
  std::vector<double> x = {}, y = {}, y_error = {};  // y_error empty: no bars
  std::vector<double> x_low = {}, x_high = {};       // ends of bars along x; empty: none
  CurveStyle style = CurveStyle::joined;
};

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  bool log_x = false, log_y = false;
  std::vector<Curve> curves = {};
  std::string text = {};  // what to see in it
};

struct Table {
  std::string title = {};
  std::vector<std::string> head = {};
  std::vector<std::vector<std::string>> rows = {};
};

struct Report {
  std::string lead = {};  // what the page says first where no check was made
  std::vector<Check> checks = {};
  std::vector<Comparison> comparisons = {};
  std::vector<Figure> figures = {};
  std::vector<Plot> plots = {};
  std::vector<Table> tables = {};
  std::vector<std::pair<std::string, double>> timings_s = {};
  std::vector<std::pair<std::string, std::string>> machine = {};
  std::vector<std::pair<std::string, std::string>> seeds = {};  // of what is random
  std::vector<std::string> commands = {};                       // that made all of this, in order
  std::vector<std::string> skipped = {};                        // what was not done and why
  std::vector<std::string> not_covered = {};                    // what no check sees
  std::vector<std::string> headlines = {"sphere.energy.p2", "gn2006.log_factor_rms.osc0",
                                        "frame.composite"};  // names of the checks shown first
  std::string video = {};  // relative to the report's folder, e.g. "../frames/rain.mp4";
};                         // shown when that file exists

constexpr std::size_t page_bytes = 15'000'000;

// Writes DIR/report.json and DIR/index.html, each atomically, whether or not checks fail.
//   {"version":1,
//   "checks":[{"name","value","bound","measured","expected","unit","pass","uncertainty",
//    "why"}], "timings_s":{..}, "machine":{..}, "seeds":{..}, "commands":[..], "skipped":[..],
//   "not_covered":[..]}
// Pictures fill the page up to page_bytes; one that has no room there is left out and listed under
// "Skipped". The pictures of a comparison are kept as half floats (validate/report_parts.h).
// A NaN or infinity in a check is written as null and the check fails; in a picture it is shown
// magenta and counted in the caption. Equal names of timings are added up. A plot that gnuplot does
// not draw is listed under "skipped" with the reason. Throws std::runtime_error when a file cannot
// be written, when a panel has no 1 or 3 channels, no pixels or no white > 0, when the pictures of
// a comparison differ in size, channels or white, when a row of a table has not as many cells as
// its head, and when a curve's x, y and bars differ in length.
void write_report(const std::string& folder, const Report& report);

// Processor name, cores, memory, compiler, library versions, program version.
std::vector<std::pair<std::string, std::string>> describe_machine();

}  // namespace pluvia
