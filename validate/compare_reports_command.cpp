#include "validate/compare_reports_command.h"

#include <algorithm>

#include <fmt/format.h>

#include "validate/report_difference.h"

namespace pluvia {

CLI::App* add_compare_reports(CLI::App& app, CompareReportsFlags& flags) {
  CLI::App* command = app.add_subcommand(
      "compare-reports", "tell which checks got worse, better, are new or gone; exit 1 for worse");
  command->add_option("before", flags.before, "report.json")->required();
  command->add_option("after", flags.after, "report.json")->required();
  command->footer("example: pluvia compare-reports old/report.json new/report.json");
  return command;
}

ReportComparison compare_reports(const CompareReportsFlags& flags) {
  const auto before = read_report_checks(flags.before), after = read_report_checks(flags.after);
  const auto changes = report_difference(before, after);
  ReportComparison result;
  for (const CheckChange& change : changes) result.text += change_line(change) + "\n";
  const auto count = [&](Change kind) {
    return std::count_if(changes.begin(), changes.end(),
                         [&](const CheckChange& change) { return change.change == kind; });
  };
  const auto fail = count(Change::fails_now), worse = count(Change::worse);
  result.regression = fail + worse > 0;
  result.text +=
      fmt::format("{} checks: {} fail now, {} worse, {} better, {} pass now, {} new; {} gone\n",
                  after.size(), fail, worse, count(Change::better), count(Change::passes_now),
                  count(Change::appeared), count(Change::gone));
  return result;
}

}  // namespace pluvia
