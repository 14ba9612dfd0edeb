#include "validate/sweep_page.h"

#include <algorithm>

#include <fmt/format.h>

namespace pluvia {
namespace {

std::vector<SweepPoint> by_time(std::vector<SweepPoint> points) {
  std::stable_sort(points.begin(), points.end(), [](const SweepPoint& a, const SweepPoint& b) {
    return a.time_s != b.time_s ? a.time_s < b.time_s : a.error < b.error;
  });
  return points;
}

void add_point(const SweepPoint& point, Curve& curve) {
  curve.x.push_back(point.time_s);
  curve.y.push_back(point.error);
  curve.y_error.push_back(point.standard_error);
  curve.x_low.push_back(point.low_s);
  curve.x_high.push_back(point.high_s);
}

std::string error_text(double error, double standard_error) {
  return standard_error > 0 ? fmt::format("{:.3g} +- {:.2g}", error, standard_error)
                            : fmt::format("{:.3g}", error);
}

std::vector<std::string> row_of(const SweepCurve& curve, const SweepPoint& point) {
  std::string mark = point.on_front ? "front" : "";
  if (point.setting == curve.recommended) mark += ", recommended";
  if (point.setting == curve.standard) mark += mark.empty() ? "standard" : ", standard";
  std::vector<std::string> row = {
      point.setting,
      fmt::format("{} ({} .. {})", duration_text(point.time_s), duration_text(point.low_s),
                  duration_text(point.high_s)),
      error_text(point.error, point.standard_error),
      point.noise > 0 ? fmt::format("{:.3g}", point.noise) : "",
      mark,
      point.flags};
  for (const auto& distance : point.also) row.push_back(fmt::format("{:.3g}", distance.second));
  return row;
}

}  // namespace

Plot sweep_plot(const SweepCurve& curve) {
  Plot plot = {
      .title = curve.title,
      .x_label = curve.time_label,
      .y_label = curve.error_label,
      .log_x = true,
      .log_y = true,
      .text = curve.text +
              (curve.why.empty() ? "" : " Recommended: " + curve.recommended + ". " + curve.why)};
  Curve front = {.label = "front", .style = CurveStyle::line};
  Curve recommended = {.label = "recommended", .style = CurveStyle::rings};
  std::vector<Curve> series;
  for (const SweepPoint& point : curve.points) {
    auto found = std::find_if(series.begin(), series.end(),
                              [&](const Curve& known) { return known.label == point.series; });
    if (found == series.end()) found = series.insert(series.end(), {.label = point.series});
    add_point(point, *found);
  }
  for (const SweepPoint& point : by_time(curve.points)) {
    for (Curve* mark : {&front, &recommended}) {
      const bool on = mark == &front ? point.on_front : point.setting == curve.recommended;
      if (!on) continue;
      mark->x.push_back(point.time_s);
      mark->y.push_back(point.error);
    }
  }
  plot.curves = {front};  // below the points that lie on it
  plot.curves.insert(plot.curves.end(), series.begin(), series.end());
  if (!recommended.x.empty()) plot.curves.push_back(recommended);
  return plot;
}

Table sweep_table(const SweepCurve& curve) {
  Table table = {
      curve.title,
      {"setting", curve.time_label, curve.error_label, "of it noise", "", "asked for by"},
      {}};
  for (const auto& distance : curve.points.at(0).also) table.head.push_back(distance.first);
  for (const SweepPoint& point : by_time(curve.points)) table.rows.push_back(row_of(curve, point));
  return table;
}

void add_sweep(const Sweep& sweep, Report& report) {
  for (const SweepCurve& curve : sweep.curves) {
    report.plots.push_back(sweep_plot(curve));
    report.tables.push_back(sweep_table(curve));
  }
  for (const auto& [name, text] : sweep.machine) {
    if (name == "processor") report.machine.emplace_back("curves measured on", text);
  }
  const auto& commands = sweep.commands;
  report.commands.insert(report.commands.end(), commands.begin(), commands.end());
  report.seeds.insert(report.seeds.end(), sweep.seeds.begin(), sweep.seeds.end());
  report.skipped.insert(report.skipped.end(), sweep.skipped.begin(), sweep.skipped.end());
}

std::string sweep_lead(const Sweep& sweep) {
  std::string text = "Error against time. ";
  for (const SweepCurve& curve : sweep.curves) {
    const SweepPoint* const best = find_setting(curve, curve.recommended);
    text += fmt::format("{}: {}. ", curve.name,
                        best ? fmt::format("recommended is {}, error {}", best->setting,
                                           error_text(best->error, best->standard_error))
                             : "no setting on the front can be asked for");
  }
  return text + "Nothing here is held against a bound.";
}

std::string pick_line(const SweepCurve& curve, const SweepPoint& point) {
  return fmt::format("{}: {}; {} for {}, error {}; {}\n", curve.name, point.setting,
                     duration_text(point.time_s * curve.whole_factor), curve.whole,
                     error_text(point.error, point.standard_error), point.flags);
}

std::string sweep_text(const SweepCurve& curve) {
  std::string text = fmt::format(
      "{}\n  {} against {}; {} for {}\n", curve.title, curve.error_label, curve.time_label,
      curve.whole_factor == 1 ? "a time is that"
                              : fmt::format("{:.4g} times as long", curve.whole_factor),
      curve.whole);
  for (const SweepPoint& point : by_time(curve.points)) {
    const std::vector<std::string> row = row_of(curve, point);
    text += fmt::format("  {:<46} {:<30} {:<20} {:<9} {}", row[0], row[1], row[2], row[3], row[4]);
    for (const auto& [name, value] : point.also) text += fmt::format(" {} {:.3g}", name, value);
    text += "\n";
  }
  if (!curve.recommended.empty()) {
    text += fmt::format("  recommended: {}. {}\n", curve.recommended, curve.why);
  }
  return text;
}

}  // namespace pluvia
