// Cost-accuracy curves (validate/sweep.h) as plots, tables and text.
#pragma once

#include <string>

#include "validate/report.h"
#include "validate/sweep.h"

namespace pluvia {

// Its series with bars both ways, the front as a line, the recommended setting in a ring; both axes
// logarithmic. A bar of an error goes one standard error to each side.
Plot sweep_plot(const SweepCurve& curve);

// All points, the cheapest first; those on the front are marked.
Table sweep_table(const SweepCurve& curve);

// A plot and a table for each curve, the processor that they were measured on, commands, seeds, and
// what was skipped.
void add_sweep(const Sweep& sweep, Report& report);

// What each curve recommends, one after the other, for a page without checks.
std::string sweep_lead(const Sweep& sweep);

// One line for a picked setting.
std::string pick_line(const SweepCurve& curve, const SweepPoint& point);

// The table as plain text.
std::string sweep_text(const SweepCurve& curve);

}  // namespace pluvia
