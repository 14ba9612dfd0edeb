#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "validate/report_parts.h"

namespace pluvia {
namespace {

// A part of an address within the page: what is no letter, digit, dot or dash becomes a dash.
std::string anchor(const std::string& prefix, const std::string& name) {
  std::string text = prefix;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '_';
    text += plain ? c : '-';
  }
  return text;
}

std::string group_of(const Check& check) {
  return check.name.substr(0, check.name.find('.'));
}

// Checks by what stands before the first dot of their names, in order of first appearance.
std::vector<std::pair<std::string, std::vector<Check>>> groups_of(
    const std::vector<Check>& checks) {
  std::vector<std::pair<std::string, std::vector<Check>>> groups;
  for (const Check& check : checks) {
    auto found = std::find_if(groups.begin(), groups.end(),
                              [&](const auto& entry) { return entry.first == group_of(check); });
    if (found == groups.end()) found = groups.insert(groups.end(), {group_of(check), {}});
    found->second.push_back(check);
  }
  return groups;
}

std::ptrdiff_t passed_of(const std::vector<Check>& checks) {
  return std::count_if(checks.begin(), checks.end(), passes);
}

// Of the checks that measure a relative error, the one that finds most; nothing without any.
std::string largest_error_html(const std::vector<Check>& checks) {
  const Check* largest = nullptr;
  for (const Check& check : checks) {
    const bool relative = check.unit.rfind("relative", 0) == 0 && std::isfinite(check.value);
    if (relative && (!largest || check.value > largest->value)) largest = &check;
  }
  if (!largest) return "";
  return fmt::format(" The largest relative error found is {:.2g} % (<a href=\"#{}\">{}</a>).",
                     100 * largest->value, anchor("how-", largest->name), html_text(largest->name));
}

std::string verdict_html(const Report& report) {
  const std::vector<Check>& checks = report.checks;
  const auto passed = passed_of(checks), total = std::ssize(checks);
  if (total == 0) {
    return fmt::format("<p class=\"verdict\">{}</p>\n",
                       report.lead.empty() ? "No check was made." : html_text(report.lead));
  }
  return fmt::format(
      "<p class=\"verdict\"><strong class=\"{}\">{} of {} checks passed</strong>, against closed "
      "forms, ray tracing and published data: {}.{}</p>\n",
      passed == total ? "pass" : "fail", passed, total,
      passed == total ? "the rain is as true as its bounds tell"
                      : "do not trust what the failed ones judge",
      largest_error_html(checks));
}

std::string failures_html(const std::vector<Check>& checks) {
  std::string items;
  for (const Check& check : checks) {
    if (passes(check)) continue;
    items += fmt::format("<li><a class=\"name\" href=\"#{}\">{}</a>: {} {}, bound {}</li>\n",
                         anchor("check-", check.name), html_text(check.name),
                         number_text(check.value), html_text(check.unit), number_text(check.bound));
  }
  return items.empty() ? "" : "<div class=\"failures\">Failed:<ul>\n" + items + "</ul></div>\n";
}

// What is trusted and what failed, group by group; failed ones first.
std::string rungs_html(const std::vector<Check>& checks) {
  std::string failed, trusted;
  for (const auto& [group, members] : groups_of(checks)) {
    const auto passed = passed_of(members), total = std::ssize(members);
    (passed == total ? trusted : failed) +=
        fmt::format("<li class=\"{}\"><a href=\"#{}\">{}</a> {} {} of {}</li>\n",
                    passed == total ? "pass" : "fail", anchor("group-", group), html_text(group),
                    passed == total ? "\u2713" : "\u2717", passed, total);
  }
  return checks.empty() ? "" : "<ul class=\"rungs\">\n" + failed + trusted + "</ul>\n";
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
  return fmt::format(
             "<tr id=\"{}\"{}><td class=\"mark {}\">{}</td>"
             "<td class=\"name\"><a href=\"#{}\">{}</a></td>",
             anchor("check-", check.name), good ? "" : " class=\"failed\"", good ? "pass" : "fail",
             good ? "\u2713 pass" : "\u2717 fail", anchor("how-", check.name),
             html_text(check.name)) +
         cell("measured", number_text(check.measured)) +
         cell("expected", number_text(check.expected)) +
         cell("\u00b1", check.uncertainty == 0 ? "" : number_text(check.uncertainty)) +
         cell("deviation", number_text(check.value)) + cell("bound", number_text(check.bound)) +
         cell("unit", html_text(check.unit)) + "</tr>\n";
}

}  // namespace

std::string summary_html(const Report& report) {
  return verdict_html(report) + failures_html(report.checks) + rungs_html(report.checks) +
         headlines_html(report);
}

std::string checks_html(const std::vector<Check>& checks) {
  if (checks.empty()) return "";
  std::string text =
      "<p>Each name leads to how its check is computed. Deviation is compared with bound; \u00b1 "
      "is "
      "one standard error of what was measured.</p>\n"
      "<div class=\"scroll\"><table class=\"checks\"><thead><tr><th></th><th>check</th>"
      "<th class=\"n\">measured</th><th class=\"n\">expected</th><th class=\"n\">\u00b1</th>"
      "<th class=\"n\">deviation</th><th class=\"n\">bound</th><th class=\"n\">unit</th>"
      "</tr></thead>\n";
  for (const auto& [group, members] : groups_of(checks)) {
    text += fmt::format("<tbody id=\"{}\"><tr class=\"group\"><th colspan=\"8\">{}</th></tr>\n",
                        anchor("group-", group), html_text(group));
    for (const Check& check : members) text += check_row(check);
    text += "</tbody>\n";
  }
  return text + "</table></div>\n";
}

std::string methods_html(const std::vector<Check>& checks) {
  std::string text;
  for (const Check& check : checks) {
    text += fmt::format("<dt id=\"{}\"><a class=\"name\" href=\"#{}\">{}</a></dt><dd>{}</dd>\n",
                        anchor("how-", check.name), anchor("check-", check.name),
                        html_text(check.name), html_text(check.why));
  }
  return text.empty() ? "" : "<dl class=\"methods\">\n" + text + "</dl>\n";
}

}  // namespace pluvia
