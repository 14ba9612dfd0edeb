// pluvia compare-reports on reports that the program's own writer made, and on what is none.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/run_program.h"
#include "tests/temporary_folder.h"
#include "validate/report.h"
#include "validate/report_difference.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

Check check(const std::string& name, double value, double uncertainty = 0) {
  return {.name = name,
          .value = value,
          .bound = 0.1,
          .measured = 2 + value,
          .expected = 2,
          .uncertainty = uncertainty,
          .unit = "relative",
          .why = "made up"};
}

class CompareReports : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::vector<Check>& checks) const {
    Report report;
    report.checks = checks;
    write_report(folder / name, report);
    return folder / name + "/report.json";
  }
  Outcome compared(const std::vector<Check>& before, const std::vector<Check>& after) const {
    return run_pluvia(
        fmt::format("compare-reports {} {}", write("before", before), write("after", after)));
  }
  void expect_complaint(const std::string& text, const std::string& complaint) const {
    write_file_atomically(folder / "bad.json", text);
    const Outcome outcome = run_pluvia(fmt::format(
        "compare-reports {} {}/bad.json", write("good", {check("a", 0.01)}), folder.path()));
    EXPECT_EQ(outcome.code, 1) << text;
    EXPECT_EQ(outcome.out, "") << text;
    EXPECT_THAT(outcome.err, HasSubstr(complaint)) << text;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  const TemporaryFolder folder;
};

TEST_F(CompareReports, ThatAreTheSameSayNothingButTheCount) {
  const std::vector<Check> checks = {check("a", 0.01), check("b", 0.2), check("c", std::nan(""))};
  const Outcome outcome = compared(checks, checks);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "3 checks: 0 fail now, 0 worse, 0 better, 0 pass now, 0 new; 0 gone\n");
}

TEST_F(CompareReports, TellWhatGotWorseBetterNewAndGone) {
  const Outcome outcome = compared({check("worse", 0.01), check("better", 0.05),
                                    check("fails", 0.09), check("mends", 0.2), check("gone", 0.03)},
                                   {check("new", 0.2), check("worse", 0.02), check("better", 0.04),
                                    check("fails", 0.11), check("mends", 0.05)});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out,
            "fails now   fails                            0.09 -> 0.11 relative (margin 0.001, "
            "bound 0.1)\n"
            "worse       worse                            0.01 -> 0.02 relative (margin 0.001, "
            "bound 0.1)\n"
            "better      better                           0.05 -> 0.04 relative (margin 0.001, "
            "bound 0.1)\n"
            "passes now  mends                            0.2 -> 0.05 relative (margin 0.001, "
            "bound 0.1)\n"
            "new         new                              0.2 relative (fails at a bound of 0.1)\n"
            "gone        gone                             0.03 relative (passes at a bound of "
            "0.1)\n"
            "5 checks: 1 fail now, 1 worse, 1 better, 1 pass now, 1 new; 1 gone\n");
  EXPECT_EQ(
      compared({check("a", 0.05), check("b", 0.05)}, {check("a", 0.01), check("c", 0.2)}).code, 0);
}

TEST_F(CompareReports, LeaveChangesWithinTheUncertaintyAlone) {
  // 2 sqrt(0.003^2 + 0.004^2) + 0.01 0.1 = 0.011.
  EXPECT_EQ(compared({check("a", 0.01, 0.003)}, {check("a", 0.0205, 0.004)}).code, 0);
  EXPECT_EQ(compared({check("a", 0.01, 0.003)}, {check("a", 0.0215, 0.004)}).code, 1);
  EXPECT_EQ(compared({check("a", 0.01)}, {check("a", 0.0109)}).code, 0);
  EXPECT_EQ(compared({check("a", 0.01)}, {check("a", 0.0111)}).code, 1);
  // From pass to fail counts however little it is.
  EXPECT_EQ(compared({check("a", 0.0999, 0.05)}, {check("a", 0.1001, 0.05)}).code, 1);
}

TEST(ReportDifference, TakesUncertaintyInTheUnitOfTheValue) {
  // Value in standard errors of 0.004: 1 and 2.5 with an uncertainty of 1 each, 2 sqrt 2 = 2.83.
  Check before = check("flux", 1, 0.004), after = check("flux", 2.5, 0.004);
  before.bound = after.bound = 3, before.measured = 2.004, after.measured = 2.010;
  EXPECT_TRUE(report_difference({before}, {after}).empty());
  before.value = 0, before.measured = 2, after.value = 2.9, after.measured = 2.0116;
  before.uncertainty = after.uncertainty = 0;
  EXPECT_EQ(report_difference({before}, {after}).at(0).change, Change::worse);
}

TEST(ReportDifference, ANumberThatIsNoneIsWorseThanAny) {
  Check failing = check("a", 0.2), none = check("a", std::nan(""));
  EXPECT_EQ(report_difference({failing}, {none}).at(0).change, Change::worse);
  EXPECT_EQ(report_difference({none}, {failing}).at(0).change, Change::better);
  EXPECT_TRUE(report_difference({none}, {none}).empty());
}

TEST_F(CompareReports, RefuseWhatIsNoReportInOneLine) {
  expect_complaint("{\n  \"version\": 1,\n  oops}", "bad.json:3:3: not JSON");
  expect_complaint("{\"version\": 2, \"checks\": []}", "bad.json: version 2; this program reads");
  expect_complaint("{\"version\": 1}", "bad.json: checks: missing");
  expect_complaint("{\"version\": 1, \"checks\": {}}", "checks: a JSON object; expected an array");
  const std::string first = "{\"name\": \"a\", \"value\": 1, \"bound\": 2, \"measured\": 1, ";
  const std::string rest = "\"expected\": 0, \"unit\": \"\", \"uncertainty\": 0, \"why\": \"\", ";
  const auto report = [](const std::string& checks) {
    return "{\"version\": 1, \"checks\": [" + checks + "]}";
  };
  expect_complaint(report(first + rest + "\"pass\": false}"),
                   "checks[0].pass: false; expected true: value 1, bound 2");
  expect_complaint(report(first + "\"pass\": true}"), "checks[0].expected: missing");
  const std::string good = first + rest + "\"pass\": true}";
  expect_complaint(report(good + ", " + good),
                   "checks[1].name: \"a\" as in checks[0]; expected each name once");
  expect_complaint(report("{\"name\": 3}"), "checks[0].name: 3; expected a string");
}

TEST_F(CompareReports, NeedTwoFilesThatAreThere) {
  const Outcome none = run_pluvia("compare-reports " + (folder / "a") + " " + (folder / "b"));
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("/a: cannot read"));
  EXPECT_EQ(run_pluvia("compare-reports " + (folder / "a")).code, 2);
}

}  // namespace
}  // namespace pluvia
