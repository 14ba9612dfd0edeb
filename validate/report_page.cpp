#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/page_html.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

std::string section(const std::string& title, const std::string& body) {
  return body.empty() ? "" : fmt::format("<section>\n<h2>{}</h2>\n{}</section>\n", title, body);
}

std::string verdict_html(const std::vector<Check>& checks) {
  const auto passed = std::count_if(checks.begin(), checks.end(), passes);
  const auto total = static_cast<std::ptrdiff_t>(checks.size());
  if (total == 0) return "<p class=\"verdict\">No check was made.</p>";
  std::string text = fmt::format(
      "<p class=\"verdict\">Pluvia measured itself against closed forms, ray tracing and published "
      "data: <strong class=\"{}\">{} of {} checks passed</strong>.</p>\n",
      passed == total ? "pass" : "fail", passed, total);
  if (passed == total) return text;
  text += "<div class=\"failures\">Failed:<ul>\n";
  for (const Check& check : checks) {
    if (passes(check)) continue;
    text += fmt::format("<li><span class=\"name\">{}</span>: {} {}, bound {}</li>\n",
                        html_text(check.name), number_text(check.value), html_text(check.unit),
                        number_text(check.bound));
  }
  return text + "</ul></div>\n";
}

std::string card_html(const std::string& name, const std::vector<Check>& checks) {
  const auto found = std::find_if(checks.begin(), checks.end(),
                                  [&](const Check& check) { return check.name == name; });
  if (found == checks.end()) {
    return fmt::format(
        "<div class=\"card\"><div class=\"name\">{}</div>"
        "<div class=\"value soft\">not measured</div></div>\n",
        html_text(name));
  }
  // How much of what is allowed is used up.
  const double share = found->bound > 0 ? found->value / found->bound : 1;
  return fmt::format(
      "<div class=\"card {}\"><div class=\"name\">{}</div><div class=\"value\">{} "
      "<span>{}</span></div>"
      "<div class=\"meter\"><i style=\"width:{:.0f}%\"></i></div>"
      "<p><strong class=\"{}\">{}</strong> at a bound of {} {}. {}</p></div>\n",
      passes(*found) ? "" : "fail", html_text(name), number_text(found->value),
      html_text(found->unit), std::isfinite(share) ? 100 * std::clamp(share, 0.0, 1.0) : 100.0,
      passes(*found) ? "pass" : "fail", passes(*found) ? "Passes" : "Fails",
      number_text(found->bound), html_text(found->unit), html_text(found->why));
}

std::string headlines_html(const Report& report) {
  if (report.checks.empty()) return "";
  std::string text = "<div class=\"cards\">\n";
  for (const std::string& name : report.headlines) text += card_html(name, report.checks);
  return text + "</div>\n";
}

std::string check_row(const Check& check) {
  const auto cell = [](const char* label, const std::string& value) {
    return fmt::format("<td class=\"n\" data-label=\"{}\">{}</td>", label, value);
  };
  const bool good = passes(check);
  return fmt::format("<tr{}><td class=\"mark {}\">{}</td><td class=\"name\">{}</td>",
                     good ? "" : " class=\"failed\"", good ? "pass" : "fail",
                     good ? "\u2713 pass" : "\u2717 fail", html_text(check.name)) +
         cell("measured", number_text(check.measured)) +
         cell("expected", number_text(check.expected)) +
         cell("\u00b1", check.uncertainty == 0 ? "" : number_text(check.uncertainty)) +
         cell("deviation", number_text(check.value)) + cell("bound", number_text(check.bound)) +
         cell("unit", html_text(check.unit)) +
         fmt::format("<td class=\"why\">{}</td></tr>\n", html_text(check.why));
}

// Rows grouped by what stands before the first dot of the name, groups in order of first
// appearance.
std::string checks_html(const std::vector<Check>& checks) {
  std::vector<std::pair<std::string, std::string>> groups;
  for (const Check& check : checks) {
    const std::string group = check.name.substr(0, check.name.find('.'));
    auto found = std::find_if(groups.begin(), groups.end(),
                              [&](const auto& entry) { return entry.first == group; });
    if (found == groups.end()) found = groups.insert(groups.end(), {group, ""});
    found->second += check_row(check);
  }
  if (groups.empty()) return "";
  std::string text =
      "<div class=\"scroll\"><table class=\"checks\"><thead><tr><th></th><th>check</th>"
      "<th class=\"n\">measured</th><th class=\"n\">expected</th><th class=\"n\">\u00b1</th>"
      "<th class=\"n\">deviation</th><th class=\"n\">bound</th><th class=\"n\">unit</th>"
      "<th>why</th></tr></thead>\n";
  for (const auto& [group, rows] : groups) {
    text += fmt::format("<tbody><tr class=\"group\"><th colspan=\"9\">{}</th></tr>\n{}</tbody>\n",
                        html_text(group), rows);
  }
  return text + "</table></div>\n";
}

