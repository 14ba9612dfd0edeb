// Cost-accuracy curves: what settings of one thing (the generator, the drop's model, the atlas, the
// renderer) take in time, and how far each is from a better one, both measured in the same run.
//
// A point is dominated by another that is at most as dear and at most as wrong, and better in one
// of the two. The points that none dominates are the Pareto front; points equal in both are on it
// together. Fronts are drawn through the medians: their bars tell how sure a place on it is.
//
// Times are those of one machine, at one time: compare within a curve and with nothing else. Errors
// are the same for the same seeds on any machine.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pluvia {

struct SweepPoint {
  std::string series = {};   // which line of the plot it lies on: what is varied
  std::string setting = {};  // as a person says it; once in a curve
  std::string flags =
      {};             // what to give pluvia for it; empty: nothing a user of pluvia can ask for
  double time_s = 0;  // median of the repeats, > 0
  double low_s = 0, high_s = 0;  // least and greatest of them
  double error = 0;              // >= 0
  double standard_error = 0;     // of error: what another reference would move it by; 0: exact
  double noise =
      0;  // the part of error that another seed would change; the rest, in squares, is bias
  bool on_front = false;
  // Other distances of the same pictures, the same names in all points of a curve.
  std::vector<std::pair<std::string, double>> also = {};
};

struct SweepCurve {
  std::string name = {};  // "generator", "drop", "atlas", "renderer", ..
  std::string title = {}, time_label = {}, error_label = {},
              text = {};  // text: how it was measured
  // What a time that a user gives is a limit of, such as "a database of 50 shards on 2 cores", and
  // how many times a point's time that takes.
  std::string whole = {};
  double whole_factor = 1;  // > 0
  std::vector<SweepPoint> points = {};
  std::string standard = {};     // the setting that pluvia has unless told otherwise; may be empty
  std::string recommended = {};  // a setting on the front; empty: none that can be asked for
  std::string why = {};          // it is recommended
};

struct Sweep {
  std::vector<SweepCurve> curves = {};
  std::vector<std::pair<std::string, std::string>> machine = {}, seeds = {};
  std::vector<std::string> commands = {}, skipped = {};
};

// Sets on_front of every point. Throws std::runtime_error for a time that is not finite and > 0, an
// error that is not finite and >= 0, bars that do not hold their point, settings that are not told
// apart, and for distances of other names in one point than in another.
void mark_front(SweepCurve& curve);

// Among the points of the front with flags, the one of least time x error^2: by the law of noise,
// to halve the error is worth four times the time; from there on it costs more, and before it less.
// Equal: the cheapest. Sets recommended and why, with what the standard setting is beside it.
// Precondition: mark_front.
void recommend(SweepCurve& curve);

// Of the points on the front with flags: the most accurate whose whole takes at most budget_s; the
// cheapest whose error is at most `error`. Equal: the cheaper, the more accurate, the earlier.
// Throws std::runtime_error when there is none: tells the nearest.
const SweepPoint& pick_by_time(const SweepCurve& curve, double budget_s);
const SweepPoint& pick_by_error(const SweepCurve& curve, double error);

// The point of a setting; nullptr: there is none.
const SweepPoint* find_setting(const SweepCurve& curve, const std::string& setting);

// "4.2 min", "0.31 s", "12 ms": three digits at most.
std::string duration_text(double time_s);

}  // namespace pluvia
