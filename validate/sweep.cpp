#include "validate/sweep.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

bool dominates(const SweepPoint& a, const SweepPoint& b) {
  return a.time_s <= b.time_s && a.error <= b.error && (a.time_s < b.time_s || a.error < b.error);
}

void check_point(const SweepCurve& curve, const SweepPoint& point) {
  const auto refuse = [&](const std::string& found, const char* expected) {
    throw std::runtime_error(fmt::format("curve \"{}\": setting \"{}\": {}; expected {}",
                                         curve.name, point.setting, found, expected));
  };
  const bool time = std::isfinite(point.time_s) && point.time_s > 0;
  if (!time) refuse(fmt::format("time {} s", point.time_s), "a finite number > 0");
  const bool error = std::isfinite(point.error) && point.error >= 0;
  if (!error) refuse(fmt::format("error {}", point.error), "a finite number >= 0");
  const bool bars = point.low_s > 0 && point.low_s <= point.time_s &&
                    point.time_s <= point.high_s && std::isfinite(point.high_s);
  if (!bars) {
    refuse(
        fmt::format("times from {} to {} s, median {} s", point.low_s, point.high_s, point.time_s),
        "the median between the others, all > 0");
  }
  const auto is_spread = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!is_spread(point.standard_error) || !is_spread(point.noise)) {
    refuse(fmt::format("standard error {}, noise {}", point.standard_error, point.noise),
           "finite numbers >= 0");
  }
  const auto& known = curve.points.front().also;
  const bool alike = std::equal(point.also.begin(), point.also.end(), known.begin(), known.end(),
                                [](const auto& a, const auto& b) { return a.first == b.first; });
  if (!alike) refuse("other distances than of the first setting", "the same names");
  for (const auto& [name, value] : point.also) {
    if (!std::isfinite(value)) refuse(fmt::format("{} {}", name, value), "a finite number");
  }
}

// The points that may be picked.
std::vector<const SweepPoint*> offered(const SweepCurve& curve) {
  std::vector<const SweepPoint*> points;
  for (const SweepPoint& point : curve.points) {
    if (point.on_front && !point.flags.empty()) points.push_back(&point);
  }
  return points;
}

[[noreturn]] void refuse_pick(const SweepCurve& curve, const std::string& wish,
                              const SweepPoint* nearest) {
  if (nearest == nullptr) {
    throw std::runtime_error(fmt::format(
        "curve \"{}\": no setting on its front that pluvia can be asked for", curve.name));
  }
  throw std::runtime_error(fmt::format(
      "curve \"{}\": no setting {}; the nearest is \"{}\": {} for {}, error {:.3g}", curve.name,
      wish, nearest->setting, duration_text(nearest->time_s * curve.whole_factor), curve.whole,
      nearest->error));
}

bool cheaper(const SweepPoint* a, const SweepPoint* b) {
  return a->time_s != b->time_s ? a->time_s < b->time_s : a->error < b->error;
}

bool more_accurate(const SweepPoint* a, const SweepPoint* b) {
  return a->error != b->error ? a->error < b->error : a->time_s < b->time_s;
}

// How the standard setting stands beside the recommended one.
std::string beside_standard(const SweepCurve& curve, const SweepPoint& best) {
  const SweepPoint* standard = find_setting(curve, curve.standard);
  if (standard == nullptr) return "";
  if (standard == &best) return " It is what pluvia does unless told otherwise.";
  return fmt::format(
      " Unless told otherwise pluvia does \"{}\": {:.2g} times the time, error {:.3g} "
      "instead of {:.3g}, {} the front.",
      curve.standard, standard->time_s / best.time_s, standard->error, best.error,
      standard->on_front ? "on" : "off");
}

}  // namespace

void mark_front(SweepCurve& curve) {
  if (!(std::isfinite(curve.whole_factor) && curve.whole_factor > 0)) {
    throw std::runtime_error(fmt::format("curve \"{}\": {} times a point; expected a number > 0",
                                         curve.name, curve.whole_factor));
  }
  std::set<std::string> settings;
  for (SweepPoint& point : curve.points) {
    check_point(curve, point);
    if (!settings.insert(point.setting).second) {
      throw std::runtime_error(fmt::format("curve \"{}\": setting \"{}\" twice; expected once",
                                           curve.name, point.setting));
    }
    point.on_front = std::none_of(curve.points.begin(), curve.points.end(),
                                  [&](const SweepPoint& other) { return dominates(other, point); });
  }
}

void recommend(SweepCurve& curve) {
  const std::vector<const SweepPoint*> points = offered(curve);
  if (points.empty()) return;
  const auto cost = [](const SweepPoint* point) {
    return point->time_s * point->error * point->error;
  };
  const SweepPoint& best = **std::min_element(
      points.begin(), points.end(), [&](const SweepPoint* a, const SweepPoint* b) {
        return cost(a) != cost(b) ? cost(a) < cost(b) : cheaper(a, b);
      });
  curve.recommended = best.setting;
  curve.why = fmt::format(
      "Of the front it has the least time x error^2: a smaller error costs more than four times "
      "the "
      "time for half of it, and what is cheaper gives up more than that.{}",
      beside_standard(curve, best));
}

const SweepPoint& pick_by_time(const SweepCurve& curve, double budget_s) {
  std::vector<const SweepPoint*> points = offered(curve);
  std::stable_sort(points.begin(), points.end(), more_accurate);
  for (const SweepPoint* point : points) {
    if (point->time_s * curve.whole_factor <= budget_s) return *point;
  }
  // The cheapest of a front is its most wrong.
  refuse_pick(curve, fmt::format("takes at most {} for {}", duration_text(budget_s), curve.whole),
              points.empty() ? nullptr : points.back());
}

const SweepPoint& pick_by_error(const SweepCurve& curve, double error) {
  std::vector<const SweepPoint*> points = offered(curve);
  std::stable_sort(points.begin(), points.end(), cheaper);
  for (const SweepPoint* point : points) {
    if (point->error <= error) return *point;
  }
  refuse_pick(curve, fmt::format("has an error of at most {:.3g}", error),
              points.empty() ? nullptr : points.back());
}

const SweepPoint* find_setting(const SweepCurve& curve, const std::string& setting) {
  const auto found = std::find_if(curve.points.begin(), curve.points.end(),
                                  [&](const SweepPoint& p) { return p.setting == setting; });
  return found == curve.points.end() ? nullptr : &*found;
}

std::string duration_text(double time_s) {
  if (time_s < 1) return fmt::format("{:.3g} ms", 1e3 * time_s);
  if (time_s < 120) return fmt::format("{:.3g} s", time_s);
  if (time_s < 7200) return fmt::format("{:.3g} min", time_s / 60);
  return fmt::format("{:.3g} h", time_s / 3600);
}

}  // namespace pluvia
