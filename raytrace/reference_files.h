// What the reference tracer leaves on disk: the picture with its variances, and the sums that a
// later run goes on from. Both are written atomically (atlas/atomic_file.h).
#pragma once

#include <string>

#include "raytrace/reference_picture.h"

namespace pluvia {

// One part, float channels:
//   R, G, B                                   the picture, linear Rec.709, cd/m^2
//   variance.R ..                             of the mean, (cd/m^2)^2
//   rain.R .., rain.variance.R ..             the picture less the one without drops
//   coverage                                  mean over pixel and exposure of "a drop is here"
//   samples                                   that fell into the pixel
// and the attribute `passes`. sums.passes >= 2.
void write_reference(const std::string& file, const ReferenceSums& sums);

// Hexadecimal SHA-256 of all that decides the passes: scene, drops and water as resolved, options,
// and the settings that are no condition of the end.
std::string reference_fingerprint(const ReferenceScene& scene, const ReferenceSettings& settings);

void write_sums(const std::string& file, const std::string& fingerprint, const ReferenceSums& sums);

// Throws std::runtime_error "FILE: what was found; expected .." for a file that is damaged, or of
// another fingerprint.
ReferenceSums read_sums(const std::string& file, const std::string& fingerprint);

}  // namespace pluvia
