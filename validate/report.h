// The fidelity report: report.json for machines, index.html for people (one file, no network,
// pictures embedded as PNG).
#pragma once

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

struct Curve {
  std::string label = {};
  std::vector<double> x = {}, y = {}, y_error = {};  // y_error empty: no bars
};

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  bool log_x = false, log_y = false;
  std::vector<Curve> curves = {};
};

struct Table {
  std::string title = {};
  std::vector<std::string> head = {};
  std::vector<std::vector<std::string>> rows = {};
};

struct Report {
  std::vector<Check> checks = {};
  std::vector<Figure> figures = {};
  std::vector<Plot> plots = {};
  std::vector<Table> tables = {};
  std::vector<std::pair<std::string, double>> timings_s = {};
  std::vector<std::pair<std::string, std::string>> machine = {};
  std::vector<std::string> commands = {};  // that made all of this, in order
  std::vector<std::string> skipped = {};   // what was not done and why
  std::vector<std::string> headlines = {"sphere.energy.p2", "gn2006.log_factor_rms.osc0",
                                        "frame.composite"};  // names of the checks shown first
  std::string video = {};  // relative to the report's folder, e.g. "../frames/rain.mp4";
};                         // shown when that file exists

// Writes DIR/report.json and DIR/index.html, each atomically, whether or not checks fail.
//   {"version":1,
//   "checks":[{"name","value","bound","measured","expected","unit","pass","uncertainty",
//    "why"}], "timings_s":{..}, "machine":{..}, "commands":[..]}
// A NaN or infinity in a check is written as null and the check fails; in a picture it is shown
// magenta and counted in the caption. Equal names of timings are added up. A plot that gnuplot does
// not draw is listed under "skipped" with the reason. Throws std::runtime_error when a file cannot
// be written, when a panel has no 1 or 3 channels, no pixels or no white > 0, when a row of a table
// has not as many cells as its head, and when a curve's x, y and y_error differ in length.
void write_report(const std::string& folder, const Report& report);

// Processor name, cores, memory, compiler, library versions, program version.
std::vector<std::pair<std::string, std::string>> describe_machine();

}  // namespace pluvia