std::string figures_html(const std::vector<Figure>& figures) {
  std::string text;
  for (const Figure& figure : figures) {
    text += fmt::format("<h3>{}</h3>\n<p>{}</p>\n<div class=\"row\">\n", html_text(figure.title),
                        html_text(figure.text));
    for (const Panel& panel : figure.panels) text += panel_html(panel);
    text += "</div>\n";
  }
  return text;
}

// What gnuplot does not draw is added to `skipped`.
std::string plots_html(const std::vector<Plot>& plots, std::vector<std::string>& skipped) {
  std::string text;
  for (const Plot& plot : plots) {
    const PlotDrawing drawing = draw_plot(plot);
    if (drawing.svg.empty()) {
      skipped.push_back(drawing.why_not);
      continue;
    }
    text += fmt::format("<figure class=\"plot\"><h3>{}</h3>\n{}</figure>\n", html_text(plot.title),
                        drawing.svg);
  }
  return text.empty() ? "" : "<div class=\"plots\">\n" + text + "</div>\n";
}

std::string table_html(const Table& table) {
  std::string text =
      fmt::format("<h3>{}</h3>\n<div class=\"scroll\"><table><thead><tr>", html_text(table.title));
  for (const std::string& cell : table.head) text += "<th>" + html_text(cell) + "</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    if (row.size() != table.head.size()) {
      throw std::runtime_error(
          fmt::format("table \"{}\": a row of {} cells; expected {} as in its head", table.title,
                      row.size(), table.head.size()));
    }
    text += "<tr>";
    for (const std::string& cell : row) text += "<td>" + html_text(cell) + "</td>";
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string list_html(const std::vector<std::string>& items) {
  if (items.empty()) return "";
  std::string text = "<ul>\n";
  for (const std::string& item : items) text += "<li>" + html_text(item) + "</li>\n";
  return text + "</ul>\n";
}

std::string commands_html(const std::vector<std::string>& commands) {
  std::string text;
  for (const std::string& command : commands) text += html_text(command) + "\n";
  return text.empty() ? "" : "<pre>" + text + "</pre>\n";
}

std::string pairs_html(const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::string text;
  for (const auto& [name, value] : pairs) {
    text += fmt::format("<dt>{}</dt><dd>{}</dd>\n", html_text(name), html_text(value));
  }
  return text.empty() ? "" : "<dl>\n" + text + "</dl>\n";
}

std::string video_html(const std::string& video, const std::string& folder,
                       std::vector<std::string>& skipped) {
  if (video.empty()) return "";
  const std::filesystem::path path(video);
  if (path.is_absolute() || !std::filesystem::is_regular_file(folder / path)) {
    skipped.push_back("video " + video + ": not there beside the report");
    return "";
  }
  return fmt::format(
      "<video controls loop muted playsinline preload=\"metadata\" src=\"{0}\"></video>\n"
      "<p class=\"video\"><a href=\"{0}\">{0}</a></p>\n",
      html_text(video));
}

// Every {{name}} of the page replaced, once: text that is put in is not looked at again.
std::string fill(std::string_view page, const std::map<std::string, std::string>& parts) {
  std::string text;
  while (true) {
    const std::size_t begin = page.find("{{");
    const std::size_t end = page.find("}}", begin == std::string_view::npos ? 0 : begin);
    if (begin == std::string_view::npos || end == std::string_view::npos) return text.append(page);
    text.append(page.substr(0, begin));
    text += parts.at(std::string(page.substr(begin + 2, end - begin - 2)));
    page.remove_prefix(end + 2);
  }
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "not finite";
}

std::string report_page(const Report& report, const std::string& folder) {
  std::vector<std::string> skipped = report.skipped;
  std::vector<std::pair<std::string, std::string>> timings;
  for (const auto& [name, seconds] : report.timings_s) {
    timings.emplace_back(name, number_text(seconds) + " s");
  }
  std::string tables;
  for (const Table& table : report.tables) tables += table_html(table);
  std::map<std::string, std::string> parts = {
      {"verdict", verdict_html(report.checks)},
      {"headlines", headlines_html(report)},
      {"video", video_html(report.video, folder, skipped)},
      {"figures", section("Pictures", figures_html(report.figures))},
      {"checks", section("Checks", checks_html(report.checks))},
      {"plots", section("Curves", plots_html(report.plots, skipped))},
      {"tables", section("Tables", tables)},
      {"timings", section("Time", pairs_html(timings))},
      {"commands", section("Commands", commands_html(report.commands))},
      {"machine", section("Machine", pairs_html(report.machine))}};
  parts["skipped"] = section("Skipped, and why", list_html(skipped));
  return fill(page_html, parts);
}

}  // namespace pluvia
