#include "raytrace/wind_reader.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace pluvia {
namespace {

constexpr Range place_m = {-1e6, 1e6};
constexpr double greatest_speed_m_s = 100;  // of any primitive

struct NamedKind {
  const char* name = "";
  WindKind kind = WindKind::uniform;
  double sign = 1;
};

NamedKind read_kind(TomlReader& reader, const std::string& name) {
  std::string found;
  reader.required("kind", found);
  for (const NamedKind& known :
       {NamedKind{"uniform", WindKind::uniform, 1}, NamedKind{"source", WindKind::source, 1},
        NamedKind{"sink", WindKind::source, -1}, NamedKind{"vortex", WindKind::vortex, 1},
        NamedKind{"tornado", WindKind::tornado, 1}}) {
    if (found == known.name) return known;
  }
  reader.refuse("kind", fmt::format("{}.kind = \"{}\"; expected \"uniform\", \"source\", \"sink\", "
                                    "\"vortex\" or \"tornado\"",
                                    name, found));
}

// A uniform wind is as fast as it says, the others have strengths.
const char* strength_key(const NamedKind& kind) {
  return kind.kind == WindKind::uniform ? "speed_m_s" : "strength_m2_s";
}

void refuse_gale(const TomlReader& reader, const std::string& name, const NamedKind& kind,
                 const WindPrimitive& primitive) {
  const double most_m_s = most_speed_m_s(primitive);
  if (most_m_s <= greatest_speed_m_s) return;
  reader.refuse(strength_key(kind),
                fmt::format("{}: a wind of up to {:.4g} m/s; expected at most {} m/s", name,
                            most_m_s, greatest_speed_m_s));
}

// Place, axis and strength, of a primitive or of a key of one.
WindKey read_place(TomlReader& reader, const std::string& name, const NamedKind& kind) {
  WindKey key;
  reader.optional("axis", key.axis, {-1e3, 1e3});
  if (!(key.axis.norm() > 1e-6))
    reader.refuse("axis", fmt::format("{}.axis is zero; expected the way it points", name));
  key.axis.normalize();
  if (kind.kind != WindKind::uniform) reader.required("position_m", key.position_m, place_m);
  reader.required(strength_key(kind), key.strength, {-1e6, 1e6});
  key.strength *= kind.sign;
  return key;
}

void add_key(const TomlReader& table, const std::string& name, const WindKey& key,
             std::vector<WindKey>& path) {
  if (!path.empty()) {
    if (!(key.time_s >= path.back().time_s + least_key_s))
      table.refuse("time_s", fmt::format("{}.time_s = {}; expected {} s or more after the one "
                                         "before",
                                         name, key.time_s, least_key_s));
    if (key.axis.dot(path.back().axis) < std::cos(widest_turn_rad))
      table.refuse("axis", fmt::format("{}.axis turns by more than 170 degrees; expected less from "
                                       "key to key",
                                       name));
  }
  path.push_back(key);
}

void read_path(TomlReader& reader, const std::string& name, const NamedKind& kind,
               WindPrimitive& primitive) {
  for (TomlReader& table : reader.tables("key")) {
    const std::string key_name = fmt::format("{}.key[{}]", name, primitive.path.size());
    double time_s = 0;
    table.required("time_s", time_s, {0, 1e7}, "s");
    WindKey key = read_place(table, key_name, kind);
    key.time_s = time_s;
    table.finish();
    WindPrimitive then = primitive;
    then.strength = key.strength;
    refuse_gale(table, key_name, kind, then);
    add_key(table, key_name, key, primitive.path);
  }
  if (primitive.path.size() == 1)
    reader.refuse("key",
                  fmt::format("{} has 1 key; expected 2 or more, or a place and a strength", name));
}

WindPrimitive read_primitive(TomlReader& reader, const std::string& name) {
  const NamedKind kind = read_kind(reader, name);
  WindPrimitive primitive = {.kind = kind.kind};
  if (kind.kind != WindKind::uniform)
    reader.optional("core_radius_m", primitive.core_radius_m, {0.01, 1e4}, "m");
  if (kind.kind == WindKind::tornado) {
    reader.optional("inflow", primitive.inflow, {0, 10});
    reader.optional("height_m", primitive.height_m, {0.1, 1e4}, "m");
  }
  read_path(reader, name, kind, primitive);
  const WindKey at = primitive.path.empty() ? read_place(reader, name, kind) : primitive.path[0];
  primitive.position_m = at.position_m;
  primitive.axis = at.axis;
  primitive.strength = at.strength;
  refuse_gale(reader, name, kind, primitive);
  reader.finish();
  return primitive;
}

bool is_even(const WindPrimitive& primitive) {
  return primitive.kind == WindKind::uniform && primitive.path.empty();
}

}  // namespace

void read_wind(TomlReader reader, Rain& rain) {
  std::vector<TomlReader> tables = reader.tables("primitive");
  if (tables.empty())
    reader.required("velocity_m_s", rain.wind_m_s, {-100, 100});
  else
    reader.optional("velocity_m_s", rain.wind_m_s, {-100, 100});
  for (TomlReader& table : tables)
    rain.wind.push_back(read_primitive(table, fmt::format("wind.primitive[{}]", rain.wind.size())));
  if (std::all_of(rain.wind.begin(), rain.wind.end(), is_even)) {
    for (const WindPrimitive& primitive : rain.wind)
      rain.wind_m_s += primitive.strength * primitive.axis;
    rain.wind.clear();
  } else {
    reader.optional("restitution", rain.restitution, {0, 0.9});
  }
  reader.finish();
}

}  // namespace pluvia
