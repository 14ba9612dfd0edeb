// Smooth paths through keys, of cameras and of parts that move: cubic between the keys (Hermite
// with Catmull and Rom's tangents for uneven times), so that a path passes each key without a jump
// of velocity; at rest before the first key and after the last. Key: a struct with a member time_s;
// keys are at least one, their times ascending. Value: a number or a vector.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace pluvia {

// The last key that is not later than time_s; the first where all are later.
template <class Key>
std::size_t key_before(const std::vector<Key>& keys, double time_s) {
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time_s,
                       [](double time, const Key& key) { return time < key.time_s; });
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - keys.begin() - 1, 0));
}

// From the key before to the one after; none at the ends.
template <class Key, class Value>
Value key_velocity(const std::vector<Key>& keys, std::size_t k, Value Key::*member) {
  if (k == 0 || k + 1 == keys.size()) return keys[k].*member - keys[k].*member;
  return (keys[k + 1].*member - keys[k - 1].*member) / (keys[k + 1].time_s - keys[k - 1].time_s);
}

template <class Key, class Value>
Value along_path(const std::vector<Key>& keys, double time_s, Value Key::*member) {
  const std::size_t i = key_before(keys, time_s);
  if (time_s < keys.front().time_s || i + 1 == keys.size()) return keys[i].*member;
  const double span_s = keys[i + 1].time_s - keys[i].time_s;
  const double u = (time_s - keys[i].time_s) / span_s;
  const double h = u * u * (3 - 2 * u);
  return (1 - h) * keys[i].*member + h * keys[i + 1].*member +
         span_s * u * (1 - u) *
             ((1 - u) * key_velocity(keys, i, member) - u * key_velocity(keys, i + 1, member));
}

// Bezier's control points of the path from key i to the next, which lies in their convex hull.
template <class Key, class Value>
std::array<Value, 4> path_hull(const std::vector<Key>& keys, std::size_t i, Value Key::*member) {
  const double third_s = (keys[i + 1].time_s - keys[i].time_s) / 3;
  return {keys[i].*member, keys[i].*member + third_s * key_velocity(keys, i, member),
          keys[i + 1].*member - third_s * key_velocity(keys, i + 1, member), keys[i + 1].*member};
}

}  // namespace pluvia
