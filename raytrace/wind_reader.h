// The table [wind] of a scene (raytrace/scene.h).
#pragma once

#include "raytrace/scene.h"
#include "raytrace/toml_reader.h"

namespace pluvia {

// Even wind, primitives and restitution into the rain. Primitives that are all uniform and steady
// become part of the even wind: they need no state. Throws as read_scene.
void read_wind(TomlReader reader, Rain& rain);

}  // namespace pluvia
