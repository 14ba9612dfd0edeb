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

// Left for titles and for the list of what was skipped, both written after the pictures.
constexpr std::size_t text_reserve_bytes = 100'000;

std::string section(const std::string& title, const std::string& body) {
  return body.empty() ? "" : fmt::format("<section>\n<h2>{}</h2>\n{}</section>\n", title, body);
}

std::string figures_html(const std::vector<Figure>& figures, PagePictures& pictures) {
  std::string text;
  for (const Figure& figure : figures) {
    std::string panels;
    for (const Panel& panel : figure.panels) panels += panel_html(panel);
    panels = with_room("<div class=\"row\">\n" + panels + "</div>\n", figure.title, pictures);
    if (panels.empty()) continue;
    text += fmt::format("<h3>{}</h3>\n<p>{}</p>\n{}", html_text(figure.title),
                        html_text(figure.text), panels);
  }
  return text;
}

std::string comparisons_html(const std::vector<Comparison>& comparisons, PagePictures& pictures) {
  std::string text;
  for (const Comparison& comparison : comparisons) text += comparison_html(comparison, pictures);
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
    const std::string words =
        plot.text.empty() ? "" : "<figcaption>" + html_text(plot.text) + "</figcaption>\n";
    text += fmt::format("<figure class=\"plot\"><h3>{}</h3>\n{}{}</figure>\n",
                        html_text(plot.title), drawing.svg, words);
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
  PagePictures pictures;
  pictures.skipped = report.skipped;
  std::vector<std::pair<std::string, std::string>> timings;
  for (const auto& [name, seconds] : report.timings_s) {
    timings.emplace_back(name, number_text(seconds) + " s");
  }
  std::string tables;
  for (const Table& table : report.tables) tables += table_html(table);
  std::map<std::string, std::string> parts = {
      {"style", page_style},
      {"script", page_script},
      {"summary", summary_html(report)},
      {"not_covered", section("Not covered", list_html(report.not_covered))},
      {"video", video_html(report.video, folder, pictures.skipped)},
      {"checks", section("Checks", checks_html(report.checks))},
      {"methods", section("How each check is computed", methods_html(report.checks))},
      {"plots", section("Curves", plots_html(report.plots, pictures.skipped))},
      {"tables", section("Tables", tables)},
      {"timings", section("Time", pairs_html(timings))},
      {"commands", section("Commands", commands_html(report.commands))},
      {"seeds", section("Seeds", pairs_html(report.seeds))},
      {"machine", section("Machine and versions", pairs_html(report.machine))}};
  std::size_t size = sizeof page_html;
  for (const auto& [name, text] : parts) size += text.size();
  pictures.room = page_bytes - std::min(page_bytes, size + text_reserve_bytes);
  parts["comparisons"] =
      section("Pictures, compared", comparisons_html(report.comparisons, pictures));
  parts["figures"] = section("Pictures", figures_html(report.figures, pictures));
  parts["skipped"] = section("Skipped, and why", list_html(pictures.skipped));
  for (const char* name : {"comparisons", "figures", "skipped"}) size += parts.at(name).size();
  parts["size"] = fmt::format("{:.1f} MB of at most {:.0f} MB", static_cast<double>(size) / 1e6,
                              static_cast<double>(page_bytes) / 1e6);
  return fill(page_html, parts);
}

}  // namespace pluvia
