// `pluvia compare-reports`: what two reports say differently.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace pluvia {

struct CompareReportsFlags {
  std::string before = {}, after = {};
};

CLI::App* add_compare_reports(CLI::App& app, CompareReportsFlags& flags);

struct ReportComparison {
  std::string text = {};  // lines of changes (validate/report_difference.h), then one of counts
  bool regression = false;
};

// Throws std::runtime_error for files that are no reports.
ReportComparison compare_reports(const CompareReportsFlags& flags);

}  // namespace pluvia
