// Light from a small droplet: a sphere of water in geometrical optics. Of the irradiance E on its
// cross-section, a fine incidence b of which order p leaves with Fresnel's share at the scattering
// angle of sphere optics (0: straight on), P(angle) is the share a steradian, so that its mean
// radiance over its disc is E P(angle). Diffraction is left out: it stays within a fraction of a
// degree of the light (oscillation/size_distribution.h counts each drop with Q = 1 too).
#pragma once

#include <vector>

namespace pluvia {

// Means of P over bins of equal angle from 0 to pi, 1/sr, of unpolarised light; refractive index of
// water at 589 nm. Their sum over the bins' solid angles is 1.
std::vector<double> droplet_phase(int bins);

}  // namespace pluvia
